/* A C firmware's loop around the compensation, run on a PC: it reads groups as lines
 *     n temperature_sum zro_sum
 * (n = 0: a group that was lost), takes each past one axis, "writes" the wiper when it is asked to, and prints a line for each:
 *     tap corrected_q16 coverage history_known wiper_writes
 *
 *     closed_loop device-record.bin SERIAL|- AXIS MODE < groups.txt
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "zerorate.h"

#define SAMPLES_PER_GROUP 4

/* On a board: 6 KiB of static RAM. */
static zerorate_unit unit;
/* On a board: flash, or what the host sent. */
static uint8_t record[8192];

static int refuse(const char *what, zerorate_result result) {
    fprintf(stderr, "%s: refused with %d\n", what, (int)result);
    return EXIT_FAILURE;
}

int main(int argc, char **argv) {
    if (argc != 5) {
        fprintf(stderr, "usage: %s device-record.bin SERIAL|- AXIS MODE < groups\n", argv[0]);
        return 2;
    }
    FILE *file = fopen(argv[1], "rb");
    if (file == NULL) {
        perror(argv[1]);
        return 2;
    }
    size_t length = fread(record, 1, sizeof record, file);
    fclose(file);

    const char *serial = strcmp(argv[2], "-") == 0 ? NULL : argv[2];
    uint32_t axis = (uint32_t)atoi(argv[3]);
    zerorate_result result = zerorate_init(&unit, record, length, serial);
    if (result != ZERORATE_RESULT_DONE) {
        return refuse("zerorate_init", result);
    }
    result = zerorate_set_mode(&unit, axis, (uint32_t)atoi(argv[4]));
    if (result != ZERORATE_RESULT_DONE) {
        return refuse("zerorate_set_mode", result);
    }

    unsigned writes = 0;
    zerorate_group group;
    while (scanf("%" SCNu32 " %" SCNu64 " %" SCNu64, &group.n, &group.temperature, &group.zro) == 3) {
        if (group.n == 0) {
            zerorate_groups_lost(&unit, axis, 1, SAMPLES_PER_GROUP);
            continue;
        }
        zerorate_outcome outcome;
        result = zerorate_update(&unit, axis, &group, &outcome);
        if (result != ZERORATE_RESULT_DONE) {
            return refuse("zerorate_update", result);
        }
        if (outcome.write_wiper) {
            /* Here a board writes the potentiometer, and only says so if that went well. */
            zerorate_wiper_written(&unit, axis, outcome.tap);
            writes++;
        }
        printf("%u %" PRId32 " %" PRIu32 " %d %u\n", outcome.tap, outcome.corrected_q16, outcome.coverage,
               outcome.history_known, writes);
    }
    return EXIT_SUCCESS;
}
