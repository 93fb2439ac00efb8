// rtl/synchroniser.sv for proofs: an input that changes near the clock's edge is seen at once or a clock later, as the
// solver likes.
module synchroniser (
    input  logic clk,
    input  logic from_outside,
    output logic level
);
    (* anyseq *) logic is_late;
    logic undecided, earlier;

    initial begin
        undecided = 1'b0;
        level     = 1'b0;
        earlier   = 1'b0;
    end

    always_ff @(posedge clk) begin
        earlier   <= from_outside;
        undecided <= is_late ? earlier : from_outside;
        level     <= undecided;
    end
endmodule
