// The flip-flop of an output pin. This one is for simulation and proofs; a board puts the one in its pin's cell in its place
// (board/output_register.sv), whose delay to the pin no placement changes. Cells have no reset: they start at 0, and the next
// clock brings what is right.
module output_register (
    input  logic clk,
    input  logic next,
    output logic pin
);
    always_ff @(posedge clk) pin <= next;
endmodule
