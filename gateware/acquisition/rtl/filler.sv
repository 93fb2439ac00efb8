// Counts scans into sets: which scan of the set is being taken, when the set is full, and the settings it is taken by.
module filler (
    input  logic        clk,
    input  logic        rst_n,

    input  logic        run,
    input  logic        abandon,
    input  logic [19:0] written_period_us,
    input  logic [9:0]  written_length,
    input  logic [2:0]  written_halvings,

    // The scan's last pass begins, which brings its samples.
    input  logic        scan_due,
    // The last channel's sample has been added.
    input  logic        scan_done,

    output logic [19:0] period_us,
    output logic [9:0]  length,
    output logic [2:0]  halvings,
    // The scan within the set.
    output logic [8:0]  scan,
    // The samples that come belong to the set; not so those of a scan that was under way when its set was dropped.
    output logic        taking,
    output logic        set_full
);
    logic scan_taken, is_last;

    assign is_last    = {1'b0, scan} == length - 10'd1;
    assign scan_taken = scan_done && taking && !abandon;
    assign set_full   = scan_taken && is_last;

    always_ff @(posedge clk) begin
        if (!rst_n || abandon) begin
            taking <= 1'b0;
            scan   <= 9'd0;
        end else if (scan_due) begin
            taking <= run;
        end else if (scan_taken) begin
            taking <= 1'b0;
            scan   <= is_last ? 9'd0 : scan + 9'd1;
        end

        // Settings are taken up where a set starts and nowhere else.
        if (!rst_n || abandon || set_full) begin
            period_us <= written_period_us;
            length    <= written_length;
            halvings  <= written_halvings;
        end
    end

`ifndef SYNTHESIS
    assert property (@(posedge clk) disable iff (!rst_n) {1'b0, scan} < length);
    assert property (@(posedge clk) disable iff (!rst_n)
        $past(rst_n) && !$past(abandon) && !$past(set_full) |-> $stable(length) && $stable(period_us)
            && $stable(halvings));
`endif
endmodule
