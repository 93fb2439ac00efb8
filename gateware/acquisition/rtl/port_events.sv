// What happens on the SPI port, as pulses of one clock in `clk`'s domain.
//
// Chip select is seen one clock later than the toggles: its rise follows the last edge of SCK, so even when the toggle is
// seen late and chip select early, the end of a word is seen no later than the end of its transfer. In the clock in which
// both are seen, the word comes first.
module port_events (
    input  logic clk,
    input  logic rst_n,
    input  logic spi_csn,
    input  logic head_toggle,
    input  logic begin_toggle,
    input  logic end_toggle,
    output logic head_in,
    output logic word_begins,
    output logic word_ends,
    output logic deselected
);
    logic selected, head_level, begin_level, end_level;

    synchroniser from_select(.clk, .from_outside(!spi_csn), .level(selected));
    synchroniser from_head(.clk, .from_outside(head_toggle), .level(head_level));
    synchroniser from_begin(.clk, .from_outside(begin_toggle), .level(begin_level));
    synchroniser from_end(.clk, .from_outside(end_toggle), .level(end_level));

    logic selected_before, selected_long_before, head_before, begin_before, end_before;

    // These follow during reset as well: its end is no event.
    always_ff @(posedge clk) begin
        selected_before      <= selected;
        selected_long_before <= selected_before;
        head_before          <= head_level;
        begin_before         <= begin_level;
        end_before           <= end_level;
    end

    assign head_in     = rst_n && head_level != head_before;
    assign word_begins = rst_n && begin_level != begin_before;
    assign word_ends   = rst_n && end_level != end_before;
    assign deselected  = rst_n && selected_long_before && !selected_before;
endmodule
