// The slave asks whether the CRC over the bytes and what was sent as their CRC is 0 (rtl/spi_slave.sv): it is so where that was
// their CRC and nowhere else.
module crc (
    input logic clk,
    input logic [31:0] of_bytes,
    input logic [31:0] sent
);
    logic [31:0] crc [33];
    assign crc[0] = of_bytes;
    for (genvar bit_ = 0; bit_ < 32; bit_++) begin : steps
        crc32_bit step(.crc(crc[bit_]), .taken(sent[31 - bit_]), .after(crc[bit_ + 1]));
    end
    always_ff @(posedge clk) assert ((crc[32] == 32'd0) == (sent == of_bytes));
endmodule
