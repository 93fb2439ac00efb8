// rtl/scan_timer.sv for proofs: while the port runs a scan is due whenever the solver likes. That it is due every period, and
// not before the one before is over, is proved in ../scans.sv; abstract/ad7949_master.sv takes it for granted.
module scan_timer #(
    parameter int CLOCKS_PER_US = 24
) (
    input  logic        clk,
    input  logic        rst_n,
    input  logic        run,
    input  logic        abandon,
    input  logic [19:0] period_us,
    output logic        scan_due
);
    (* anyseq *) logic is_time;
    always_ff @(posedge clk) scan_due <= rst_n && run && !abandon && is_time;
endmodule
