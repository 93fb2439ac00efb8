// The registers of docs/acquisition-port.md but the set's burst and the latest scan.
module registers (
    input  logic        clk,
    input  logic        rst_n,

    input  logic [3:0]  address,
    input  logic        beyond,
    input  logic        write,
    input  logic [31:0] written,
    output logic [31:0] read,

    output logic        run,
    // One clock: RESTART was written.
    output logic        restart,
    // One clock: the set being filled is dropped, and if RUN is 1 a new one starts. RUN has its new value in this clock.
    output logic        abandon,
    output logic [19:0] scan_period_us,
    output logic [9:0]  set_length,
    // OVERSAMPLING is 2 to the power of this.
    output logic [2:0]  halvings,

    input  logic        ready,
    input  logic        overrun,
    input  logic [15:0] lost
);
    localparam logic [3:0] IDENTITY = 4'h0;
    localparam logic [3:0] VERSION = 4'h1;
    localparam logic [3:0] CONTROL = 4'h2;
    localparam logic [3:0] SCAN_PERIOD = 4'h3;
    localparam logic [3:0] SET_LENGTH = 4'h4;
    localparam logic [3:0] STATUS = 4'h5;
    localparam logic [3:0] OVERSAMPLING = 4'h6;

    localparam logic [31:0] ZRAQ = 32'h5A52_4151;
    localparam logic [31:0] VERSION_2_2 = 32'h0002_0002;

    // What was asked for, and the most for which a pass comes no sooner than a scan may.
    logic [2:0] asked, most;

    function automatic logic [2:0] most_within(input logic [31:0] period_us);
        if (period_us >= 32'd1600) most_within = 3'd4;
        else if (period_us >= 32'd800) most_within = 3'd3;
        else if (period_us >= 32'd400) most_within = 3'd2;
        else most_within = {2'b00, period_us >= 32'd200};
    endfunction

    assign halvings = asked < most ? asked : most;

    logic writes_control;
    assign writes_control = write && !beyond && address == CONTROL;

    always_ff @(posedge clk) begin
        restart <= rst_n && writes_control && written[1];
        abandon <= rst_n && writes_control && (written[1] || written[0] != run);
        if (!rst_n) begin
            run            <= 1'b0;
            scan_period_us <= 20'd3000;
            set_length     <= 10'd500;
            asked          <= 3'd0;
            most           <= 3'd4;
        end else if (write && !beyond) begin
            case (address)
                CONTROL: run <= written[0];
                SCAN_PERIOD:
                    if (written >= 32'd100 && written <= 32'd1_000_000) begin
                        scan_period_us <= written[19:0];
                        most           <= most_within(written);
                    end
                SET_LENGTH:
                    if (written >= 32'd1 && written <= 32'd512) set_length <= written[9:0];
                OVERSAMPLING:
                    case (written)
                        32'd1: asked <= 3'd0;
                        32'd2: asked <= 3'd1;
                        32'd4: asked <= 3'd2;
                        32'd8: asked <= 3'd3;
                        32'd16: asked <= 3'd4;
                        default: ;
                    endcase
                default: ;
            endcase
        end
    end

    always_comb begin
        read = 32'd0;
        if (!beyond) begin
            case (address)
                IDENTITY: read = ZRAQ;
                VERSION: read = VERSION_2_2;
                CONTROL: read = {31'd0, run};
                SCAN_PERIOD: read = {12'd0, scan_period_us};
                SET_LENGTH: read = {22'd0, set_length};
                STATUS: read = {lost, 14'd0, overrun, ready};
                OVERSAMPLING: read = 32'd1 << halvings;
                default: ;
            endcase
        end
    end

`ifndef SYNTHESIS
    assert property (@(posedge clk) disable iff (!rst_n) scan_period_us >= 20'd100 && scan_period_us <= 20'd1_000_000);
    assert property (@(posedge clk) disable iff (!rst_n) set_length >= 10'd1 && set_length <= 10'd512);
    assert property (@(posedge clk) disable iff (!rst_n) scan_period_us >> halvings >= 20'd100 && halvings <= 3'd4);
`endif
endmodule
