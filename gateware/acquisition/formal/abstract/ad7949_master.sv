// rtl/ad7949_master.sv for proofs: a pass brings one conversion a channel, 28 clocks from one to the next or as much longer as
// the solver likes. ../scans.sv proves that the real one has no less, even at the shortest times it can be given.
module ad7949_master #(
    parameter int HALF_CLOCKS = 2,
    parameter int CONVERT_CLOCKS = 84
) (
    input  logic        clk,
    input  logic        rst_n,
    input  logic        start,
    output logic        adc_cnv,
    output logic        adc_sck,
    output logic        adc_din,
    input  logic        adc_sdo,
    output logic        conversion_in,
    output logic [1:0]  channel,
    output logic [13:0] conversion
);
    localparam logic [4:0] GAP = 5'd28;

    (* anyseq *) logic        is_time;
    (* anyseq *) logic [13:0] anything;
    logic       busy;
    logic [2:0] brought;
    logic [4:0] waited;

    assign conversion = anything;
    assign {adc_cnv, adc_sck, adc_din} = 3'd0;

    always_ff @(posedge clk) begin
        conversion_in <= 1'b0;
        if (!rst_n) begin
            busy <= 1'b0;
        end else if (!busy) begin
            busy    <= start;
            brought <= 3'd0;
            waited  <= 5'd0;
        end else if (waited != GAP) begin
            waited <= waited + 5'd1;
        end else if (is_time) begin
            waited        <= 5'd0;
            busy          <= brought != 3'd4;
            conversion_in <= brought != 3'd4;
            channel       <= brought[1:0];
            brought       <= brought + 3'd1;
        end
    end

    // ../scans.sv proves it.
    always_comb assume (!(start && busy));
endmodule
