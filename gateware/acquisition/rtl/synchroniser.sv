// Brings one bit from another clock, or from none, into `clk`'s domain: two flip-flops, the first of which may be
// undecided for a while.
//
// Only single bits and toggles pass through here. A word crosses beside a toggle: it has been still for two clocks when
// the toggle's change is seen.
module synchroniser (
    input  logic clk,
    input  logic from_outside,
    output logic level
);
    logic undecided;

    // No reset: what is outside goes on while we are reset, and an edge must not appear only because reset ends.
    initial begin
        undecided = 1'b0;
        level     = 1'b0;
    end

    always_ff @(posedge clk) level <= undecided;

`ifdef SYNTHESIS
    always_ff @(posedge clk) undecided <= from_outside;
`else
    // In silicon an input that changes near the clock's edge is taken as it was before or after. A simulator always takes
    // the one; so that nothing comes to rely on it, every change here is seen at once or one clock later, by lot.
    logic earlier;
    initial earlier = 1'b0;
    always_ff @(posedge clk) begin
        earlier   <= from_outside;
        undecided <= (from_outside != earlier && $urandom_range(1) == 1) ? earlier : from_outside;
    end
`endif
endmodule
