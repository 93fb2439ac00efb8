// What rtl/spi_slave.sv promises to the block's other side (abstract/spi_slave.sv), for every wave on the pins: which bit flips
// which toggle, what is beside it, and that nothing else moves anything.
//
// A step is the shortest time that SCK stays high or low.
module serial (
    input logic clk,
    input logic spi_sck,
    input logic spi_csn,
    input logic spi_mosi,
    input logic [31:0] transmit
);
    logic [7:0]  head;
    logic [31:0] received;
    logic        is_sound, head_toggle, begin_toggle, end_toggle, spi_miso;

    spi_slave slave(
        .spi_sck, .spi_csn, .spi_mosi, .spi_miso,
        .head, .received, .is_sound, .head_toggle, .begin_toggle, .end_toggle, .transmit
    );

    // The bits since chip select fell, and their CRC; past the third word the count goes on in that word.
    logic        started, sck_before, csn_before, mosi_before, rises, is_reset;
    logic [6:0]  bits;
    logic [31:0] last_bits, now_bits, crc, crc_after;
    initial {started, bits} = 8'd0;

    assign rises    = spi_sck && !sck_before;
    assign now_bits = {last_bits[30:0], mosi_before};
    crc32_bit step(.crc, .taken(mosi_before), .after(crc_after));

    // A bit in the very step of chip select's fall is before it.
    assign is_reset = spi_csn || csn_before;

    always_ff @(posedge clk) begin
        started     <= 1'b1;
        sck_before  <= spi_sck;
        csn_before  <= spi_csn;
        mosi_before <= spi_mosi;
        if (rises) last_bits <= now_bits;
        if (is_reset) bits <= 7'd0;
        else if (rises) bits <= bits == 7'd111 ? 7'd80 : bits + 7'd1;
        if (is_reset) crc <= 32'hFFFF_FFFF;
        else if (rises) crc <= crc_after;
    end
    logic       is_word;
    logic [4:0] word_bit;
    assign is_word  = bits >= 7'd16;
    assign word_bit = bits[4:0] - 5'd16;

    // The slave's state in this step, from what is counted here. A lemma.
    (* hierconn *) wire [1:0]  \slave.part ;
    (* hierconn *) wire [4:0]  \slave.place ;
    (* hierconn *) wire [31:0] \slave.crc ;
    (* hierconn *) wire [30:0] \slave.incoming ;

    logic [6:0] bits_now;
    logic       is_counted;
    assign bits_now = is_reset ? 7'd0 : !rises ? bits : bits == 7'd111 ? 7'd80 : bits + 7'd1;
    always_comb begin
        is_counted = bits < 7'd112 && \slave.place == bits_now[4:0] + 5'd16;
        if (\slave.part != (bits_now < 7'd16 ? 2'd0 : bits_now < 7'd48 ? 2'd1 : bits_now < 7'd80 ? 2'd2 : 2'd3)) begin
            is_counted = 1'b0;
        end
        if (\slave.crc != (is_reset ? 32'hFFFF_FFFF : rises ? crc_after : crc)) is_counted = 1'b0;
        if (\slave.incoming != (rises ? now_bits[30:0] : last_bits[30:0])) is_counted = 1'b0;
    end

    // Powered up deselected; what the shift register holds then is as good as any.
    always_comb if (!started) assume (spi_csn && \slave.incoming == (rises ? now_bits[30:0] : last_bits[30:0]));

`ifdef PROVE_COUNTED
    always_ff @(posedge clk) if (started) assert (is_counted);
`else
    always_comb if (started) assume (is_counted);
`endif

    logic [7:0]  head_before;
    logic [31:0] received_before;
    logic        sound_before;
    logic [2:0]  toggles_before, flips;
    always_ff @(posedge clk) begin
        head_before     <= head;
        received_before <= received;
        sound_before    <= is_sound;
        toggles_before  <= {head_toggle, begin_toggle, end_toggle};
    end
    assign flips = {head_toggle, begin_toggle, end_toggle} ^ toggles_before;

`ifdef PROVE_SERIAL
    always_ff @(posedge clk) if (started) begin
        // The eighth bit is the head's last; words begin after sixteen and are 32 bits long.
        assert (flips[2] == (rises && bits == 7'd7));
        assert (flips[1] == (rises && is_word && word_bit == 5'd0));
        assert (flips[0] == (rises && is_word && word_bit == 5'd31));
        assert (head == (flips[2] ? now_bits[7:0] : head_before));
        assert (received == (flips[0] && bits == 7'd47 ? now_bits : received_before));
        assert (is_sound == (flips[0] && bits == 7'd79 ? crc_after == 32'd0 : sound_before));
    end
`endif
endmodule
