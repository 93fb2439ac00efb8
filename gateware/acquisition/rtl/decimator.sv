// Makes one sample of a channel's conversions in the passes of a scan: their mean, rounded to whole counts, halves to even.
//
// Halves are not rare (every sixteenth sum of 16 conversions ends in one, every second of 2), and rounded up they would raise the
// zero by a 32nd of a count at 16 conversions and by a quarter at 2. To even they raise and lower it alike.
//
// Sixteen conversions of 14 bits are 18 bits, and the mean is never more than the largest of them: formal/means.sv.
module decimator (
    input  logic        clk,
    input  logic        rst_n,

    // A pass begins: the scan's first, and its last. Its conversions come before the next one begins.
    input  logic        pass_due,
    input  logic        is_first,
    input  logic        is_last,
    input  logic [2:0]  halvings,

    input  logic        conversion_in,
    input  logic [1:0]  channel_in,
    input  logic [13:0] conversion,

    // Two clocks after the conversion in the last pass.
    output logic        sample_in,
    output logic [1:0]  channel,
    output logic [13:0] sample
);
    // Channels come in turn, each pass alike: the one that comes next stands lowest.
    logic [71:0] sums;
    logic [17:0] so_far, with_it, total;
    logic        begins, ends, is_whole;
    logic [1:0]  of_channel;
    logic [14:0] doubled;
    logic [3:0]  parts, below;
    logic        rounds_up;

    assign so_far  = begins ? 18'd0 : sums[17:0];
    assign with_it = so_far + {4'd0, conversion};

    // What is cut off, from its half down: more than a half goes up, and a half where the mean would be odd.
    assign doubled   = 15'({total, 1'b0} >> halvings);
    assign parts     = 4'hF >> (3'd4 - halvings);
    assign below     = total[3:0] & (parts >> 1);
    assign rounds_up = doubled[0] && (doubled[1] || below != 4'd0);

    always_ff @(posedge clk) begin
        if (pass_due) begin
            begins <= is_first;
            ends   <= is_last;
        end
        total      <= with_it;
        of_channel <= channel_in;
        is_whole   <= rst_n && conversion_in && ends;
        if (conversion_in) sums <= {with_it, sums[71:18]};
        sample     <= doubled[14:1] + {13'd0, rounds_up};
        channel    <= of_channel;
        sample_in  <= rst_n && is_whole;
    end
endmodule
