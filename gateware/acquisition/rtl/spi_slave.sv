// The part of the port that runs on the master's clock: bits in, bits out, and where in the transfer they are.
//
// SPI mode 0: the master changes MOSI and we change MISO on SCK's fall, both are taken on its rise. At 10 MHz that leaves
// 50 ns from the fall to a settled MISO. The 24 MHz clock would need two to three periods (83 to 125 ns) only to see the
// fall, so the shift registers have SCK itself for their clock; see README, "Two clocks".
//
// Towards `clk` nothing crosses but three toggles, and what is still while the toggles are looked at:
//   head_toggle   flips when the address byte is in; `head` keeps it until the next one, at least 16 clocks of SCK on
//   begin_toggle  flips with the first bit of a word, so `transmit` has been taken and may be replaced: it must be
//                 settled before the word ends, 31.5 clocks of SCK on (the first word: 8.5 clocks after head_toggle)
//   end_toggle    flips when a word is through. With the first one `received` has it, with the second `is_sound` tells
//                 whether that is the CRC of all before it; they keep that until the next transfer has as many words
// Chip select, when high, puts this part back to the start whatever state it is in. The toggles it leaves as they are,
// since setting them back would be an event.
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
    // The transfer's two head bytes are counted as the second half of a word, so that words end at bit 31.
    localparam logic [4:0] FIRST_BIT_OF_HEAD = 5'd16;
    localparam logic [4:0] LAST_BIT_OF_ADDRESS = 5'd23;
    localparam logic [4:0] LAST_BIT_OF_WORD = 5'd31;

    // Where in the transfer, the words counted as far as a write has them.
    typedef enum logic [1:0] {HEAD, FIRST_WORD, SECOND_WORD, BEYOND} part_t;

    // The bit that SCK's next rise takes, and the CRC of those before it. Of bytes and their CRC it is 0.
    part_t       part;
    logic [4:0]  place;
    logic [31:0] crc, crc_after;

    crc32_bit step(.crc, .taken(spi_mosi), .after(crc_after));

    always_ff @(posedge spi_sck or posedge spi_csn) begin
        if (spi_csn) begin
            part  <= HEAD;
            place <= FIRST_BIT_OF_HEAD;
            crc   <= 32'hFFFF_FFFF;
        end else begin
            place <= place + 5'd1;
            crc   <= crc_after;
            if (place == LAST_BIT_OF_WORD) begin
                case (part)
                    HEAD: part <= FIRST_WORD;
                    FIRST_WORD: part <= SECOND_WORD;
                    default: part <= BEYOND;
                endcase
            end
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
        if (part == HEAD && place == LAST_BIT_OF_ADDRESS) begin
            head        <= {incoming[6:0], spi_mosi};
            head_toggle <= !head_toggle;
        end
        if (part != HEAD && place == 5'd0) begin_toggle <= !begin_toggle;
        if (part != HEAD && place == LAST_BIT_OF_WORD) end_toggle <= !end_toggle;
        if (part == FIRST_WORD && place == LAST_BIT_OF_WORD) received <= {incoming, spi_mosi};
        if (part == SECOND_WORD && place == LAST_BIT_OF_WORD) is_sound <= crc_after == 32'd0;
    end

    // On the fall `place` already names the bit that the rise after it takes: at 0 a word is to begin.
    logic [31:0] outgoing;

    always_ff @(negedge spi_sck or posedge spi_csn) begin
        if (spi_csn) outgoing <= 32'd0;
        else if (part != HEAD && place == 5'd0) outgoing <= transmit;
        else outgoing <= {outgoing[30:0], 1'b0};
    end

    assign spi_miso = outgoing[31];
endmodule
