// Block RAM: one port writes, one reads a clock later. What is read where the other port writes in the same clock is not
// defined on iCE40, and nobody does so: see the assertions of the users.
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
    logic [WIDTH-1:0] cells [2**ADDRESS_BITS];

    always_ff @(posedge clk) begin
        if (write) cells[write_address] <= write_data;
        read_data <= cells[read_address];
    end
endmodule
