// CRC-32/MPEG-2 after one bit more: polynomial 0x04C11DB7, not reflected. It begins with all ones and is not inverted.
module crc32_bit (
    input  logic [31:0] crc,
    input  logic        taken,
    output logic [31:0] after
);
    localparam logic [31:0] POLYNOMIAL = 32'h04C1_1DB7;

    assign after = {crc[30:0], 1'b0} ^ (crc[31] != taken ? POLYNOMIAL : 32'd0);
endmodule
