// The acquisition block on an iCEBreaker (1BitSquared, V1.0e; iCE40 UP5K, SG48). Pins: icebreaker.pcf.
module icebreaker (
    input  logic clk_12mhz,
    input  logic button_n,

    input  logic spi_sck,
    input  logic spi_csn,
    input  logic spi_mosi,
    output logic spi_miso,
    output logic data_ready,
    output logic scan_ready,
    output logic led_green_n,

    output logic adc_cnv,
    output logic adc_sck,
    output logic adc_din,
    input  logic adc_sdo
);
    // 12 MHz from the board's oscillator, times 64, over 32: 24 MHz (`icepll -i 12 -o 24`). The FPGA's own oscillator would
    // do without a part, but is good to 10 % only, and so would the scan period be.
    logic clk, locked;

    SB_PLL40_PAD #(
        .FEEDBACK_PATH("SIMPLE"),
        .DIVR(4'b0000),
        .DIVF(7'b0111111),
        .DIVQ(3'b101),
        .FILTER_RANGE(3'b001)
    ) pll (
        .PACKAGEPIN(clk_12mhz),
        .PLLOUTGLOBAL(clk),
        .LOCK(locked),
        .RESETB(1'b1),
        .BYPASS(1'b0)
    );

    // Pin 44 is the global buffer G6's: SCK reaches all its flip-flops at about the same time.
    logic sck;

    SB_GB_IO #(.PIN_TYPE(6'b0000_01)) sck_pin (
        .PACKAGE_PIN(spi_sck),
        .GLOBAL_BUFFER_OUTPUT(sck)
    );

    // MISO may be shared with other parts on the bus: driven only while we are selected. It has no register in its cell: chip
    // select, which no clock of ours sees in time, has to reset it, and a cell has no reset.
    logic miso;

    /* verilator lint_off PINMISSING */
    SB_IO #(.PIN_TYPE(6'b1010_01)) miso_pin (
        .PACKAGE_PIN(spi_miso),
        .OUTPUT_ENABLE(!spi_csn),
        .D_OUT_0(miso)
    );
    /* verilator lint_on PINMISSING */

    // Reset: from power-up until the clock has been good for 255 periods, and while the button is pressed.
    logic       released;
    logic [7:0] good_clocks;
    logic       rst_n;

    synchroniser from_button(.clk, .from_outside(locked && button_n), .level(released));

    initial good_clocks = 8'd0;
    always_ff @(posedge clk) begin
        if (!released) good_clocks <= 8'd0;
        else if (!rst_n) good_clocks <= good_clocks + 8'd1;
    end
    assign rst_n = good_clocks == 8'hFF;

    logic waiting;

    acquisition block (
        .clk, .rst_n,
        .spi_sck(sck), .spi_csn, .spi_mosi, .spi_miso(miso), .data_ready, .scan_ready, .waiting,
        .adc_cnv, .adc_sck, .adc_din, .adc_sdo
    );

    assign led_green_n = !waiting;
endmodule
