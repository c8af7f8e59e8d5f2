#include "real.h"

typedef unsigned __int128 wide;

enum { TOP = 62 };

struct layout {
  int32_t exponent_bits, fraction_bits;
};

static const struct layout LAYOUTS[] = {[HALF] = {5, 10}, [SINGLE] = {8, 23}, [DOUBLE] = {11, 52}};

static const struct hil_real DEFAULT_NAN = {QUIET_NAN, false, 0, (uint64_t)1 << (TOP - 1)};

enum hil_rounding hil_rounding_of(const uint32_t *fpscr) {
  return (enum hil_rounding)(*fpscr >> 22 & 3);
}

static int32_t least_exponent(const struct layout *layout) { return 2 - (1 << (layout->exponent_bits - 1)); }

static uint64_t shifted_right_sticky(uint64_t value, uint32_t by) {
  if (by == 0)
    return value;
  if (by > 63)
    return value != 0;
  return value >> by | ((value & (((uint64_t)1 << by) - 1)) != 0);
}

static wide wide_right_sticky(wide value, uint32_t by) {
  if (by == 0)
    return value;
  if (by > 127)
    return value != 0;
  return value >> by | ((value & (((wide)1 << by) - 1)) != 0);
}

/* A finite number of 128 bits, brought to the form of `hil_real`; zero becomes ZERO. */
static struct hil_real normalized(bool negative, int32_t exponent, wide significand) {
  struct hil_real value = {ZERO, negative, 0, 0};
  if (significand == 0)
    return value;
  uint64_t upper = (uint64_t)(significand >> 64);
  int32_t highest = upper ? 127 - __builtin_clzll(upper) : 63 - __builtin_clzll((uint64_t)significand);
  int32_t by = highest - TOP;
  value.kind = FINITE;
  value.exponent = exponent + by;
  value.significand = (uint64_t)(by > 0 ? wide_right_sticky(significand, (uint32_t)by) : significand << -by);
  return value;
}

/* FPUnpack. Half precision is never flushed, and has neither infinities nor NaN with AHP. */
struct hil_real hil_unpack(uint64_t bits, enum hil_format format, uint32_t *fpscr) {
  const struct layout *layout = &LAYOUTS[format];
  int32_t width = layout->exponent_bits, fraction_bits = layout->fraction_bits;
  uint64_t fraction = bits & (((uint64_t)1 << fraction_bits) - 1);
  int32_t exponent = (int32_t)(bits >> fraction_bits & ((1u << width) - 1));
  bool negative = bits >> (width + fraction_bits) & 1, has_infinity = format != HALF || !(*fpscr & FPSCR_AHP);
  struct hil_real value = {ZERO, negative, 0, 0};
  if (exponent == (1 << width) - 1 && has_infinity) {
    value.kind = !fraction ? INFINITE : fraction >> (fraction_bits - 1) ? QUIET_NAN : SIGNALLING_NAN;
    value.significand = fraction << (TOP - fraction_bits);
    return value;
  }
  if (exponent == 0 && fraction && format != HALF && *fpscr & FPSCR_FZ) {
    *fpscr |= FPSCR_IDC;
    return value;
  }
  uint64_t significand = exponent ? fraction | (uint64_t)1 << fraction_bits : fraction;
  return normalized(negative, least_exponent(layout) - fraction_bits + (exponent ? exponent - 1 : 0), significand);
}

/* Whether a magnitude is rounded up, by what is below its last bit: `rest` of `unit`. */
static bool rounds_up(enum hil_rounding rounding, bool negative, bool odd, uint64_t rest, uint64_t unit) {
  uint64_t middle = unit >> 1;
  switch (rounding) {
  case TO_NEAREST: return rest > middle || (rest == middle && odd);
  case TO_PLUS_INFINITY: return rest && !negative;
  case TO_MINUS_INFINITY: return rest && negative;
  case TO_ZERO: return false;
  default: return rest >= middle;
  }
}

static uint64_t packed(const struct layout *layout, bool negative, uint64_t exponent, uint64_t fraction) {
  return (uint64_t)negative << (layout->exponent_bits + layout->fraction_bits) | exponent << layout->fraction_bits |
         fraction;
}

static uint64_t overflowed(const struct layout *layout, bool negative, enum hil_rounding rounding,
                           uint32_t *fpscr) {
  uint64_t most = ((uint64_t)1 << layout->exponent_bits) - 1;
  bool to_infinity = rounding == TO_NEAREST || rounding == TO_NEAREST_AWAY ||
                     (rounding == TO_PLUS_INFINITY && !negative) || (rounding == TO_MINUS_INFINITY && negative);
  *fpscr |= FPSCR_OFC | FPSCR_IXC;
  if (to_infinity)
    return packed(layout, negative, most, 0);
  return packed(layout, negative, most - 1, ((uint64_t)1 << layout->fraction_bits) - 1);
}

/* FPRound of a number that is neither zero, infinite nor NaN. */
static uint64_t rounded(struct hil_real value, enum hil_format format, enum hil_rounding rounding,
                        uint32_t *fpscr) {
  const struct layout *layout = &LAYOUTS[format];
  int32_t exponent = value.exponent + TOP, least = least_exponent(layout);
  if (format != HALF && *fpscr & FPSCR_FZ && exponent < least) {
    *fpscr |= FPSCR_UFC;
    return packed(layout, value.negative, 0, 0);
  }
  uint64_t significand = value.significand, biased = 0;
  if (exponent >= least)
    biased = (uint64_t)(exponent - least + 1);
  else
    significand = shifted_right_sticky(significand, (uint32_t)(least - exponent));
  uint32_t below = (uint32_t)(TOP - layout->fraction_bits);
  uint64_t unit = (uint64_t)1 << below, rest = significand & (unit - 1), kept = significand >> below;
  if (!biased && rest)
    *fpscr |= FPSCR_UFC;
  if (rounds_up(rounding, value.negative, kept & 1, rest, unit)) {
    kept++;
    if (kept >> layout->fraction_bits == 1 && !biased)
      biased = 1;
    if (kept >> layout->fraction_bits == 2) {
      kept >>= 1;
      biased++;
    }
  }
  uint64_t end = ((uint64_t)1 << layout->exponent_bits) - 1;
  uint64_t fraction = kept & (((uint64_t)1 << layout->fraction_bits) - 1);
  if (format == HALF && *fpscr & FPSCR_AHP) {
    if (biased > end) {
      *fpscr |= FPSCR_IOC;
      return packed(layout, value.negative, end, ((uint64_t)1 << layout->fraction_bits) - 1);
    }
  } else if (biased >= end) {
    return overflowed(layout, value.negative, rounding, fpscr);
  }
  if (rest)
    *fpscr |= FPSCR_IXC;
  return packed(layout, value.negative, biased, fraction);
}

/* Put a number into a format: rounded if need be, or as the zero, infinity or NaN that it is. */
uint64_t hil_round(struct hil_real value, enum hil_format format, enum hil_rounding rounding,
                   uint32_t *fpscr) {
  const struct layout *layout = &LAYOUTS[format];
  uint64_t most = ((uint64_t)1 << layout->exponent_bits) - 1;
  switch (value.kind) {
  case ZERO: return packed(layout, value.negative, 0, 0);
  case FINITE: return rounded(value, format, rounding, fpscr);
  case INFINITE: return packed(layout, value.negative, most, 0);
  default: return packed(layout, value.negative, most, value.significand >> (TOP - layout->fraction_bits));
  }
}

/* --- NaN */

static bool is_nan(struct hil_real value) { return value.kind >= QUIET_NAN; }

/* FPProcessNaN */
struct hil_real hil_nan_converted(struct hil_real nan, uint32_t *fpscr) {
  if (nan.kind == SIGNALLING_NAN)
    *fpscr |= FPSCR_IOC;
  if (*fpscr & FPSCR_DN)
    return DEFAULT_NAN;
  nan.kind = QUIET_NAN;
  nan.significand |= (uint64_t)1 << (TOP - 1);
  return nan;
}

/* FPProcessNaNs and FPProcessNaNs3: signalling ones first, each in the order of the operands. */
static bool take_nan(const struct hil_real *operands, uint32_t count, struct hil_real *result,
                     uint32_t *fpscr) {
  for (int kind = SIGNALLING_NAN; kind >= QUIET_NAN; kind--)
    for (uint32_t n = 0; n < count; n++)
      if ((int)operands[n].kind == kind) {
        *result = hil_nan_converted(operands[n], fpscr);
        return true;
      }
  return false;
}

static struct hil_real invalid(uint32_t *fpscr) {
  *fpscr |= FPSCR_IOC;
  return DEFAULT_NAN;
}

/* --- arithmetic */

struct hil_real hil_negated(struct hil_real value) {
  value.negative = !value.negative;
  return value;
}

static struct hil_real zero(bool negative) { return (struct hil_real){ZERO, negative, 0, 0}; }
static struct hil_real infinity(bool negative) { return (struct hil_real){INFINITE, negative, 0, 0}; }

/* The zero that an exact sum of unlike numbers is. */
static struct hil_real nothing_left(const uint32_t *fpscr) {
  return zero(hil_rounding_of(fpscr) == TO_MINUS_INFINITY);
}

/* A finite number with room below for what is shifted out of it. */
struct term {
  bool negative;
  int32_t exponent;
  wide significand;
};

static struct hil_real sum_of(struct term a, struct term b, const uint32_t *fpscr) {
  if (a.exponent < b.exponent) {
    struct term other = a;
    a = b;
    b = other;
  }
  b.significand = wide_right_sticky(b.significand, (uint32_t)(a.exponent - b.exponent));
  if (a.negative == b.negative)
    return normalized(a.negative, a.exponent, a.significand + b.significand);
  if (a.significand == b.significand)
    return nothing_left(fpscr);
  if (a.significand > b.significand)
    return normalized(a.negative, a.exponent, a.significand - b.significand);
  return normalized(b.negative, a.exponent, b.significand - a.significand);
}

/* The highest bit of every term is 124 or 125: there is room for a carry, and for a hundred bits below. */
static struct term term_of(struct hil_real value) {
  return (struct term){value.negative, value.exponent - TOP, (wide)value.significand << TOP};
}

static struct hil_real sum(struct hil_real a, struct hil_real b, const uint32_t *fpscr) {
  if (a.kind == ZERO && b.kind == ZERO)
    return a.negative == b.negative ? a : nothing_left(fpscr);
  if (a.kind == ZERO)
    return b;
  if (b.kind == ZERO)
    return a;
  return sum_of(term_of(a), term_of(b), fpscr);
}

struct hil_real hil_add(struct hil_real a, struct hil_real b,
                        uint32_t *fpscr) {
  struct hil_real result, operands[] = {a, b};
  if (take_nan(operands, 2, &result, fpscr))
    return result;
  if (a.kind == INFINITE && b.kind == INFINITE && a.negative != b.negative)
    return invalid(fpscr);
  if (a.kind == INFINITE || b.kind == INFINITE)
    return a.kind == INFINITE ? a : b;
  return sum(a, b, fpscr);
}

static struct term product(struct hil_real a, struct hil_real b) {
  return (struct term){a.negative != b.negative, a.exponent + b.exponent, (wide)a.significand * b.significand};
}

static bool is_infinity_times_zero(struct hil_real a, struct hil_real b) {
  return (a.kind == INFINITE && b.kind == ZERO) || (a.kind == ZERO && b.kind == INFINITE);
}

struct hil_real hil_multiply(struct hil_real a, struct hil_real b,
                             uint32_t *fpscr) {
  struct hil_real result, operands[] = {a, b};
  if (take_nan(operands, 2, &result, fpscr))
    return result;
  if (is_infinity_times_zero(a, b))
    return invalid(fpscr);
  bool negative = a.negative != b.negative;
  if (a.kind == INFINITE || b.kind == INFINITE)
    return infinity(negative);
  if (a.kind == ZERO || b.kind == ZERO)
    return zero(negative);
  struct term exact = product(a, b);
  return normalized(exact.negative, exact.exponent, exact.significand);
}

/* 2^64 times one significand divided by another, bit by bit; the last bit tells whether anything is left. */
static wide quotient_of(uint64_t dividend, uint64_t divisor) {
  wide quotient = dividend >= divisor;
  uint64_t rest = quotient ? dividend - divisor : dividend;
  for (int bit = 0; bit < 64; bit++) {
    rest <<= 1;
    bool fits = rest >= divisor;
    rest -= fits ? divisor : 0;
    quotient = quotient << 1 | fits;
  }
  return quotient | (rest != 0);
}

struct hil_real hil_divide(struct hil_real a, struct hil_real b,
                           uint32_t *fpscr) {
  struct hil_real result, operands[] = {a, b};
  if (take_nan(operands, 2, &result, fpscr))
    return result;
  if ((a.kind == INFINITE && b.kind == INFINITE) || (a.kind == ZERO && b.kind == ZERO))
    return invalid(fpscr);
  bool negative = a.negative != b.negative;
  if (b.kind == ZERO && a.kind == FINITE)
    *fpscr |= FPSCR_DZC;
  if (a.kind == INFINITE || b.kind == ZERO)
    return infinity(negative);
  if (a.kind == ZERO || b.kind == INFINITE)
    return zero(negative);
  return normalized(negative, a.exponent - b.exponent - 64, quotient_of(a.significand, b.significand));
}

struct hil_real hil_square_root(struct hil_real a, uint32_t *fpscr) {
  struct hil_real result;
  if (take_nan(&a, 1, &result, fpscr))
    return result;
  if (a.kind == ZERO || (a.kind == INFINITE && !a.negative))
    return a;
  if (a.negative)
    return invalid(fpscr);
  /* bit by bit, of a number with an even exponent and its highest bit at 124 or 125 */
  wide rest = (wide)a.significand << (a.exponent & 1 ? TOP + 1 : TOP), root = 0;
  int32_t exponent = a.exponent - (a.exponent & 1 ? TOP + 1 : TOP);
  for (wide bit = (wide)1 << 126; bit; bit >>= 2) {
    if (rest >= root + bit) {
      rest -= root + bit;
      root = (root >> 1) + bit;
    } else {
      root >>= 1;
    }
  }
  /* two more bits below, so that the sticky one is none of the result */
  return normalized(false, exponent / 2 - 2, root << 2 | (rest != 0));
}

/* FPMulAdd */
struct hil_real hil_fused_multiply_add(struct hil_real addend, struct hil_real a, struct hil_real b, uint32_t *fpscr) {
  struct hil_real result, operands[] = {addend, a, b};
  bool found = take_nan(operands, 3, &result, fpscr);
  if (addend.kind == QUIET_NAN && is_infinity_times_zero(a, b))
    return invalid(fpscr);
  if (found)
    return result;
  bool negative = a.negative != b.negative, infinite = a.kind == INFINITE || b.kind == INFINITE;
  bool none = a.kind == ZERO || b.kind == ZERO;
  if ((infinite && none) || (infinite && addend.kind == INFINITE && addend.negative != negative))
    return invalid(fpscr);
  if (infinite || addend.kind == INFINITE)
    return addend.kind == INFINITE ? addend : infinity(negative);
  if (none)
    return sum(addend, zero(negative), fpscr);
  struct term exact = product(a, b);
  if (addend.kind == ZERO)
    return normalized(exact.negative, exact.exponent, exact.significand);
  return sum_of(term_of(addend), exact, fpscr);
}

/* --- comparison */

/* Less than zero, zero or more: a against b, neither of which is NaN. */
static int ordered(struct hil_real a, struct hil_real b) {
  int sign_a = a.kind == ZERO ? 0 : a.negative ? -1 : 1, sign_b = b.kind == ZERO ? 0 : b.negative ? -1 : 1;
  if (sign_a != sign_b || sign_a == 0)
    return sign_a - sign_b;
  if (a.kind != b.kind)
    return a.kind == INFINITE ? sign_a : -sign_a;
  if (a.exponent != b.exponent)
    return a.exponent > b.exponent ? sign_a : -sign_a;
  return a.significand == b.significand ? 0 : a.significand > b.significand ? sign_a : -sign_a;
}

/* FPCompare: NZCV in bits 3 to 0. */
uint32_t hil_compare(struct hil_real a, struct hil_real b, bool any_nan_is_invalid,
                     uint32_t *fpscr) {
  if (is_nan(a) || is_nan(b)) {
    if (any_nan_is_invalid || a.kind == SIGNALLING_NAN || b.kind == SIGNALLING_NAN)
      *fpscr |= FPSCR_IOC;
    return 3;
  }
  int order = ordered(a, b);
  return order == 0 ? 6 : order < 0 ? 8 : 2;
}

/* FPMinNum and FPMaxNum: one quiet NaN counts as less than every number. */
struct hil_real hil_extreme_number(struct hil_real a, struct hil_real b, bool least,
                                   uint32_t *fpscr) {
  struct hil_real result;
  if (a.kind == QUIET_NAN && b.kind != QUIET_NAN)
    a = infinity(!least);
  else if (b.kind == QUIET_NAN && a.kind != QUIET_NAN)
    b = infinity(!least);
  struct hil_real operands[] = {a, b};
  if (take_nan(operands, 2, &result, fpscr))
    return result;
  if (a.kind == ZERO && b.kind == ZERO)
    return zero(least ? a.negative || b.negative : a.negative && b.negative);
  return (ordered(a, b) < 0) == least ? a : b;
}

/* --- integers */

/* The magnitude of a number as an integer, rounded; `inexact` if it was none. Numbers of over 2^62 are not for this. */
static uint64_t integral(struct hil_real a, enum hil_rounding rounding, bool *inexact) {
  int32_t below = -a.exponent;
  if (below <= 0)
    return a.significand << -below;
  if (below > TOP + 1) {
    *inexact = true;
    return rounds_up(rounding, a.negative, false, 1, 4);
  }
  uint64_t unit = (uint64_t)1 << below, rest = a.significand & (unit - 1), kept = a.significand >> below;
  *inexact = rest != 0;
  return kept + rounds_up(rounding, a.negative, kept & 1, rest, unit);
}

/* FPRoundInt */
struct hil_real hil_to_integral(struct hil_real a, enum hil_rounding rounding, bool tells_inexact,
                                uint32_t *fpscr) {
  bool inexact = false;
  if (is_nan(a))
    return hil_nan_converted(a, fpscr);
  if (a.kind != FINITE || a.exponent >= 0)
    return a;
  uint64_t magnitude = integral(a, rounding, &inexact);
  if (inexact && tells_inexact)
    *fpscr |= FPSCR_IXC;
  return normalized(a.negative, 0, magnitude);
}

static uint32_t least_or_most(bool negative, uint32_t bits, bool is_unsigned) {
  if (is_unsigned)
    return negative ? 0 : bits == 32 ? UINT32_MAX : (1u << bits) - 1;
  return negative ? 0 - (1u << (bits - 1)) : (1u << (bits - 1)) - 1;
}

/* FPToFixed: an integer of so many bits, with so many of them behind the point; one of 16 is extended to 32. */
uint32_t hil_to_fixed(struct hil_real a, uint32_t bits, uint32_t fraction, bool is_unsigned,
                      enum hil_rounding rounding, uint32_t *fpscr) {
  if (is_nan(a)) {
    *fpscr |= FPSCR_IOC;
    return 0;
  }
  if (a.kind == ZERO)
    return 0;
  a.exponent += (int32_t)fraction;
  if (a.kind == INFINITE || a.exponent >= 0) {
    *fpscr |= FPSCR_IOC;
    return least_or_most(a.negative, bits, is_unsigned);
  }
  bool inexact = false;
  uint64_t magnitude = integral(a, rounding, &inexact);
  uint64_t most = is_unsigned ? ((uint64_t)1 << bits) - 1 : ((uint64_t)1 << (bits - 1)) - 1 + a.negative;
  if (is_unsigned && a.negative)
    most = 0;
  if (magnitude > most) {
    *fpscr |= FPSCR_IOC;
    return least_or_most(a.negative, bits, is_unsigned);
  }
  if (inexact)
    *fpscr |= FPSCR_IXC;
  return a.negative ? 0 - (uint32_t)magnitude : (uint32_t)magnitude;
}

/* FixedToFP, exact */
struct hil_real hil_from_fixed(int64_t value, uint32_t fraction) {
  return normalized(value < 0, -(int32_t)fraction, (wide)(value < 0 ? -(uint64_t)value : (uint64_t)value));
}
