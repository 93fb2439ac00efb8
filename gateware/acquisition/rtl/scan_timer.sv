// Says when the A/D is to convert: `2^halvings` passes a scan, evenly spread, the last of them every `period_us` microseconds
// while the port runs. The first scan's passes spread over the first period after the start.
//
// A period is no multiple of its passes: 3000 us are 16 times 187 and 12 over. A pass comes with the first microsecond that is
// not too early, so none is off by a whole one and a scan's last is off by nothing.
module scan_timer #(
    // 24 on the board. Simulations may take fewer, to have more scans in a second of theirs.
    parameter int CLOCKS_PER_US = 24
) (
    input  logic        clk,
    input  logic        rst_n,
    input  logic        run,
    input  logic        abandon,
    input  logic [19:0] period_us,
    input  logic [2:0]  halvings,
    output logic        pass_due,
    // With `pass_due`: it is the scan's first pass, and its last. Of a scan of one pass it is both.
    output logic        is_first,
    output logic        is_last
);
    localparam int BITS = CLOCKS_PER_US == 1 ? 1 : $clog2(CLOCKS_PER_US);
    localparam logic [BITS-1:0] LAST = BITS'(CLOCKS_PER_US - 1);

    logic [BITS-1:0] clocks;
    logic [19:0]     since_us, whole_us, last_us;
    // Counted in parts of a microsecond, 2^halvings to one: what the period has over, and how late the last pass was.
    logic [3:0]      parts, over, late;
    logic [3:0]      passes;

    assign parts    = 4'hF >> (3'd4 - halvings);
    assign whole_us = period_us >> halvings;
    assign over     = period_us[3:0] & parts;

    always_ff @(posedge clk) begin
        pass_due <= 1'b0;
        // A clock behind what it is made of, and looked at a hundred microseconds later.
        last_us  <= over > late ? whole_us : whole_us - 20'd1;
        if (!rst_n || !run || abandon) begin
            clocks   <= '0;
            since_us <= 20'd0;
            late     <= 4'd0;
            passes   <= 4'd0;
        end else if (clocks != LAST) begin
            clocks <= clocks + 1'b1;
        end else begin
            clocks <= '0;
            if (since_us == last_us) begin
                since_us <= 20'd0;
                late     <= (late - over) & parts;
                passes   <= (passes + 4'd1) & parts;
                pass_due <= 1'b1;
                is_first <= passes == 4'd0;
                is_last  <= passes == parts;
            end else begin
                since_us <= since_us + 20'd1;
            end
        end
    end

`ifndef SYNTHESIS
    // New settings are taken up when a set is full, which is when a scan ends: well within the shortest time from pass to pass,
    // and with nothing late.
    assert property (@(posedge clk) disable iff (!rst_n) since_us <= whole_us);
    assert property (@(posedge clk) disable iff (!rst_n) passes == 4'd0 |-> late == 4'd0);
    assert property (@(posedge clk) disable iff (!rst_n) late <= parts && passes <= parts);
`endif
endmodule
