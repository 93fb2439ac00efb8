// The ports of the iCE40 primitives that icebreaker.sv uses, for lint only: the synthesiser has its own.
/* verilator lint_off DECLFILENAME */
/* verilator lint_off UNUSEDPARAM */
/* verilator lint_off UNUSEDSIGNAL */
/* verilator lint_off UNDRIVEN */
module SB_PLL40_PAD #(
    parameter FEEDBACK_PATH = "SIMPLE",
    parameter logic [3:0] DIVR = 4'd0,
    parameter logic [6:0] DIVF = 7'd0,
    parameter logic [2:0] DIVQ = 3'd0,
    parameter logic [2:0] FILTER_RANGE = 3'd0
) (
    input  logic PACKAGEPIN,
    output logic PLLOUTGLOBAL,
    output logic LOCK,
    input  logic RESETB,
    input  logic BYPASS
);
endmodule

module SB_GB_IO #(
    parameter logic [5:0] PIN_TYPE = 6'd0
) (
    input  logic PACKAGE_PIN,
    output logic GLOBAL_BUFFER_OUTPUT
);
endmodule

module SB_IO #(
    parameter logic [5:0] PIN_TYPE = 6'd0
) (
    output logic PACKAGE_PIN,
    input  logic OUTPUT_CLK,
    input  logic OUTPUT_ENABLE,
    input  logic D_OUT_0
);
endmodule
