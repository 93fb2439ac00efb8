// CRC-32/MPEG-2 of words, bit-serial in the order of the wire.
//
// A word takes 32 clocks. The wire takes 32 of its own for it, and those are longer, so this is always done in time.
module crc32 (
    input  logic        clk,
    input  logic        clear,
    // The word is held still for 32 clocks from here on.
    input  logic        start,
    input  logic [31:0] word,
    output logic        busy,
    output logic [31:0] crc
);
    logic [4:0]  place;
    logic [31:0] after;

    crc32_bit step(.crc, .taken(word[place]), .after);

    always_ff @(posedge clk) begin
        if (clear) begin
            busy <= 1'b0;
            crc  <= 32'hFFFF_FFFF;
        end else if (start) begin
            busy  <= 1'b1;
            place <= 5'd31;
        end else if (busy) begin
            crc   <= after;
            place <= place - 5'd1;
            busy  <= place != 5'd0;
        end
    end
endmodule
