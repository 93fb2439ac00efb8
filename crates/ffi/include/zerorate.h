/* Zerorate: the compensation of a MEMS gyroscope's zero-rate output, for C.
 *
 * Made from crates/ffi by cbindgen: change that, not this. SPDX-License-Identifier: MIT OR Apache-2.0 */

#ifndef ZERORATE_H
#define ZERORATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Axis X.
#define ZERORATE_AXIS_X 0

// Axis Y.
#define ZERORATE_AXIS_Y 1

// Nothing is compensated: the control of a compensation test.
#define ZERORATE_MODE_OFF 0

// The wiper follows the temperature.
#define ZERORATE_MODE_TRIM 1

// The wiper stays; the drift is subtracted in numbers.
#define ZERORATE_MODE_DIGITAL 2

// The wiper follows the temperature, and what is left below a tap is subtracted in numbers.
#define ZERORATE_MODE_HYBRID 3

// The temperature lies in the calibrated range.
#define ZERORATE_INSIDE 0

// Below the calibrated range: the temperature was held at its lower end.
#define ZERORATE_BELOW 1

// Above the calibrated range: the temperature was held at its upper end.
#define ZERORATE_ABOVE 2

// The group was empty.
#define ZERORATE_INVALID 3

// 64-bit words of a unit's storage: more than its laws and state take on any target.
#define ZERORATE_UNIT_WORDS 768

// What came of a call.
typedef enum {
  // It was done.
  ZERORATE_RESULT_DONE = 0,
  // A pointer was null.
  ZERORATE_RESULT_NULL_POINTER = 1,
  // The unit was not initialised from a record.
  ZERORATE_RESULT_NOT_INITIALISED = 2,
  // There is no such axis, mode or tap.
  ZERORATE_RESULT_OUT_OF_RANGE = 3,
  // The bytes are not a record, or were cut or changed: fetch them again.
  ZERORATE_RESULT_DAMAGED_RECORD = 4,
  // The record is of a version that this library does not know: make it anew from calibration.json.
  ZERORATE_RESULT_UNKNOWN_VERSION = 5,
  // The record belongs to a unit of another serial.
  ZERORATE_RESULT_OTHER_UNIT = 6,
  // The record's law cannot be run: compose it again.
  ZERORATE_RESULT_LAW_REFUSED = 7,
  // The mode moves the wiper and this calibration cannot: use digital.
  ZERORATE_RESULT_NO_EDGES = 8,
} zerorate_result;

// A unit's storage. C provides it, `zerorate_init` fills it; what is in it is nobody else's business.
typedef struct {
  // Opaque; words, so that it lies where laws may lie.
  uint64_t opaque[ZERORATE_UNIT_WORDS];
} zerorate_unit;

// The sums of one axis's samples in a group. Start from zeros; `zerorate_push` adds a sample.
typedef struct {
  // Number of samples.
  uint32_t n;
  // Sum of the temperature samples, counts.
  uint64_t temperature;
  // Sum of the zero-rate samples, counts.
  uint64_t zro;
} zerorate_group;

// What closing a group came to.
typedef struct {
  // The group's mean, corrected, in steps of 1/65536 count; the plain mean in the modes that do not correct.
  // Of a reading from 32768 counts on, less 65536 counts.
  int32_t corrected_q16;
  // Where the temperature lies against the calibrated range: `ZERORATE_INSIDE`, `_BELOW`, `_ABOVE` or `_INVALID`.
  uint32_t coverage;
  // The tap at which the wiper should be.
  uint16_t tap;
  // Whether the wiper is elsewhere: write `tap`, then call `zerorate_wiper_written`.
  bool write_wiper;
  // Whether the history that the correction rests on was seen; always so for a calibration without history. Until it
  // was, after a start, the correction is uncertain by up to what it adds.
  bool history_known;
} zerorate_outcome;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Fills a unit from the bytes of a device record (`device-record.bin`). `serial` is the unit's own, ended by a zero byte;
// a record of another serial is refused; null takes any. Both wipers are taken to stand at the middle tap, 511: write
// that tap before the first group. The modes are those that the record gives for start-up.
//
// Takes some 20 KiB of stack: call it once, at start-up, not from an interrupt.
//
// # Safety
// `unit` is null or leads to a `ZerorateUnit` (its contents may be anything), `record` is null or leads to `length` bytes,
// `serial` is null or leads to a string ended by a zero byte.
zerorate_result zerorate_init(zerorate_unit *unit,
                              const uint8_t *record,
                              size_t length,
                              const char *serial);

// Changes an axis's mode; the wiper stays until the next group.
//
// # Safety
// `unit` is null or leads to a `ZerorateUnit`.
zerorate_result zerorate_set_mode(zerorate_unit *unit, uint32_t axis, uint32_t mode);

// Adds one sample of temperature and zero-rate output, counts, to a group.
//
// # Safety
// `group` is null or leads to a `ZerorateGroup`.
zerorate_result zerorate_push(zerorate_group *group, uint16_t temperature, uint16_t zro);

// Corrects one sample as it comes, by the temperature of the last closed group and the wiper as far as it has settled;
// `corrected_q16` gets it in steps of 1/65536 count. The plain sample in the modes that do not correct. Of a reading from 32768 on,
// less 65536 counts.
//
// Call it for every sample or for none: `zerorate_update` passes over those that it was not shown.
//
// # Safety
// `unit` is null or leads to a `ZerorateUnit`, `corrected_q16` is null or leads to an `int32_t`.
zerorate_result zerorate_correct(zerorate_unit *unit,
                                 uint32_t axis,
                                 uint16_t zro,
                                 int32_t *corrected_q16);

// Closes an axis's group: `outcome` gets its corrected mean, and the tap for its temperature.
//
// # Safety
// `unit`, `group` and `outcome` are null or lead to objects of their types.
zerorate_result zerorate_update(zerorate_unit *unit,
                                uint32_t axis,
                                const zerorate_group *group,
                                zerorate_outcome *outcome);

// Says that the wiper was written. A write that failed is not said: the law then asks again with the next group.
//
// # Safety
// `unit` is null or leads to a `ZerorateUnit`.
zerorate_result zerorate_wiper_written(zerorate_unit *unit,
                                       uint32_t axis,
                                       uint16_t tap);

// Says that `groups` groups of `n` samples each were lost before the one that is being filled: the wiper settles
// meanwhile, and a history goes on.
//
// # Safety
// `unit` is null or leads to a `ZerorateUnit`.
zerorate_result zerorate_groups_lost(zerorate_unit *unit,
                                     uint32_t axis,
                                     uint32_t groups,
                                     uint32_t n);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* ZERORATE_H */
