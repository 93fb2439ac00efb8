// That a mean is one: of as many conversions as OVERSAMPLING says, their sum not too narrow, and rounded to the nearest count, from
// a half to the even one. scan_timer and decimator, with conversions that come when and as the solver likes.
module means (
    input logic clk,
    input logic rst_n,
    input logic run,
    input logic abandon,
    input logic [19:0] period_us,
    input logic [2:0] halvings,
    input logic is_time,
    input logic is_full,
    input logic [13:0] anything
);
    logic        pass_due, is_first, is_last, conversion_in, sample_in;
    logic [1:0]  channel;
    logic [13:0] sample;

    scan_timer #(.CLOCKS_PER_US(3)) timer(
        .clk, .rst_n, .run, .abandon, .period_us, .halvings, .pass_due, .is_first, .is_last
    );
    decimator mean(
        .clk, .rst_n, .pass_due, .is_first, .is_last, .halvings,
        .conversion_in, .channel_in(brought[1:0]), .conversion(anything), .sample_in, .channel, .sample
    );

    (* hierconn *) wire [3:0]  \timer.passes ;
    (* hierconn *) wire        \mean.begins ;
    (* hierconn *) wire        \mean.ends ;
    (* hierconn *) wire        \mean.is_whole ;
    (* hierconn *) wire [71:0] \mean.sums ;
    (* hierconn *) wire [17:0] \mean.so_far ;
    (* hierconn *) wire [17:0] \mean.total ;

    logic       started, is_valid;
    logic [2:0] halvings_before, brought;
    logic [1:0] rested;
    logic [4:0] ratio, begun, begun_now;
    initial {started, is_valid} = 2'd0;
    initial brought = 3'd4;
    initial rested = 2'd0;

    assign ratio         = 5'd1 << halvings;
    assign conversion_in = is_time && brought != 3'd4 && !pass_due;
    // Passes of this scan that have begun, with the one that begins in this clock.
    assign begun_now     = !pass_due ? begun : is_first ? 5'd1 : begun + 5'd1;

    always_ff @(posedge clk) begin
        started         <= 1'b1;
        halvings_before <= halvings;
        begun           <= begun_now;
        if (pass_due) brought <= 3'd0;
        else if (conversion_in) brought <= brought + 3'd1;
        if (brought != 3'd4 || pass_due) rested <= 2'd0;
        else if (rested != 2'd3) rested <= rested + 2'd1;
        // A scan that is dropped is none: filler.sv takes no sample of it. Nor is one any more that a set was full with.
        if (!rst_n || !run || abandon) is_valid <= 1'b0;
        else if (is_full && begun == ratio && rested == 2'd3 && !pass_due) is_valid <= 1'b0;
        else if (pass_due && is_first) is_valid <= 1'b1;
    end

    always_comb begin
        if (!started) assume (!rst_n);
        assume (halvings <= 3'd4);
        // filler.sv: settings change where a set starts, when the last scan is over, or as it is dropped.
        if (started && rst_n && (is_valid || pass_due)) assume (halvings == halvings_before);
        // scans.sv: a pass is over before the next one begins.
        if (pass_due) assume (rested == 2'd3);
    end

    // The state of both, from what is counted here. A lemma.
    logic       is_counted;
    logic [3:0] is_within;
    // In the order of `sums`: those that have come in this pass stand highest. No sum is more than so many of the largest
    // conversions.
    for (genvar place = 0; place < 4; place++) begin : of_sums
        logic [4:0] summed;
        assign summed = begun - {4'd0, brought < 3'd4 - place};
        assign is_within[place] =
            summed == 5'd0 || {1'b0, \mean.sums [18 * place +: 18]} <= {summed, 14'd0} - {14'd0, summed};
    end
    always_comb begin
        is_counted = brought <= 3'd4 && (rested == 2'd0 || brought == 3'd4) && (!\mean.is_whole || rested == 2'd0);
        if (is_valid) begin
            if (begun == 5'd0 || begun_now > ratio || is_within != 4'hF) is_counted = 1'b0;
            if (pass_due && is_last != (begun_now == ratio)) is_counted = 1'b0;
            if ({1'b0, \timer.passes } != (begun_now == ratio ? 5'd0 : begun_now)) is_counted = 1'b0;
            if (\mean.begins != (begun == 5'd1) || \mean.ends != (begun == ratio)) is_counted = 1'b0;
        end else if (pass_due) begin
            if (!is_first || is_last != (ratio == 5'd1)) is_counted = 1'b0;
            if ({1'b0, \timer.passes } != (ratio == 5'd1 ? 5'd0 : 5'd1)) is_counted = 1'b0;
        end else if (\timer.passes != 4'd0) is_counted = 1'b0;
    end

`ifdef PROVE_COUNTED
    always_ff @(posedge clk) if (started && rst_n) assert (is_counted);
`else
    always_comb if (started && rst_n) assume (is_counted);
    // The sum that the sample is made of, and how much more than it the sample stands for, twice.
    logic [17:0]        summed;
    logic signed [19:0] excess;
    always_ff @(posedge clk) summed <= \mean.total ;
    assign excess = $signed(({5'd0, sample, 1'b0} << halvings) - {1'b0, summed, 1'b0});

    always_ff @(posedge clk) if (started && rst_n && is_valid) begin
        // No sum is too narrow, and where a sample is made it is of as many passes as it is divided by.
        if (conversion_in) assert ({1'b0, \mean.so_far } + {5'd0, anything} < 19'd262144);
        if (conversion_in && \mean.ends ) assert (begun == ratio);
        if (\mean.is_whole ) assert (\mean.total <= 18'd16383 << halvings);
        if (sample_in) begin
            assert (excess <= $signed({15'd0, ratio}) && excess >= -$signed({15'd0, ratio}));
            assert (!sample[0] || (excess != $signed({15'd0, ratio}) && excess != -$signed({15'd0, ratio})));
        end
    end
`endif
endmodule
