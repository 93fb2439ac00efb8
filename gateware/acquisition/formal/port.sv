// What docs/acquisition-port.md promises, as properties of the whole block: read into rtl/acquisition.sv for proofs alone.
//
// A step is a period of `clk`. The pins may do anything, in any step; the modules in abstract/ stand for the ones on the
// other side of a promise that another file here proves.

// WHOLE and FALLS are proved from any state that the lemmas allow, which is more; in a spoilt block the way from the reset to
// a set that is read would be too long to be found.
`ifdef PROVE_WHOLE
`define FROM_ANYWHERE
`endif
`ifdef PROVE_FALLS
`define FROM_ANYWHERE
`endif

// --- Transfers as they are on the pins, counted here and not by the block. The one that the block has open is the last one
// whose head came in, or the one before while that head is on its way through the synchroniser.
typedef struct packed {
    logic [7:0] head;
    // 17: more than the burst's sixteen.
    logic [4:0] words;
    logic       is_within;
    // Chip select was high since.
    logic       is_over;
} transfer_t;

logic      f_started, f_selected, f_head_before, f_begin_before, f_end_before;
logic      f_head_moves, f_begin_moves, f_end_moves;
transfer_t f_kept, f_last, f_before, f_open;

initial {f_started, f_selected, f_head_before, f_begin_before, f_end_before} = 5'd0;

assign f_head_moves  = head_toggle != f_head_before;
assign f_begin_moves = begin_toggle != f_begin_before;
assign f_end_moves   = end_toggle != f_end_before;

always_comb begin
    f_last.head = head;
    if (f_head_moves) begin
        f_last.words     = 5'd0;
        f_last.is_within = 1'b0;
        f_last.is_over   = spi_csn;
    end else begin
        f_last.words     = f_kept.words + ((f_end_moves && f_kept.words != 5'd17) ? 5'd1 : 5'd0);
        f_last.is_within = f_begin_moves || (f_kept.is_within && !f_end_moves);
        f_last.is_over   = f_kept.is_over || spi_csn;
    end
end

transfer_t f_before_kept;

// How long chip select has been low.
logic [3:0] f_low;
`ifndef FROM_ANYWHERE
initial f_low = 4'd0;
initial f_kept.words = 5'd0;
initial f_before_kept.words = 5'd0;
`endif
always_ff @(posedge clk) f_low <= spi_csn ? 4'd0 : f_low == 4'd15 ? f_low : f_low + 4'd1;

assign f_before = f_head_moves ? f_kept : f_before_kept;

always_ff @(posedge clk) begin
    f_started      <= 1'b1;
    f_selected     <= !spi_csn;
    f_head_before  <= head_toggle;
    f_begin_before <= begin_toggle;
    f_end_before   <= end_toggle;
    f_kept         <= f_last;
    f_before_kept  <= f_before;
end

// --- What the block has counted is what was on the pins, but for what is in the synchronisers. A lemma: the others take it
// for granted once it is proved.
// The block's state: yosys' `flatten` joins these to the wires of these names.
(* hierconn *) wire       \current.is_open ;
(* hierconn *) wire       \current.is_write ;
(* hierconn *) wire       \current.is_burst ;
(* hierconn *) wire       \current.is_within ;
(* hierconn *) wire [4:0] \current.words ;
(* hierconn *) wire       \events.head_before ;
(* hierconn *) wire       \events.begin_before ;
(* hierconn *) wire       \events.end_before ;

logic f_head_flies, f_begin_flies, f_end_flies, f_is_counted;
assign f_head_flies  = head_toggle != \events.head_before ;
assign f_begin_flies = begin_toggle != \events.begin_before ;
assign f_end_flies   = end_toggle != \events.end_before ;
assign f_open        = f_head_flies ? f_before : f_last;

always_comb begin
    f_is_counted = !reading || (\current.is_open && \current.is_burst );
    // A word has taken longer than the synchronisers are deep.
    if (f_kept.words != 5'd0 && !f_kept.is_over && f_low < 4'd8) f_is_counted = 1'b0;
    if (f_kept.words > 5'd17 || f_before_kept.words > 5'd17) f_is_counted = 1'b0;
    if (\current.is_open ) begin
        if (\current.words != (f_open.words == 5'd17 ? 5'd16 : f_open.words - {4'd0, f_end_flies})) f_is_counted = 1'b0;
        if (!f_begin_flies && !f_end_flies && \current.is_within != f_open.is_within) f_is_counted = 1'b0;
        if (\current.is_write != f_open.head[7] || \current.is_burst != (f_open.head == 8'h10)) f_is_counted = 1'b0;
        if (f_open.head[7] && {beyond, address} != {f_open.head[6:4] != 3'd0, f_open.head[3:0]}) f_is_counted = 1'b0;
        if (f_head_flies && (f_end_flies || f_begin_flies || !f_open.is_over)) f_is_counted = 1'b0;
    end
end

`ifdef PROVE_COUNTED
always_ff @(posedge clk) if (f_started && rst_n) assert (f_is_counted);
`else
always_comb if (f_started && rst_n) assume (f_is_counted);
`endif

// The reset is asked for at first, and whenever the solver likes.
// What begins anywhere is looked at once the synchronisers are filled.
logic [2:0] f_steps;
initial f_steps = 3'd0;
always_ff @(posedge clk) if (f_steps != 3'd7) f_steps <= f_steps + 3'd1;
`ifndef FROM_ANYWHERE
always_comb if (!f_started) assume (!rst_n);
`endif

logic f_ran;
initial f_ran = 1'b0;
always_ff @(posedge clk) f_ran <= rst_n;

// --- No read writes: a register changes by a whole write, sound and of nothing more, to its address and with its word (which
// is `received` here as there).
`ifdef PROVE_WRITES
always_ff @(posedge clk) if (f_started && rst_n) begin
    if (write) begin
        assert (f_open.head[7] && f_open.words == 5'd2 && !f_open.is_within && f_open.is_over && is_sound);
        assert ({beyond, address} == {f_open.head[6:4] != 3'd0, f_open.head[3:0]});
    end
    if (f_ran) begin
        if (run != $past(run)) assert ($past(write && !beyond && address == 4'd2 && received[0] != run));
        if (restart) assert ($past(write && !beyond && address == 4'd2 && received[1]));
        if (written_period_us != $past(written_period_us)) assert ($past(write && !beyond && address == 4'd3));
        if (written_length != $past(written_length)) assert ($past(write && !beyond && address == 4'd4));
        // OVERSAMPLING in use is no more than SCAN_PERIOD allows.
        if (written_halvings != $past(written_halvings)) begin
            assert ($past(write && !beyond && (address == 4'd3 || address == 4'd6)));
        end
    end
end
`endif

// --- The sums of a sample are done before the next one comes, and go to the bank that fills; after a RESTART to whichever,
// but then nobody waits or reads until another scan. A lemma, too.
(* hierconn *) wire [1:0] \sums.state ;
(* hierconn *) wire [3:0] \sums.bits_left ;
(* hierconn *) wire [2:0] \sums.part ;
(* hierconn *) wire       \sums.of_bank ;
(* hierconn *) wire       \converter.busy ;
(* hierconn *) wire [4:0] \converter.waited ;
(* hierconn *) wire       \means.is_whole ;

logic [4:0] f_step;
logic       f_is_summed;

always_comb begin
    case (\sums.state )
        2'd1: f_step = 5'd14 - {1'b0, \sums.bits_left };
        2'd2: f_step = 5'd15 + {1'b0, \sums.part , 1'b0};
        2'd3: f_step = 5'd16 + {1'b0, \sums.part , 1'b0};
        default: f_step = 5'd0;
    endcase
    f_is_summed = !sample_in || (\sums.state == 2'd0 && \converter.waited == 5'd2 && \converter.busy );
    // The decimator has it for two clocks.
    if (conversion_in && (\converter.waited != 5'd0 || !\converter.busy )) f_is_summed = 1'b0;
    if (\means.is_whole && (\converter.waited != 5'd1 || !\converter.busy )) f_is_summed = 1'b0;
    if (\sums.state != 2'd0) begin
        if (!\converter.busy || \converter.waited != f_step + 5'd2 || f_step > 5'd26) f_is_summed = 1'b0;
        if (\sums.of_bank != filling && (waiting || taking)) f_is_summed = 1'b0;
    end
end

`ifdef PROVE_SUMMED
always_ff @(posedge clk) if (f_started && rst_n) assert (f_is_summed);
`else
always_comb if (f_started && rst_n) assume (f_is_summed);
`endif

// --- Never torn: from the head of a burst on the set that waits is in a bank that nobody writes, until chip select rises.
logic f_is_read, f_bank_read;
initial f_is_read = 1'b0;

always_ff @(posedge clk) begin
    f_is_read <= rst_n && reading;
    if (reading && !f_is_read) f_bank_read <= !filling;
end

`ifdef PROVE_WHOLE
always_ff @(posedge clk) if (f_steps == 3'd7 && rst_n && f_ran) begin
    if (reading && f_is_read) begin
        assert (!(sample_in && taking) || filling != f_bank_read);
        assert (!sum_write || sum_address[5] != f_bank_read);
        assert (!filling == f_bank_read);
    end
    // A burst that finds a set has it, and keeps it as long as chip select is low.
    if ($past(read_begins && waiting && !release_set && !restart)) assert (reading);
    if (f_is_read && !reading) assert (f_low < 4'd8 || $past(head_in || restart));
end
`endif

// --- Never silent: the last sample of a set makes a set within 30 clocks, dropped by CONTROL alone; and a set that is full is
// data ready in the next clock, or one more lost.
logic       f_is_due;
logic [4:0] f_due;
initial f_is_due = 1'b0;

always_ff @(posedge clk) begin
    f_due <= f_due + 5'd1;
    if (!rst_n || abandon || set_full) f_is_due <= 1'b0;
    else if (sample_in && channel == 2'd3 && taking && {1'b0, scan} == filling_length - 10'd1) begin
        f_is_due <= 1'b1;
        f_due    <= 5'd0;
    end
end

`ifdef PROVE_TOLD
always_ff @(posedge clk) begin
    if (f_started && rst_n && f_is_due) assert (f_due < 5'd30);
    if (f_started && rst_n && f_ran && !$past(restart) && $past(set_full)) begin
        assert (waiting);
        assert (data_ready || $past(release_set));
        if ($past(waiting && !release_set)) begin
            assert (overrun);
            assert (lost_modulo == $past(lost_modulo) + 16'd1);
        end
    end
    // Nobody reads: nothing takes READY away but RESTART.
    if (f_started && rst_n && f_ran && $past(waiting && !restart && !reading)) assert (waiting);
end
`endif

// --- Data ready falls after every release: within six clocks of chip select's rise, 250 ns.
logic       f_is_released, f_fell;
logic [2:0] f_since;
initial f_is_released = 1'b0;

always_ff @(posedge clk) begin
    f_since <= f_since + 3'd1;
    f_fell  <= f_fell || !data_ready;
    if (!rst_n) f_is_released <= 1'b0;
    else if (f_steps == 3'd7 && spi_csn && !f_kept.is_over && reading && !f_head_flies && f_last.words >= 5'd16) begin
        f_is_released <= 1'b1;
        f_since       <= 3'd1;
        f_fell        <= 1'b0;
    end else if (f_since == 3'd6) f_is_released <= 1'b0;
end

`ifdef PROVE_FALLS
// Chip select stays high for three clocks, or the transfer's end is seen with the next head.
logic [1:0] f_high;
initial f_high = 2'd0;
always_ff @(posedge clk) f_high <= !spi_csn ? 2'd0 : f_high == 2'd3 ? f_high : f_high + 2'd1;
always_comb if (f_high != 2'd0 && f_high != 2'd3) assume (spi_csn);

always_ff @(posedge clk) if (f_started && rst_n && f_is_released && f_since == 3'd6) assert (f_fell || !data_ready);
`endif
