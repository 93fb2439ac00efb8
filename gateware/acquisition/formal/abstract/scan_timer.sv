// rtl/scan_timer.sv for proofs: while the port runs a pass is due whenever the solver likes, and as many make a scan as it
// likes. That it is due in time, and not before the one before is over, is proved in ../scans.sv; abstract/ad7949_master.sv takes it for granted.
module scan_timer #(
    parameter int CLOCKS_PER_US = 24
) (
    input  logic        clk,
    input  logic        rst_n,
    input  logic        run,
    input  logic        abandon,
    input  logic [19:0] period_us,
    input  logic [2:0]  halvings,
    output logic        pass_due,
    output logic        is_first,
    output logic        is_last
);
    (* anyseq *) logic is_time, any_first, any_last;
    always_ff @(posedge clk) pass_due <= rst_n && run && !abandon && is_time;
    assign {is_first, is_last} = {any_first, any_last};
endmodule
