// Says when a scan is due: every `period_us` microseconds while the port runs, the first one period after the start.
module scan_timer #(
    // 24 on the board. Simulations may take fewer, to have more scans in a second of theirs.
    parameter int CLOCKS_PER_US = 24
) (
    input  logic        clk,
    input  logic        rst_n,
    input  logic        run,
    input  logic        abandon,
    input  logic [19:0] period_us,
    output logic        scan_due
);
    localparam int BITS = CLOCKS_PER_US == 1 ? 1 : $clog2(CLOCKS_PER_US);
    localparam logic [BITS-1:0] LAST = BITS'(CLOCKS_PER_US - 1);

    logic [BITS-1:0] clocks;
    logic [19:0]     elapsed_us;

    always_ff @(posedge clk) begin
        scan_due <= 1'b0;
        if (!rst_n || !run || abandon) begin
            clocks     <= '0;
            elapsed_us <= 20'd0;
        end else if (clocks != LAST) begin
            clocks <= clocks + 1'b1;
        end else begin
            clocks <= '0;
            if (elapsed_us == period_us - 20'd1) begin
                elapsed_us <= 20'd0;
                scan_due   <= 1'b1;
            end else begin
                elapsed_us <= elapsed_us + 20'd1;
            end
        end
    end

`ifndef SYNTHESIS
    // A new period is taken up when a set is full, which is when a scan ends: well within the shortest period.
    assert property (@(posedge clk) disable iff (!rst_n) elapsed_us < period_us);
`endif
endmodule
