// The part of the port that runs on the master's clock: bits in, bits out, and where in the transfer they are.
//
// SPI mode 0: the master changes MOSI and we change MISO on SCK's fall, both are taken on its rise. At 10 MHz that leaves
// 50 ns from the fall to a settled MISO. The 24 MHz clock would need two to three periods (83 to 125 ns) only to see the
// fall, so the shift registers have SCK itself for their clock; see README, "Two clocks".
//
// Towards `clk` nothing crosses but three toggles, and two words that are still while the toggles are looked at:
//   head_toggle   flips when the address byte is in; `head` keeps it until the next one, at least 16 clocks of SCK on
//   begin_toggle  flips with the first bit of a word, so `transmit` has been taken and may be replaced: it must be
//                 settled before the word ends, 31.5 clocks of SCK on (the first word: 8.5 clocks after head_toggle)
//   end_toggle    flips when a word is through; `received` keeps it for at least 32 clocks of SCK
// Chip select, when high, puts this part back to the start whatever state it is in. The toggles it leaves as they are,
// since setting them back would be an event.
module spi_slave (
    input  logic        spi_sck,
    input  logic        spi_csn,
    input  logic        spi_mosi,
    output logic        spi_miso,

    output logic [7:0]  head,
    output logic [31:0] received,
    output logic        head_toggle,
    output logic        begin_toggle,
    output logic        end_toggle,
    input  logic [31:0] transmit
);
    // The transfer's two head bytes are counted as the second half of a word, so that words end at bit 31.
    localparam logic [4:0] FIRST_BIT_OF_HEAD = 5'd16;
    localparam logic [4:0] LAST_BIT_OF_ADDRESS = 5'd23;
    localparam logic [4:0] LAST_BIT_OF_WORD = 5'd31;

    // The bit that SCK's next rise takes.
    logic [4:0] place;
    logic       in_head;

    always_ff @(posedge spi_sck or posedge spi_csn) begin
        if (spi_csn) begin
            place   <= FIRST_BIT_OF_HEAD;
            in_head <= 1'b1;
        end else begin
            place   <= place + 5'd1;
            in_head <= in_head && place != LAST_BIT_OF_WORD;
        end
    end

    logic [30:0] incoming;

    initial begin
        head_toggle  = 1'b0;
        begin_toggle = 1'b0;
        end_toggle   = 1'b0;
    end

    always_ff @(posedge spi_sck) begin
        incoming <= {incoming[29:0], spi_mosi};
        if (in_head && place == LAST_BIT_OF_ADDRESS) begin
            head        <= {incoming[6:0], spi_mosi};
            head_toggle <= !head_toggle;
        end
        if (!in_head && place == 5'd0) begin_toggle <= !begin_toggle;
        if (!in_head && place == LAST_BIT_OF_WORD) begin
            received   <= {incoming, spi_mosi};
            end_toggle <= !end_toggle;
        end
    end

    // On the fall `place` already names the bit that the rise after it takes: at 0 a word is to begin.
    logic [31:0] outgoing;

    always_ff @(negedge spi_sck or posedge spi_csn) begin
        if (spi_csn) outgoing <= 32'd0;
        else if (!in_head && place == 5'd0) outgoing <= transmit;
        else outgoing <= {outgoing[30:0], 1'b0};
    end

    assign spi_miso = outgoing[31];
endmodule
