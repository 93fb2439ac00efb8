// Who owns the two banks: one fills, the other waits, is read, or is free; and what that costs in lost sets.
//
// In one clock everything may happen at once. A read that ends comes first (its set is released, so nothing is lost), then
// a read that begins (its set is kept), then the set that is full.
module banks (
    input  logic        clk,
    input  logic        rst_n,
    input  logic        restart,

    input  logic        set_full,
    input  logic [9:0]  set_length,
    output logic        filling,

    input  logic        read_begins,
    input  logic        read_ends,
    input  logic        release_set,

    output logic        waiting,
    // The next clock's data ready: low for a clock after every release, even where the next set is full in the same clock, so
    // that a master that waits for edges sees each set.
    output logic        data_ready_next,
    output logic        reading,
    output logic        overrun,
    // Modulo 65 536, as STATUS has it.
    output logic [15:0] lost_modulo,

    // The set that waits or is read; still while it is read.
    output logic [31:0] number,
    output logic [9:0]  length,
    output logic        lost_before,
    output logic [31:0] lost_at_read
);
    logic [31:0] next_number, lost;
    logic        newest_was_lost;
    logic        is_released, still_waits, is_kept, loses_newest, loses_older, is_accepted;

    // A burst that began with no set waiting releases none, even if one has become full meanwhile.
    assign is_released  = release_set && reading;
    assign still_waits  = waiting && !is_released;
    assign is_kept      = still_waits && (read_begins || (reading && !read_ends));
    assign loses_newest = set_full && is_kept;
    assign is_accepted  = set_full && !is_kept;
    assign loses_older  = is_accepted && still_waits;

    assign data_ready_next = rst_n && !restart && !is_released && (waiting || set_full);

    assign lost_modulo = lost[15:0];

    always_ff @(posedge clk) begin
        if (!rst_n || restart) begin
            filling         <= 1'b0;
            waiting         <= 1'b0;
            reading         <= 1'b0;
            overrun         <= 1'b0;
            newest_was_lost <= 1'b0;
            lost            <= 32'd0;
            next_number     <= 32'd0;
        end else begin
            waiting <= still_waits || set_full;
            reading <= is_kept;
            overrun <= (overrun && !is_released) || loses_newest || loses_older;
            if (set_full) next_number <= next_number + 32'd1;
            if (loses_newest || loses_older) lost <= lost + 32'd1;
            if (set_full) newest_was_lost <= loses_newest;
            if (is_accepted) filling <= !filling;
        end

        if (is_accepted) begin
            number      <= next_number;
            length      <= set_length;
            lost_before <= loses_older || newest_was_lost;
        end
        if (read_begins) lost_at_read <= lost;
    end

`ifndef SYNTHESIS
    // Simulated by Verilator with everything else, and proved for all inputs by yosys: `cargo xtask gateware`.
    logic [31:0] released;
    logic        ran_before;
    initial ran_before = 1'b0;
    always_ff @(posedge clk) begin
        ran_before <= rst_n && !restart;
        if (!rst_n || restart) released <= 32'd0;
        else if (is_released) released <= released + 32'd1;
    end
    always_ff @(posedge clk) begin
        if (rst_n && ran_before) begin
            // Every set that was full was read and released, or waits, or was counted as lost: nothing is silent.
            assert (next_number == released + lost + {31'd0, waiting});
            // Counts go up by one, and back to nought only by RESTART.
            assert (lost == $past(lost) || lost == $past(lost) + 32'd1);
            assert (next_number == $past(next_number) + {31'd0, $past(set_full)});
            // A loss raises the flag, and only a release takes it away.
            assert (overrun || lost == $past(lost));
            assert (overrun || !$past(overrun) || $past(is_released));
            // A burst that begins while a set waits is that set's.
            assert (reading || !$past(read_begins && still_waits));
            // What is read waits, does not change hands, and does not change; one burst may follow another at once.
            assert (!reading || waiting);
            assert (!(reading && $past(reading)) || ($stable(filling) && $stable(number) && $stable(length)
                && $stable(lost_before) && ($stable(lost_at_read) || $past(read_begins))));
            // A set that waits goes away by its release alone.
            assert (waiting || !$past(waiting) || $past(is_released));
            // A gap in the numbers is told by the set after it.
            assert (!$past(is_accepted) || lost_before == ($past(newest_was_lost) || lost != $past(lost)));
        end
    end
`endif
endmodule
