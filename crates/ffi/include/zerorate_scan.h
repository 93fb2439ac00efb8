/*
 * The second line of a Zerorate board, for a control loop in C: each scan, corrected, in a frame of 20 bytes (docs/scan-line.md).
 * It stands alone: C99, no library, no memory but what it is given.
 *
 *     zerorate_scan_receiver receiver = {0};
 *     zerorate_scan scan;
 *     ... for each byte that the serial port gives:
 *     if (zerorate_scan_byte(&receiver, byte, &scan) && scan.x.flags & ZERORATE_SCAN_AT_WORK)
 *         use(scan.x.corrected_q16 / 65536.0);
 */
#ifndef ZERORATE_SCAN_H
#define ZERORATE_SCAN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A frame without its zero: 14 bytes, their CRC-32 of 4, and the one that COBS adds. */
#define ZERORATE_SCAN_CONTENT 14u
#define ZERORATE_SCAN_BYTES (ZERORATE_SCAN_CONTENT + 4u + 1u)

/* Bits of an axis's flags. The lowest two are the mode: 0 off, 1 trim, 2 digital, 3 hybrid. */
#define ZERORATE_SCAN_MODE 0x03u
#define ZERORATE_SCAN_AT_WORK 0x04u   /* the law is in force */
#define ZERORATE_SCAN_HELD 0x08u      /* the temperature is not believed: tap and correction are the last ones */
#define ZERORATE_SCAN_OUTSIDE 0x10u   /* it is outside the calibrated range */
#define ZERORATE_SCAN_UNCERTAIN 0x20u /* the correction leans on a history that has not been seen */
#define ZERORATE_SCAN_SETTLING 0x40u  /* a step of the wiper is on its way through the low-pass */
#define ZERORATE_SCAN_SATURATED 0x80u /* the sample stands at an end of the converter */

typedef struct {
    int32_t corrected_q16; /* counts times 65536 */
    uint8_t flags;
} zerorate_scan_axis;

typedef struct {
    uint32_t scan; /* its number since the acquisition was started; a gap is scans that did not come */
    zerorate_scan_axis x, y;
} zerorate_scan;

typedef struct {
    uint8_t bytes[ZERORATE_SCAN_BYTES];
    size_t length; /* one more than fits where there were too many */
} zerorate_scan_receiver;

/* Takes COBS's byte out and puts the zeros back, in place; the content begins at byte 1. */
static inline bool zerorate_scan_unstuff(uint8_t *bytes) {
    size_t next = bytes[0];
    for (size_t place = 1; place < ZERORATE_SCAN_BYTES; place++) {
        if (place == next) {
            next = place + bytes[place];
            bytes[place] = 0;
        }
    }
    return next == ZERORATE_SCAN_BYTES;
}

/* CRC-32 as in Ethernet and zip. */
static inline uint32_t zerorate_scan_crc(const uint8_t *bytes, size_t length) {
    uint32_t crc = 0xFFFFFFFFu;
    for (size_t place = 0; place < length; place++) {
        crc ^= bytes[place];
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1u ? 0xEDB88320u : 0u);
    }
    return ~crc;
}

static inline uint32_t zerorate_scan_word(const uint8_t *bytes) {
    return bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

/* Takes a byte of the line; true when it ends a whole frame, whose scan is then in `scan`. Anything else is passed over: the next
 * frame begins after the next zero. */
static inline bool zerorate_scan_byte(zerorate_scan_receiver *receiver, uint8_t byte, zerorate_scan *scan) {
    if (byte != 0) {
        if (receiver->length < ZERORATE_SCAN_BYTES)
            receiver->bytes[receiver->length] = byte;
        if (receiver->length <= ZERORATE_SCAN_BYTES)
            receiver->length++;
        return false;
    }
    bool is_whole = receiver->length == ZERORATE_SCAN_BYTES && zerorate_scan_unstuff(receiver->bytes);
    receiver->length = 0;
    const uint8_t *content = receiver->bytes + 1;
    if (!is_whole || zerorate_scan_crc(content, ZERORATE_SCAN_CONTENT) != zerorate_scan_word(content + ZERORATE_SCAN_CONTENT))
        return false;
    scan->scan = zerorate_scan_word(content);
    scan->x.corrected_q16 = (int32_t)zerorate_scan_word(content + 4);
    scan->x.flags = content[8];
    scan->y.corrected_q16 = (int32_t)zerorate_scan_word(content + 9);
    scan->y.flags = content[13];
    return true;
}

#endif
