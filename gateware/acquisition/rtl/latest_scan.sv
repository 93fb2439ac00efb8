// The scan that was taken last, with its number and their CRC inverted (address 0x20), and the line that says that it is there.
//
// The samples of a scan gather beside the last one while it is taken, and take its place when the scan is done. A read has
// its own copy, from the last bit of the address byte on: a scan that is done meanwhile is read next, however slow the master.
module latest_scan (
    input  logic        clk,
    input  logic        rst_n,
    input  logic        restart,

    input  logic        scan_due,
    input  logic        sample_in,
    input  logic [1:0]  channel,
    input  logic [13:0] sample,
    // A scan is whole, and counts.
    input  logic        scan_taken,

    input  logic [7:0]  head,
    input  logic        head_in,
    // The word before has gone: the next one is `word`.
    input  logic        fetch,
    output logic [31:0] word,

    // Scan ready as it is after this clock, for the pin's flip-flop.
    output logic        scan_ready_next
);
    localparam logic [7:0] READ_SCAN = 8'h20;
    // Past the last one.
    localparam logic [2:0] OVER = 3'd4;

    logic [13:0] gathered [4];
    logic [55:0] latest, copy;
    logic [31:0] next_number, number;
    logic        is_there, is_copied, scan_ready;

    always_comb begin
        if (!rst_n || restart) scan_ready_next = 1'b0;
        else if (scan_taken) scan_ready_next = 1'b1;
        else if (scan_due) scan_ready_next = 1'b0;
        else scan_ready_next = scan_ready;
    end

    always_ff @(posedge clk) begin
        if (sample_in) gathered[channel] <= sample;
        if (!rst_n || restart) begin
            next_number <= 32'd0;
            is_there    <= 1'b0;
        end else if (scan_taken) begin
            next_number <= next_number + 32'd1;
            is_there    <= 1'b1;
        end
        scan_ready <= scan_ready_next;
        if (scan_taken) latest <= {gathered[0], gathered[1], gathered[2], gathered[3]};
    end

    logic [2:0]  place, summed;
    logic [31:0] crc, to_sum;
    logic        crc_busy, crc_start;

    always_ff @(posedge clk) begin
        crc_start <= 1'b0;
        if (!rst_n) begin
            place     <= OVER;
            summed    <= OVER;
            is_copied <= 1'b0;
        end else if (head_in) begin
            place     <= head == READ_SCAN ? 3'd0 : OVER;
            summed    <= 3'd0;
            crc_start <= 1'b1;
            is_copied <= is_there;
            copy      <= latest;
            number    <= next_number - 32'd1;
        end else begin
            if (fetch && place != OVER) place <= place + 3'd1;
            // Words 0 to 2, one after the other: 102 clocks, and 72 of SCK until word 3 is asked for, which are 172.
            if (!crc_busy && !crc_start && summed < 3'd2) begin
                summed    <= summed + 3'd1;
                crc_start <= 1'b1;
            end
        end
    end

    function automatic logic [31:0] content(input logic [2:0] index);
        case (index)
            3'd0: content = number;
            3'd1: content = {2'b00, copy[55:42], 2'b00, copy[41:28]};
            default: content = {2'b00, copy[27:14], 2'b00, copy[13:0]};
        endcase
    endfunction

    assign to_sum = content(summed);

    always_comb begin
        if (!is_copied || place == OVER) word = 32'd0;
        else word = place == 3'd3 ? ~crc : content(place);
    end

    crc32 of_scan(.clk, .clear(head_in || !rst_n), .start(crc_start), .word(to_sum), .busy(crc_busy), .crc);

`ifndef SYNTHESIS
    // The CRC is whole when it is asked for, and of three words.
    assert property (@(posedge clk) disable iff (!rst_n) fetch && place == 3'd3 |-> !crc_busy && !crc_start && summed == 3'd2);
`endif
endmodule
