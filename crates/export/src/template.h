/* In floating point. Define ZERORATE_REAL as double before the include where the processor has it. */

#ifndef ZERORATE_NO_FLOAT

#include <math.h>

#ifndef ZERORATE_REAL
#define ZERORATE_REAL float
#endif

typedef ZERORATE_REAL zr_real;

/* A curve of temperature: a polynomial in (T - centre) / half_span, constant first, or straight lines between values at
   equal steps from centre - half_span to centre + half_span. */
typedef struct {
    int is_table;
    int count;
    zr_real centre, half_span;
    zr_real values[ZR_VALUES];
} zr_curve;

/* A memory m of the temperature: a play of half-width size, or a lag of time constant size. It adds weight * (m - T), and
   the curve is taken at T + behind * (m - T), of several memories their sum. */
typedef struct {
    int is_play;
    zr_real size, weight, behind, share;
} zr_term;

/* One axis. `fixed` is the curve where nothing of the history is known; with `terms` above 0, `known` is the one where
   all is. Temperatures are clamped to least..most. */
typedef struct {
    const char *name;
    zr_real least, most;
    zr_curve fixed;
    int terms;
    zr_curve known;
    zr_term term[ZR_TERMS];
} zr_axis;

/* What an axis has seen of the temperature. Zero it at start-up. Axes without terms need none. */
typedef struct {
    int started;
    zr_real last, least, most, since_start_s;
    zr_real ahead[ZR_TERMS];
} zr_state;

static inline zr_real zr_clamp(zr_real value, zr_real least, zr_real most)
{
    return value < least ? least : (value > most ? most : value);
}

static inline zr_real zr_curve_at(const zr_curve *curve, zr_real temperature)
{
    zr_real x = (temperature - curve->centre) / curve->half_span;
    if (curve->is_table) {
        int pieces = curve->count - 1, piece;
        zr_real at = (zr_clamp(x, (zr_real)-1, (zr_real)1) + 1) / 2 * (zr_real)pieces;
        piece = (int)at < pieces - 1 ? (int)at : pieces - 1;
        return curve->values[piece] + (curve->values[piece + 1] - curve->values[piece]) * (at - (zr_real)piece);
    }
    zr_real sum = 0;
    for (int i = curve->count - 1; i >= 0; i--)
        sum = sum * x + curve->values[i];
    return sum;
}

/* The bias of an axis by the temperature alone. Subtract it from the reading. */
static inline zr_real zr_bias(const zr_axis *axis, zr_real temperature)
{
    return zr_curve_at(&axis->fixed, zr_clamp(temperature, axis->least, axis->most));
}

/* Takes in a temperature that is `seconds` later than the last one. */
static inline void zr_advance(const zr_axis *axis, zr_state *state, zr_real temperature, zr_real seconds)
{
    zr_real now = zr_clamp(temperature, axis->least, axis->most);
    if (!state->started) {
        state->started = 1;
        state->last = state->least = state->most = now;
        state->since_start_s = 0;
        for (int i = 0; i < axis->terms; i++)
            state->ahead[i] = 0;
        return;
    }
    if (now < state->least)
        state->least = now;
    if (now > state->most)
        state->most = now;
    state->since_start_s += seconds;
    for (int i = 0; i < axis->terms; i++) {
        const zr_term *term = &axis->term[i];
        if (term->is_play) {
            zr_real before = state->last + state->ahead[i];
            if (state->most - state->least < 2 * term->size)
                state->ahead[i] = (state->least + state->most) / 2 - now;
            else
                state->ahead[i] = zr_clamp(before, now - term->size, now + term->size) - now;
        } else {
            zr_real x = seconds / term->size;
            zr_real kept = (zr_real)exp(-(double)x);
            zr_real follows = x > (zr_real)1e-9 ? (zr_real)(-expm1(-(double)x) / (double)x) : (zr_real)1;
            state->ahead[i] = state->ahead[i] * kept - (now - state->last) * follows;
        }
    }
    state->last = now;
}

/* How much of the history was seen, 0 to 1: below 0.95 the bias is uncertain by up to what it adds. 1 of an axis without one. */
static inline zr_real zr_known_share(const zr_axis *axis, const zr_state *state)
{
    zr_real sum = 0;
    if (axis->terms == 0)
        return 1;
    if (!state->started)
        return 0;
    for (int i = 0; i < axis->terms; i++) {
        const zr_term *term = &axis->term[i];
        zr_real seen;
        if (term->is_play) {
            seen = (state->most - state->least) / (2 * term->size);
            seen = seen < 1 ? seen : 1;
        } else {
            seen = (zr_real)(1 - exp(-(double)(state->since_start_s / term->size)));
        }
        sum += term->share * seen * seen / (seen * seen + (1 - seen) * (1 - seen));
    }
    return sum < 1 ? sum : 1;
}

/* The bias of an axis by what zr_advance took in last. */
static inline zr_real zr_bias_with_history(const zr_axis *axis, const zr_state *state)
{
    zr_real added = 0, behind = 0;
    if (axis->terms == 0)
        return zr_curve_at(&axis->fixed, state->last);
    for (int i = 0; i < axis->terms; i++) {
        added += axis->term[i].weight * state->ahead[i];
        behind += axis->term[i].behind * state->ahead[i];
    }
    /* What drifts was never colder or hotter than what was seen. */
    return zr_curve_at(&axis->known, zr_clamp(state->last + behind, state->least, state->most)) + added;
}

#endif /* ZERORATE_NO_FLOAT */

/* In integers: temperatures in 65536ths, biases in ZR_AXIS_..._UNIT (above, for each axis). For processors without floating point. */

#define ZR_ONE ((int64_t)1 << 30) /* 1 in the scaled variable and in shares */
#define ZR_KEPT_ONE ((int64_t)1 << 24) /* 1 in what a lag keeps and follows a step */

/* `inverse` is 2^44 / half_span; values are in the axis's unit. */
typedef struct {
    int32_t is_table, count, centre;
    int64_t inverse;
    int32_t values[ZR_VALUES];
} zr_int_curve;

/* `size` of a play in 2^-20 of a degree; `kept` and `follows` of a lag over one step; `weight` in the axis's unit a degree
   times 2^weight_bits; behind in 2^-20; share in 2^-30. */
typedef struct {
    int32_t is_play;
    int64_t size;
    int32_t kept, follows, weight, behind, share;
} zr_int_term;

typedef struct {
    int32_t least, most;
    zr_int_curve fixed;
    int32_t terms, weight_bits;
    zr_int_curve known;
    zr_int_term term[ZR_TERMS];
} zr_int_axis;

/* Zero it at start-up. `ahead`, and temperatures of plays, are in 2^-20 of a degree. */
typedef struct {
    int32_t started, last, least, most;
    int64_t ahead[ZR_TERMS];
    int64_t forgotten[ZR_TERMS];
} zr_int_state;

static inline int32_t zr_int_clamp(int32_t value, int32_t least, int32_t most)
{
    return value < least ? least : (value > most ? most : value);
}

/* a / 2^bits, rounded. */
static inline int64_t zr_shift(int64_t a, int bits)
{
    return (a + ((int64_t)1 << (bits - 1))) >> bits;
}

static inline int32_t zr_int_curve_at(const zr_int_curve *curve, int32_t temperature)
{
    int64_t x = zr_shift(((int64_t)temperature - curve->centre) * curve->inverse, 30);
    if (curve->is_table) {
        int64_t pieces = curve->count - 1, piece;
        x = x < -ZR_ONE ? -ZR_ONE : (x > ZR_ONE ? ZR_ONE : x);
        int64_t at = (x + ZR_ONE) * pieces;
        piece = (at >> 31) < pieces - 1 ? at >> 31 : pieces - 1;
        int64_t rise = (int64_t)curve->values[piece + 1] - curve->values[piece];
        return (int32_t)(curve->values[piece] + zr_shift(rise * ((at - (piece << 31)) >> 1), 30));
    }
    int64_t sum = 0;
    for (int32_t i = curve->count - 1; i >= 0; i--)
        sum = zr_shift(sum * x, 30) + curve->values[i];
    return (int32_t)sum;
}

/* The bias by the temperature alone. */
static inline int32_t zr_int_bias(const zr_int_axis *axis, int32_t temperature)
{
    return zr_int_curve_at(&axis->fixed, zr_int_clamp(temperature, axis->least, axis->most));
}

/* Takes in a temperature. Call it every ZR_STEP_MS. */
static inline void zr_int_advance(const zr_int_axis *axis, zr_int_state *state, int32_t temperature)
{
    int32_t now = zr_int_clamp(temperature, axis->least, axis->most);
    if (!state->started) {
        state->started = 1;
        state->last = state->least = state->most = now;
        for (int32_t i = 0; i < axis->terms; i++) {
            state->ahead[i] = 0;
            state->forgotten[i] = ZR_ONE;
        }
        return;
    }
    if (now < state->least)
        state->least = now;
    if (now > state->most)
        state->most = now;
    int64_t rise = ((int64_t)now - state->last) * 16;
    int64_t seen = ((int64_t)state->most - state->least) * 16;
    for (int32_t i = 0; i < axis->terms; i++) {
        const zr_int_term *term = &axis->term[i];
        if (term->is_play) {
            int64_t ahead = state->ahead[i] - rise;
            if (seen < 2 * term->size)
                ahead = ((int64_t)state->least + state->most) * 8 - (int64_t)now * 16;
            else if (ahead < -term->size)
                ahead = -term->size;
            else if (ahead > term->size)
                ahead = term->size;
            state->ahead[i] = ahead;
        } else {
            state->ahead[i] = zr_shift(state->ahead[i] * term->kept - rise * term->follows, 24);
            state->forgotten[i] = zr_shift(state->forgotten[i] * term->kept, 24);
        }
    }
    state->last = now;
}

/* How much of the history was seen, in 2^-30: below 0.95 the bias is uncertain by up to what it adds. 1 of an axis without one. */
static inline int64_t zr_int_known_share(const zr_int_axis *axis, const zr_int_state *state)
{
    int64_t sum = 0;
    if (axis->terms == 0)
        return ZR_ONE;
    if (!state->started)
        return 0;
    for (int32_t i = 0; i < axis->terms; i++) {
        const zr_int_term *term = &axis->term[i];
        int64_t seen = ((int64_t)state->most - state->least) * 16, share;
        if (!term->is_play)
            share = ZR_ONE - state->forgotten[i];
        else if (seen >= 2 * term->size)
            share = ZR_ONE;
        else /* both fit in 44 bits: 18 more are room enough */
            share = ((seen << 18) / (2 * term->size)) << 12;
        int64_t k = zr_shift(share * share, 30), u = zr_shift((ZR_ONE - share) * (ZR_ONE - share), 30);
        sum += zr_shift(term->share * ((k << 30) / (k + u)), 30);
    }
    return sum < ZR_ONE ? sum : ZR_ONE;
}

/* The bias by what zr_int_advance took in last. */
static inline int32_t zr_int_bias_with_history(const zr_int_axis *axis, const zr_int_state *state)
{
    if (axis->terms == 0)
        return zr_int_curve_at(&axis->fixed, state->last);
    int64_t added = 0, behind = 0;
    for (int32_t i = 0; i < axis->terms; i++) {
        added += zr_shift(state->ahead[i] * axis->term[i].weight, 20);
        behind += zr_shift(state->ahead[i] * axis->term[i].behind, 24);
    }
    /* What drifts was never colder or hotter than what was seen. */
    behind += state->last;
    behind = behind < state->least ? state->least : (behind > state->most ? state->most : behind);
    int64_t bias = zr_int_curve_at(&axis->known, (int32_t)behind);
    bias += axis->weight_bits ? zr_shift(added, (int)axis->weight_bits) : added;
    return (int32_t)bias;
}
