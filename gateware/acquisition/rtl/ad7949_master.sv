// Scans the AD7949's channels 0 to 3 (data sheet Rev. D, "Read/write after conversion, without a busy indicator").
//
// A pass is six frames of 16 clocks. A configuration written in one frame rules the conversion at the next frame's end,
// whose result comes with the frame after that: a pipeline of two. So the first four frames ask for channels 0 to 3 and
// the last four bring them; the last two ask for channel 0 again only to bring out what is in the pipeline.
//
// CNV is high between frames. Its rise starts a conversion; it stays high until the conversion is over for certain, so
// that the part gives no busy indication, and the part's inputs are acquired while CNV is low.
module ad7949_master #(
    // SCK's half period. 2 on the board: 6 MHz, and 83 ns from SCK's fall to the rise that takes SDO (t_DSDO 24 ns).
    parameter int HALF_CLOCKS = 2,
    // CNV high. 84 at 24 MHz are 3.5 us: t_CONV is 2.2 us at most on 5 V, and 3.2 us below 4.5 V.
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
    // CFG, most significant bit first: overwrite, INCC 111 (unipolar, to ground), channel, BW 1 (full bandwidth), REF 110
    // (external reference; the part's buffer, which would drive the same pin, is off), SEQ 00 (no sequencer), RB 1 (no read-back), and two clocks of which the part takes no notice.
    function automatic logic [15:0] configuration(input logic [2:0] of_channel);
        configuration = {1'b1, 3'b111, of_channel, 1'b1, 3'b110, 2'b00, 1'b1, 2'b00};
    endfunction

    // Half periods of SCK in a frame: CNV falls, then 16 times high and low. SCK is high in the odd ones.
    localparam logic [5:0] LAST_HALF = 6'd32;
    localparam logic [2:0] LAST_FRAME = 3'd5;

    localparam int WAIT_BITS = $clog2(CONVERT_CLOCKS > HALF_CLOCKS ? CONVERT_CLOCKS : HALF_CLOCKS) + 1;

    typedef enum logic [1:0] {IDLE, SHIFT, CONVERT} state_t;

    state_t               state;
    logic [2:0]           frame;
    logic [5:0]           half;
    logic [WAIT_BITS-1:0] waited;
    logic [15:0]          outgoing;
    logic [13:0]          incoming;
    logic                 half_over, conversion_over;
    logic [2:0]           next_frame;

    assign half_over       = waited == WAIT_BITS'(HALF_CLOCKS - 1);
    assign conversion_over = waited == WAIT_BITS'(CONVERT_CLOCKS - 1);
    assign next_frame      = frame + 3'd1;

    // Outputs come from the pins' flip-flops, so none has a pulse in it: one on CNV would be a conversion. What they will be:
    logic cnv_next, sck_next, din_next;

    always_comb begin
        case (state)
            SHIFT: begin
                cnv_next = half_over && half == LAST_HALF;
                sck_next = half_over ? !half[0] && half != LAST_HALF : half[0];
                din_next = half_over && half[0] ? outgoing[14] : outgoing[15];
            end
            CONVERT: begin
                cnv_next = !(conversion_over && frame != LAST_FRAME);
                sck_next = 1'b0;
                din_next = 1'b1;
            end
            default: begin
                cnv_next = !start;
                sck_next = 1'b0;
                din_next = 1'b1;
            end
        endcase
        if (!rst_n) {cnv_next, sck_next} = 2'b10;
    end

    output_register cnv_pin(.clk, .next(cnv_next), .pin(adc_cnv));
    output_register sck_pin(.clk, .next(sck_next), .pin(adc_sck));
    output_register din_pin(.clk, .next(din_next), .pin(adc_din));

    always_ff @(posedge clk) begin
        conversion_in <= 1'b0;
        waited        <= waited + 1'b1;
        if (!rst_n) begin
            state <= IDLE;
        end else begin
            case (state)
                IDLE: begin
                    frame    <= 3'd0;
                    half     <= 6'd0;
                    waited   <= '0;
                    outgoing <= configuration(3'd0);
                    if (start) state <= SHIFT;
                end
                SHIFT: if (half_over) begin
                    waited <= '0;
                    half   <= half + 6'd1;
                    if (half == LAST_HALF) begin
                        state         <= CONVERT;
                        conversion_in <= frame >= 3'd2;
                    end else if (!half[0]) begin
                        // SCK rises. The part's last two clocks carry nothing.
                        if (half < 6'd28) incoming <= {incoming[12:0], adc_sdo};
                    end else begin
                        outgoing <= {outgoing[14:0], 1'b0};
                    end
                end
                CONVERT: if (conversion_over) begin
                    waited   <= '0;
                    half     <= 6'd0;
                    frame    <= next_frame;
                    outgoing <= configuration(next_frame < 3'd4 ? next_frame : 3'd0);
                    state    <= frame == LAST_FRAME ? IDLE : SHIFT;
                end
                default: state <= IDLE;
            endcase
        end
    end

    assign conversion = incoming;
    // Frames 2 to 5 bring channels 0 to 3.
    assign channel    = {frame[2], frame[0]};

`ifndef SYNTHESIS
    // A pass takes 38 us on the board, and the next one begins 100 us after it at least.
    assert property (@(posedge clk) disable iff (!rst_n) start |-> state == IDLE);
`endif
endmodule
