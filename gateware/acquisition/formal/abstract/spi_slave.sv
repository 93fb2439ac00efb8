// rtl/spi_slave.sv for proofs of the other side: what it promises to `clk`, and no more. Within a chip select: the head, then
// words that begin and end in turn, at whatever time the solver likes, but four periods of `clk` apart at least where a byte
// or more of SCK lies between, and with whatever content. ../serial.sv proves the promise.
module spi_slave (
    input  logic        spi_sck,
    input  logic        spi_csn,
    input  logic        spi_mosi,
    output logic        spi_miso,
    output logic [7:0]  head,
    output logic [31:0] received,
    output logic        is_sound,
    output logic        head_toggle,
    output logic        begin_toggle,
    output logic        end_toggle,
    input  logic [31:0] transmit
);
    localparam logic [2:0] BYTE = 3'd4;

    (* anyseq *) logic        is_time, any_bit;
    (* anyseq *) logic [7:0]  any_head;
    (* anyseq *) logic [31:0] any_word;
    logic       is_headed, within;
    logic [1:0] words;
    logic [2:0] waited;

    assign spi_miso = any_bit;

    initial begin
        head_toggle  = 1'b0;
        begin_toggle = 1'b0;
        end_toggle   = 1'b0;
        is_headed    = 1'b0;
        within       = 1'b0;
        words        = 2'd0;
        waited       = 3'd0;
    end

    always @($global_clock) begin
        if (waited != BYTE) waited <= waited + 3'd1;
        if (spi_csn) begin
            is_headed <= 1'b0;
            within    <= 1'b0;
            words     <= 2'd0;
            waited    <= 3'd0;
        end else if (is_time && !is_headed && waited == BYTE) begin
            is_headed   <= 1'b1;
            head        <= any_head;
            head_toggle <= !head_toggle;
            waited      <= 3'd0;
        end else if (is_time && is_headed && !within && (words != 2'd0 || waited == BYTE)) begin
            // Between two words lies one period of SCK, two of ours at least.
            within       <= 1'b1;
            begin_toggle <= !begin_toggle;
            waited       <= 3'd0;
        end else if (is_time && within && waited == BYTE) begin
            within     <= 1'b0;
            end_toggle <= !end_toggle;
            if (words == 2'd0) received <= any_word;
            if (words == 2'd1) is_sound <= any_bit;
            if (words != 2'd2) words <= words + 2'd1;
        end
    end
endmodule
