// rtl/output_register.sv in the iCE40's pin: PIN_TYPE 0101 is a registered output, always driven; 01 an input that nobody reads.
module output_register (
    input  logic clk,
    input  logic next,
    output logic pin
);
    /* verilator lint_off PINMISSING */
    SB_IO #(.PIN_TYPE(6'b0101_01)) cell_of_pin (
        .PACKAGE_PIN(pin),
        .OUTPUT_CLK(clk),
        .D_OUT_0(next)
    );
    /* verilator lint_on PINMISSING */
endmodule
