// When passes come, of which a scan is one or more: scan_timer and ad7949_master with the shortest times that the tests give
// them, against what abstract/ad7949_master.sv promises.
module scans (
    input logic clk,
    input logic rst_n,
    input logic run,
    input logic abandon,
    input logic [19:0] period_us,
    input logic [2:0] halvings,
    input logic adc_sdo
);
    // As sim's `Fast`: a pass takes 204 clocks, and 300 are the shortest time from one to the next.
    localparam int CLOCKS_PER_US = 3;
    localparam logic [8:0] SHORTEST = 9'd300;

    logic        pass_due, is_first, is_last, conversion_in, adc_cnv, adc_sck, adc_din;
    logic [1:0]  channel;
    logic [13:0] conversion;

    scan_timer #(.CLOCKS_PER_US(CLOCKS_PER_US)) timer(
        .clk, .rst_n, .run, .abandon, .period_us, .halvings, .pass_due, .is_first, .is_last
    );
    ad7949_master #(.HALF_CLOCKS(1), .CONVERT_CLOCKS(1)) converter(
        .clk, .rst_n, .start(pass_due), .adc_cnv, .adc_sck, .adc_din, .adc_sdo, .conversion_in, .channel, .conversion
    );

    logic started;
    initial started = 1'b0;
    always_ff @(posedge clk) started <= 1'b1;
    always_comb begin
        if (!started) assume (!rst_n);
        // registers.sv.
        assume (halvings <= 3'd4 && period_us >> halvings >= 20'd100);
    end

    // Clocks since the last pass began and since the last conversion, as far as they matter; conversions of this pass.
    logic [8:0] since_due;
    logic [5:0] since_conversion;
    logic [2:0] brought;

    always_ff @(posedge clk) begin
        if (!rst_n) begin
            since_due        <= SHORTEST;
            since_conversion <= 6'd63;
            brought          <= 3'd4;
        end else begin
            if (pass_due) since_due <= 9'd1;
            else if (since_due != SHORTEST) since_due <= since_due + 9'd1;
            if (conversion_in) since_conversion <= 6'd1;
            else if (since_conversion != 6'd63) since_conversion <= since_conversion + 6'd1;
            if (pass_due) brought <= 3'd0;
            else if (conversion_in) brought <= brought + 3'd1;
        end
    end

    (* hierconn *) wire [1:0]  \timer.clocks ;
    (* hierconn *) wire [19:0] \timer.since_us ;
    (* hierconn *) wire [19:0] \timer.last_us ;
    (* hierconn *) wire [1:0]  \converter.state ;
    (* hierconn *) wire [2:0]  \converter.frame ;
    (* hierconn *) wire [5:0]  \converter.half ;
    (* hierconn *) wire        \converter.waited ;

    // Where both are, from what is counted here. A lemma.
    logic [8:0] frames_past, elapsed;
    logic       is_placed;
    assign frames_past = {6'd0, \converter.frame } * 9'd34;
    assign elapsed     = {2'd0, \timer.since_us [6:0]} * 9'd3 + {7'd0, \timer.clocks };

    always_comb begin
        case (\converter.state )
            2'd0: is_placed = since_due >= 9'd205 && brought == 3'd4;
            2'd1: is_placed = since_due == frames_past + {3'd0, \converter.half } + 9'd1;
            2'd2: is_placed = since_due == frames_past + 9'd34;
            default: is_placed = 1'b0;
        endcase
        if (\converter.state != 2'd0) begin
            if (\converter.frame > 3'd5 || \converter.waited ) is_placed = 1'b0;
            if (\converter.half > 6'd32 && \converter.state != 2'd2) is_placed = 1'b0;
            // Frames 2 to 5 end with a conversion, which is seen in the clock after.
            if (\converter.state == 2'd1 && brought != (\converter.frame < 3'd3 ? 3'd0 : \converter.frame - 3'd2)) is_placed = 1'b0;
            if (\converter.state == 2'd2 && brought != (\converter.frame < 3'd2 ? 3'd0 : \converter.frame - 3'd2)) is_placed = 1'b0;
        end
        if (since_due > SHORTEST || \timer.clocks == 2'd3) is_placed = 1'b0;
        if (pass_due && (since_due != SHORTEST || {\timer.since_us , \timer.clocks } != 22'd0)) is_placed = 1'b0;
        if (conversion_in != (\converter.state == 2'd2 && \converter.frame >= 3'd2)) is_placed = 1'b0;
        if (\timer.last_us < 20'd99) is_placed = 1'b0;
        if (\timer.since_us < 20'd100 && since_due < elapsed && since_due != SHORTEST) is_placed = 1'b0;
        if (\timer.since_us >= 20'd100 && since_due != SHORTEST) is_placed = 1'b0;
    end

`ifdef PROVE_PLACED
    always_ff @(posedge clk) if (started && rst_n) assert (is_placed);
`else
    always_comb if (started && rst_n) assume (is_placed);
    always_ff @(posedge clk) if (started && rst_n) begin
        // A pass begins where the one before is over, and its last sample, if it is a scan's, in the sums.
        if (pass_due) assert (brought == 3'd4 && since_conversion >= 6'd29 && since_due == SHORTEST);
        if (conversion_in) begin
            assert (brought < 3'd4 && channel == brought[1:0]);
            assert (since_due >= 9'd30 && (brought == 3'd0 || since_conversion >= 6'd29));
        end
    end
`endif
endmodule
