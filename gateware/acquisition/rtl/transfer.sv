// One transfer on the port: its address, whether it writes, reads registers or reads the set, and when it is over.
//
// Whatever arrives, in whatever order, ends in a state that the next head puts right: a word that belongs to no head is
// ignored, and a head without a chip select before it (high for less than two clocks of ours, or a glitch) closes the
// transfer that was open.
module transfer (
    input  logic       clk,
    input  logic       rst_n,

    input  logic [7:0] head,
    input  logic       head_in,
    input  logic       word_begins,
    input  logic       word_ends,
    input  logic       deselected,
    // The second word that ended is the CRC of all before it.
    input  logic       is_sound,

    // A register: to be written, or to be read next. `beyond`: none of the first sixteen.
    output logic [3:0] address,
    output logic       beyond,
    output logic       write,
    output logic       fetch,

    output logic       is_burst,
    output logic       read_begins,
    output logic       read_ends,
    output logic       release_set
);
    localparam logic [7:0] READ_SET = 8'h10;
    // Words 0 to 15 sent, the set is released at the end.
    localparam logic [4:0] HEADER_WORDS = 5'd16;

    // The word and its CRC.
    localparam logic [4:0] WRITTEN_WORDS = 5'd2;

    logic       is_open, is_write, is_within;
    logic [4:0] words;
    logic       header_sent, both_came, stays_within, closes, advances;

    assign read_begins = head_in && head == READ_SET;
    assign closes      = is_open && (deselected || head_in);
    assign read_ends   = closes && is_burst;

    // The end of a word and chip select may be seen in the same clock.
    assign header_sent = words == HEADER_WORDS || (words == HEADER_WORDS - 5'd1 && word_ends);
    assign release_set = read_ends && header_sent;

    // A write counts whole: its two words, and not a bit more.
    assign both_came    = word_ends ? words == WRITTEN_WORDS - 5'd1 : words == WRITTEN_WORDS;
    assign stays_within = word_begins || (is_within && !word_ends);
    assign write        = closes && is_write && both_came && !stays_within && is_sound;

    // A read fetches one word ahead, as soon as the word before it has gone to the shift register.
    assign advances = is_open && !is_write && word_begins;

    always_ff @(posedge clk) begin
        fetch <= rst_n && ((head_in && !head[7]) || advances);
        if (!rst_n) begin
            is_open   <= 1'b0;
            is_write  <= 1'b0;
            is_burst  <= 1'b0;
            is_within <= 1'b0;
            address   <= 4'd0;
            beyond    <= 1'b0;
            words     <= 5'd0;
        end else if (head_in) begin
            is_open   <= 1'b1;
            is_write  <= head[7];
            is_burst  <= read_begins;
            is_within <= 1'b0;
            address   <= head[3:0];
            beyond    <= head[6:4] != 3'd0;
            words     <= 5'd0;
        end else begin
            if (deselected) is_open <= 1'b0;
            is_within <= stays_within;
            if (word_ends && words != HEADER_WORDS) words <= words + 5'd1;
            if (advances) begin
                address <= address + 4'd1;
                // Sticks: an address that ran past the registers never comes round to them.
                beyond <= beyond || address == 4'd15;
            end
        end
    end
endmodule
