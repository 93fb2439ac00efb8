/* Reads a board's second line from standard input and prints each scan: number, then of each axis counts and flags.
 *
 *     stty -F /dev/ttyUSB1 460800 raw && ./read_scans < /dev/ttyUSB1
 */
#include <stdio.h>

#include "zerorate_scan.h"

int main(void) {
    zerorate_scan_receiver receiver = {0};
    zerorate_scan scan;
    for (int byte = getchar(); byte != EOF; byte = getchar()) {
        if (zerorate_scan_byte(&receiver, (uint8_t)byte, &scan))
            printf("%lu %.5f %02x %.5f %02x\n", (unsigned long)scan.scan, scan.x.corrected_q16 / 65536.0,
                   (unsigned)scan.x.flags, scan.y.corrected_q16 / 65536.0, (unsigned)scan.y.flags);
    }
    return 0;
}
