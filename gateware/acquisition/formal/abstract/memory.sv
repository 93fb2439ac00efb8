// rtl/memory.sv for proofs: reads anything. What is proved is who writes where and when, not what.
module memory #(
    parameter int WIDTH = 16,
    parameter int ADDRESS_BITS = 8
) (
    input  logic                    clk,
    input  logic                    write,
    input  logic [ADDRESS_BITS-1:0] write_address,
    input  logic [WIDTH-1:0]        write_data,
    input  logic [ADDRESS_BITS-1:0] read_address,
    output logic [WIDTH-1:0]        read_data
);
    (* anyseq *) logic [WIDTH-1:0] anything;
    assign read_data = anything;
endmodule
