/* Floating-point numbers by integers alone, as the manual computes them (DDI0403 section A2.5): exact, then rounded.
 *
 * A number is taken apart (`hil_unpack`), computed with in 62 bits and a sticky one, and rounded into a format. */
#ifndef HIL_REAL_H
#define HIL_REAL_H

#include <stdbool.h>
#include <stdint.h>

/* Bits of FPSCR (section B1.4.7; cumulative flags as they stand there). */
enum {
  FPSCR_IOC = 1 << 0, FPSCR_DZC = 1 << 1, FPSCR_OFC = 1 << 2, FPSCR_UFC = 1 << 3, FPSCR_IXC = 1 << 4,
  FPSCR_IDC = 1 << 7, FPSCR_FZ = 1 << 24, FPSCR_DN = 1 << 25, FPSCR_AHP = 1 << 26,
};

/* The first four as FPSCR.RMode has them. */
enum hil_rounding { TO_NEAREST, TO_PLUS_INFINITY, TO_MINUS_INFINITY, TO_ZERO, TO_NEAREST_AWAY };

enum hil_format { HALF, SINGLE, DOUBLE };

enum hil_kind { ZERO, FINITE, INFINITE, QUIET_NAN, SIGNALLING_NAN };

/* The magnitude is `significand` * 2^`exponent`; bit 62 of the significand of a finite number is its highest, bit 0 is
 * set if anything below it was. The significand of a NaN is its payload, from bit 62 down. */
struct hil_real {
  enum hil_kind kind;
  bool negative;
  int32_t exponent;
  uint64_t significand;
};

/* `fpscr` below is what arithmetic depends on, and where its flags go. */
enum hil_rounding hil_rounding_of(const uint32_t *fpscr);
struct hil_real hil_unpack(uint64_t bits, enum hil_format format, uint32_t *fpscr);
uint64_t hil_round(struct hil_real value, enum hil_format format, enum hil_rounding rounding,
                   uint32_t *fpscr);

struct hil_real hil_negated(struct hil_real value);
struct hil_real hil_add(struct hil_real a, struct hil_real b,
                        uint32_t *fpscr);
struct hil_real hil_multiply(struct hil_real a, struct hil_real b,
                             uint32_t *fpscr);
struct hil_real hil_divide(struct hil_real a, struct hil_real b,
                           uint32_t *fpscr);
struct hil_real hil_square_root(struct hil_real a, uint32_t *fpscr);
struct hil_real hil_fused_multiply_add(struct hil_real addend, struct hil_real a, struct hil_real b, uint32_t *fpscr);
struct hil_real hil_extreme_number(struct hil_real a, struct hil_real b, bool least,
                                   uint32_t *fpscr);
uint32_t hil_compare(struct hil_real a, struct hil_real b, bool any_nan_is_invalid, uint32_t *fpscr);
struct hil_real hil_nan_converted(struct hil_real nan, uint32_t *fpscr);
struct hil_real hil_to_integral(struct hil_real a, enum hil_rounding rounding, bool tells_inexact,
                                uint32_t *fpscr);
uint32_t hil_to_fixed(struct hil_real a, uint32_t bits, uint32_t fraction, bool is_unsigned,
                      enum hil_rounding rounding, uint32_t *fpscr);
struct hil_real hil_from_fixed(int64_t value, uint32_t fraction);

#endif
