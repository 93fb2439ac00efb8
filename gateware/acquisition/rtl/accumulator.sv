// Adds each sample to its channel's sum and its square to the channel's sum of squares, exactly.
//
// 512 samples of 14 bits: the sum has at most 23 bits, the sum of squares 37. Both are kept in block RAM as they are sent,
// 16 bits at a time, so that the reader finds words 3 to 14 of the burst ready and no bank has accumulators of its own:
//   address {bank, channel, part}, parts 0, 1: the sum, low half first; 2 to 5: the sum of squares
// A sample takes 14 clocks for its square, a bit each, and two a part for read and write-back; the A/D's next one is not
// there before 36 clocks (in the quickest simulation; 150 on the board).
module accumulator (
    input  logic        clk,
    input  logic        rst_n,

    input  logic        sample_in,
    input  logic [1:0]  channel,
    input  logic [13:0] sample,
    input  logic        bank,
    // The set's first scan: what the memory holds is another set's.
    input  logic        first_scan,

    output logic        done,

    output logic        write,
    output logic [5:0]  address,
    output logic [15:0] write_data,
    input  logic [15:0] read_data
);
    localparam logic [2:0] LAST_PART = 3'd5;

    typedef enum logic [1:0] {IDLE, SQUARE, READ, ADD} state_t;

    state_t      state;
    logic [1:0]  of_channel;
    logic        of_bank, is_first;
    logic [13:0] value, multiplier;
    logic [27:0] square;
    logic [3:0]  bits_left;
    logic [2:0]  part;
    logic        carry;
    logic [15:0] addend, so_far;
    logic [16:0] total;

    always_comb begin
        case (part)
            3'd0: addend = {2'b00, value};
            3'd2: addend = square[15:0];
            3'd3: addend = {4'b0000, square[27:16]};
            default: addend = 16'd0;
        endcase
    end

    assign so_far     = is_first ? 16'd0 : read_data;
    assign total      = {1'b0, so_far} + {1'b0, addend} + {16'd0, carry};
    assign address    = {of_bank, of_channel, part};
    assign write      = state == ADD;
    assign write_data = total[15:0];

    always_ff @(posedge clk) begin
        done <= 1'b0;
        if (!rst_n) begin
            state <= IDLE;
        end else begin
            case (state)
                IDLE: if (sample_in) begin
                    state      <= SQUARE;
                    of_channel <= channel;
                    of_bank    <= bank;
                    is_first   <= first_scan;
                    value      <= sample;
                    multiplier <= sample;
                    square     <= 28'd0;
                    bits_left  <= 4'd13;
                    part       <= 3'd0;
                    carry      <= 1'b0;
                end
                SQUARE: begin
                    // Long multiplication from the top bit down.
                    square     <= {square[26:0], 1'b0} + (multiplier[13] ? {14'd0, value} : 28'd0);
                    multiplier <= {multiplier[12:0], 1'b0};
                    bits_left  <= bits_left - 4'd1;
                    if (bits_left == 4'd0) state <= READ;
                end
                READ: state <= ADD;
                ADD: begin
                    // The sum ends with part 1; its carry is nought, as 23 bits are enough.
                    carry <= total[16];
                    part  <= part + 3'd1;
                    state <= part == LAST_PART ? IDLE : READ;
                    done  <= part == LAST_PART;
                end
                default: state <= IDLE;
            endcase
        end
    end

`ifndef SYNTHESIS
    assert property (@(posedge clk) disable iff (!rst_n) sample_in |-> state == IDLE);
    // Neither sum outgrows its words.
    assert property (@(posedge clk) disable iff (!rst_n)
        state == ADD && (part == 3'd1 || part == LAST_PART) |-> !total[16]);
`endif
endmodule
