// The acquisition block: scans an AD7949, keeps whole sets in two banks of block RAM, and hands them to the processor
// through the port of docs/acquisition-port.md, version 2.2.
module acquisition #(
    parameter int CLOCKS_PER_US = 24,
    parameter int ADC_HALF_CLOCKS = 2,
    parameter int ADC_CONVERT_CLOCKS = 84
) (
    input  logic clk,
    // Synchronous to clk.
    input  logic rst_n,

    input  logic spi_sck,
    input  logic spi_csn,
    input  logic spi_mosi,
    output logic spi_miso,
    output logic data_ready,
    output logic scan_ready,
    // READY, for a light.
    output logic waiting,

    output logic adc_cnv,
    output logic adc_sck,
    output logic adc_din,
    input  logic adc_sdo
);
    // The master's clock.
    logic [7:0]  head;
    logic [31:0] received, transmit;
    logic        is_sound, head_toggle, begin_toggle, end_toggle;

    spi_slave slave(
        .spi_sck, .spi_csn, .spi_mosi, .spi_miso,
        .head, .received, .is_sound, .head_toggle, .begin_toggle, .end_toggle, .transmit
    );

    // Our clock, from here on.
    logic head_in, word_begins, word_ends, deselected;

    port_events events(
        .clk, .rst_n, .spi_csn, .head_toggle, .begin_toggle, .end_toggle,
        .head_in, .word_begins, .word_ends, .deselected
    );

    logic [3:0] address;
    logic       beyond, write, fetch, is_burst, read_begins, read_ends, release_set;

    transfer current(
        .clk, .rst_n, .head, .head_in, .word_begins, .word_ends, .deselected, .is_sound,
        .address, .beyond, .write, .fetch, .is_burst, .read_begins, .read_ends, .release_set
    );

    logic [31:0] register_word;
    logic [15:0] lost_modulo;
    logic        run, restart, abandon, overrun;
    logic [19:0] written_period_us;
    logic [9:0]  written_length;
    logic [2:0]  written_halvings;

    registers settings(
        .clk, .rst_n, .address, .beyond, .write, .written(received), .read(register_word),
        .run, .restart, .abandon, .scan_period_us(written_period_us), .set_length(written_length),
        .halvings(written_halvings),
        .ready(waiting), .overrun, .lost(lost_modulo)
    );

    logic [19:0] period_us;
    logic [9:0]  filling_length;
    logic [2:0]  halvings;
    logic [8:0]  scan;
    logic        pass_due, is_first_pass, is_last_pass, scan_due, scan_done, taking, set_full;

    scan_timer #(.CLOCKS_PER_US(CLOCKS_PER_US)) timer(
        .clk, .rst_n, .run, .abandon, .period_us, .halvings, .pass_due, .is_first(is_first_pass), .is_last(is_last_pass)
    );

    // A scan is its last pass to all but timer, converter and decimator: that is when its samples come.
    assign scan_due = pass_due && is_last_pass;

    logic        conversion_in, sample_in;
    logic [1:0]  converted_channel, channel;
    logic [13:0] conversion, sample;

    ad7949_master #(.HALF_CLOCKS(ADC_HALF_CLOCKS), .CONVERT_CLOCKS(ADC_CONVERT_CLOCKS)) converter(
        .clk, .rst_n, .start(pass_due), .adc_cnv, .adc_sck, .adc_din, .adc_sdo,
        .conversion_in, .channel(converted_channel), .conversion
    );

    decimator means(
        .clk, .rst_n, .pass_due, .is_first(is_first_pass), .is_last(is_last_pass), .halvings,
        .conversion_in, .channel_in(converted_channel), .conversion, .sample_in, .channel, .sample
    );

    filler fill(
        .clk, .rst_n, .run, .abandon, .written_period_us, .written_length, .written_halvings, .scan_due, .scan_done,
        .period_us, .length(filling_length), .halvings, .scan, .taking, .set_full
    );

    logic        filling, reading, lost_before, data_ready_next;
    logic [31:0] number, lost_at_read;
    logic [9:0]  waiting_length;

    banks owners(
        .clk, .rst_n, .restart, .set_full, .set_length(filling_length), .filling,
        .read_begins, .read_ends, .release_set, .waiting, .data_ready_next, .reading, .overrun, .lost_modulo,
        .number, .length(waiting_length), .lost_before, .lost_at_read
    );

    logic        sum_write, sums_done;
    logic [5:0]  sum_address;
    logic [15:0] sum_written, sum_before, sum_read;
    logic [4:0]  sum_read_address;

    accumulator sums(
        .clk, .rst_n, .sample_in(sample_in && taking), .channel, .sample, .bank(filling), .first_scan(scan == 9'd0),
        .done(sums_done), .write(sum_write), .address(sum_address), .write_data(sum_written), .read_data(sum_before)
    );

    // The scan is done when its last channel is.
    logic last_channel;
    always_ff @(posedge clk) if (sample_in) last_channel <= channel == 2'd3;
    assign scan_done = sums_done && last_channel;

    // Two copies of the sums, for each can be read by one alone: the accumulator reads the bank that fills, the reader the
    // other.
    memory #(.WIDTH(16), .ADDRESS_BITS(6)) sums_to_add(
        .clk, .write(sum_write), .write_address(sum_address), .write_data(sum_written),
        .read_address(sum_address), .read_data(sum_before)
    );
    memory #(.WIDTH(16), .ADDRESS_BITS(6)) sums_to_read(
        .clk, .write(sum_write), .write_address(sum_address), .write_data(sum_written),
        .read_address({!filling, sum_read_address}), .read_data(sum_read)
    );

    logic [10:0] sample_address;
    logic [15:0] sample_read;

    memory #(.WIDTH(16), .ADDRESS_BITS(12)) samples(
        .clk, .write(sample_in && taking), .write_address({filling, scan, channel}), .write_data({2'b00, sample}),
        .read_address({!filling, sample_address}), .read_data(sample_read)
    );

    // No register shares a transfer with it: its word is 0 where that is theirs.
    logic [31:0] scan_word;
    logic        scan_ready_next;

    latest_scan scans(
        .clk, .rst_n, .restart, .scan_due, .sample_in, .channel, .sample,
        .scan_taken(scan_done && taking && !abandon), .head, .head_in, .fetch, .word(scan_word), .scan_ready_next
    );

    logic settled;

    reader words(
        .clk, .rst_n, .head_in, .fetch, .is_burst, .register_word(register_word | scan_word), .transmit, .settled,
        .reading, .number, .length(waiting_length), .lost_before, .lost_at_read,
        .sum_address(sum_read_address), .sum_half(sum_read), .sample_address, .sample(sample_read)
    );

    output_register ready_pin(.clk, .next(data_ready_next), .pin(data_ready));
    output_register scan_ready_pin(.clk, .next(scan_ready_next), .pin(scan_ready));

`ifdef SYNTHESIS
    logic unused;
    assign unused = settled;
`else
    // A bank that is being read is not written. `owners` keeps it from changing hands; this looks at the memories' wires.
    logic bank_of_reader, was_reading;
    always_ff @(posedge clk) begin
        was_reading <= reading;
        if (reading && !was_reading) bank_of_reader <= !filling;
    end
    assert property (@(posedge clk) disable iff (!rst_n)
        reading && was_reading && sample_in && taking |-> filling != bank_of_reader);
    assert property (@(posedge clk) disable iff (!rst_n)
        reading && was_reading && sum_write |-> sum_address[5] != bank_of_reader);
    assert property (@(posedge clk) disable iff (!rst_n)
        reading && was_reading |-> !filling == bank_of_reader);

    // A word is whole and still when SCK takes it to the shift register. This is what limits SCK to 10 MHz.
    assert property (@(negedge spi_sck) disable iff (!rst_n)
        slave.part != slave.HEAD && slave.place == 5'd0 |-> settled && events.head_level == events.head_before);
`endif
`ifdef FORMAL
    `include "formal/port.sv"
`endif
endmodule
