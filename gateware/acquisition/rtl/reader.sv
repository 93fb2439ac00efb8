// Puts the next word to be sent in front of the SPI slave: a register, or the burst's next.
//
// A word of the burst is fetched in two halves of 16 bits, which is how the memories hold them, and goes through the CRC
// while it is sent. The CRC is over what was meant to be sent: should a master clock faster than 10 MHz and catch a word
// half changed, its CRC does not match.
module reader (
    input  logic        clk,
    input  logic        rst_n,

    // A transfer begins: whatever the one before left behind is forgotten.
    input  logic        head_in,
    input  logic        fetch,
    input  logic        is_burst,
    input  logic [31:0] register_word,
    output logic [31:0] transmit,
    output logic        settled,

    // The set, if one is being read; without one, the burst's words are 0.
    input  logic        reading,
    input  logic [31:0] number,
    input  logic [9:0]  length,
    input  logic        lost_before,
    input  logic [31:0] lost_at_read,

    // {channel, part}, see accumulator.sv.
    output logic [4:0]  sum_address,
    input  logic [15:0] sum_half,
    // {scan, channel}
    output logic [10:0] sample_address,
    input  logic [15:0] sample
);
    // The burst: words 0 to 14, their CRC, samples, their CRC, zeros.
    localparam logic [10:0] HEADER_CRC = 11'd15;
    localparam logic [10:0] FIRST_OF_SAMPLES = 11'd16;

    typedef enum logic [1:0] {IDLE, HIGH, LOW, PAUSE} state_t;

    state_t      state;
    logic        is_wanted;
    logic [10:0] place, pair, last_pair;
    logic        is_over;
    logic        is_crc, wants_low;
    logic [15:0] half;
    logic [31:0] crc;
    logic        crc_busy, crc_start, crc_clear;

    assign pair      = place - FIRST_OF_SAMPLES;
    assign last_pair = {length, 1'b0};
    assign is_crc    = place == HEADER_CRC || (place >= FIRST_OF_SAMPLES && pair == last_pair);

    // In HIGH the memories deliver the high half and are asked for the low one.
    assign wants_low      = state == HIGH;
    assign sample_address = {pair[9:0], wants_low};

    logic [2:0] square_word;

    // Words 3 to 6 are the sums, 7 to 14 the sums of squares, two words a channel.
    assign square_word = place[2:0] - 3'd7;

    always_comb begin
        if (place < 11'd7) sum_address = {place[1:0] - 2'd3, 2'b00, !wants_low};
        else sum_address = {square_word[2:1], square_word[0] ? {2'b01, !wants_low} : {2'b10, !wants_low}};
    end

    logic [15:0] number_half, lost_half, crc_half, length_half;

    assign number_half = state == HIGH ? number[31:16] : number[15:0];
    assign lost_half   = state == HIGH ? lost_at_read[31:16] : lost_at_read[15:0];
    assign crc_half    = state == HIGH ? crc[31:16] : crc[15:0];
    assign length_half = state == HIGH ? {6'd0, length} : {15'd0, lost_before};

    always_comb begin
        if (!reading || is_over) half = 16'd0;
        else if (is_crc) half = crc_half;
        else if (place >= FIRST_OF_SAMPLES) half = sample;
        else begin
            case (place[3:0])
                4'd0: half = number_half;
                4'd1: half = length_half;
                4'd2: half = lost_half;
                default: half = sum_half;
            endcase
        end
    end

    always_ff @(posedge clk) begin
        crc_start <= 1'b0;
        crc_clear <= 1'b0;
        if (!rst_n || head_in) begin
            state     <= IDLE;
            is_wanted <= 1'b0;
            place     <= 11'd0;
            is_over   <= 1'b0;
            crc_clear <= 1'b1;
            if (!rst_n) transmit <= 32'd0;
        end else begin
            if (fetch) is_wanted <= 1'b1;
            case (state)
                // The CRC still reads the word before for a while, in the first word of a burst.
                IDLE: if ((fetch || is_wanted) && !crc_busy) begin
                    is_wanted <= 1'b0;
                    if (is_burst) state <= HIGH;
                    else transmit <= register_word;
                end
                HIGH: begin
                    transmit[31:16] <= half;
                    state           <= LOW;
                end
                LOW: begin
                    transmit[15:0] <= half;
                    state          <= PAUSE;
                    crc_start      <= !is_crc;
                    crc_clear      <= is_crc;
                    place          <= is_over ? place : place + 11'd1;
                    is_over        <= is_over || (is_crc && place != HEADER_CRC);
                end
                // The CRC's `busy` is up only after this one.
                PAUSE: state <= IDLE;
                default: state <= IDLE;
            endcase
        end
    end

    assign settled = state == IDLE && !is_wanted && !fetch;

    crc32 of_words(.clk, .clear(crc_clear), .start(crc_start), .word(transmit), .busy(crc_busy), .crc);
endmodule
