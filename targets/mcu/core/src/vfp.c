/* Floating-point instructions (DDI0403 chapter A7, section A6.4) by the arithmetic of real.h. */
#include "operations.h"
#include "real.h"

#include <string.h>

struct operands {
  uint32_t *floats, *fpscr;
  enum hil_format format;
};

static uint64_t bits_of(const struct operands *in, uint32_t place, enum hil_format format) {
  uint64_t bits = in->floats[place];
  return format == DOUBLE ? bits | (uint64_t)in->floats[place + 1] << 32 : bits;
}

static struct hil_real read(const struct operands *in, uint32_t place, enum hil_format format) {
  return hil_unpack(bits_of(in, place, format), format, in->fpscr);
}

static void put_bits(const struct operands *out, uint32_t place, enum hil_format format, uint64_t bits) {
  out->floats[place] = (uint32_t)bits;
  if (format == DOUBLE)
    out->floats[place + 1] = (uint32_t)(bits >> 32);
}

static void put(const struct operands *out, uint32_t place, enum hil_format format, struct hil_real value) {
  put_bits(out, place, format, hil_round(value, format, hil_rounding_of(out->fpscr), out->fpscr));
}

/* Put a result that each operation of a chain takes as an operand again. */
static struct hil_real rounded(const struct operands *in, struct hil_real value) {
  uint64_t bits = hil_round(value, in->format, hil_rounding_of(in->fpscr), in->fpscr);
  return hil_unpack(bits, in->format, in->fpscr);
}

static uint64_t sign_bit(enum hil_format format) { return format == DOUBLE ? (uint64_t)1 << 63 : (uint64_t)1 << 31; }

/* VFPExpandImm: a b cdefgh to a NOT(b) bb..b cdefgh 0..0 */
static uint64_t expanded(uint32_t constant, enum hil_format format) {
  uint64_t sign = constant >> 7, b = constant >> 6 & 1, low = constant & 0x3F;
  if (format == SINGLE)
    return sign << 31 | (b ? (uint64_t)0x1F << 25 : (uint64_t)1 << 30) | low << 19;
  return sign << 63 | (b ? (uint64_t)0xFF << 54 : (uint64_t)1 << 62) | low << 48;
}

/* VMLA and its kin: the product is rounded before it is added. */
static struct hil_real chained(const struct operands *in, const struct hil_op *op) {
  bool negative_product = op->e == FLOAT_MLS || op->e == FLOAT_NMLA;
  bool negative_addend = op->e == FLOAT_NMLA || op->e == FLOAT_NMLS;
  struct hil_real n = read(in, op->b, in->format), m = read(in, op->c, in->format);
  struct hil_real product = rounded(in, hil_multiply(n, m, in->fpscr)), addend = read(in, op->a, in->format);
  if (negative_product)
    product = hil_negated(product);
  if (negative_addend)
    addend = hil_negated(addend);
  return hil_add(addend, product, in->fpscr);
}

static struct hil_real fused(const struct operands *in, const struct hil_op *op) {
  struct hil_real addend = read(in, op->a, in->format);
  struct hil_real n = read(in, op->b, in->format), m = read(in, op->c, in->format);
  if (op->e == FLOAT_FNMA || op->e == FLOAT_FNMS)
    addend = hil_negated(addend);
  if (op->e == FLOAT_FNMA || op->e == FLOAT_FMS)
    n = hil_negated(n);
  return hil_fused_multiply_add(addend, n, m, in->fpscr);
}

static void compare(const struct operands *in, const struct hil_op *op) {
  struct hil_real first = read(in, op->a, in->format), second = {ZERO, false, 0, 0};
  if (op->e == FLOAT_CMP)
    second = read(in, op->c, in->format);
  uint32_t flags = hil_compare(first, second, op->imm & 1, in->fpscr);
  *in->fpscr = (*in->fpscr & 0x0FFFFFFF) | flags << 28;
}

/* The half that VCVTB or VCVTT takes or makes. */
static void from_half(const struct operands *in, const struct hil_op *op) {
  struct hil_real value = hil_unpack(in->floats[op->c] >> 16 * (op->imm & 1) & 0xFFFF, HALF, in->fpscr);
  if (value.kind >= QUIET_NAN)
    value = hil_nan_converted(value, in->fpscr);
  put(in, op->a, in->format, value);
}

static uint64_t half_of(const struct operands *in, struct hil_real value) {
  bool alternative = *in->fpscr & FPSCR_AHP;
  if (alternative && value.kind >= INFINITE) {
    *in->fpscr |= FPSCR_IOC;
    return (uint64_t)value.negative << 15 | (value.kind == INFINITE ? 0x7FFF : 0);
  }
  if (value.kind >= QUIET_NAN)
    value = hil_nan_converted(value, in->fpscr);
  return hil_round(value, HALF, hil_rounding_of(in->fpscr), in->fpscr);
}

static void to_half(const struct operands *in, const struct hil_op *op) {
  uint32_t shift = 16 * (op->imm & 1);
  uint64_t half = half_of(in, read(in, op->c, in->format));
  in->floats[op->a] = (in->floats[op->a] & ~(0xFFFFu << shift)) | (uint32_t)half << shift;
}

static void change_precision(const struct operands *in, const struct hil_op *op) {
  struct hil_real value = read(in, op->c, in->format);
  if (value.kind >= QUIET_NAN)
    value = hil_nan_converted(value, in->fpscr);
  put(in, op->a, in->format == DOUBLE ? SINGLE : DOUBLE, value);
}

/* VCVT with a point within the integer; `imm` is U, sx, i and imm4. */
static void fixed_point(const struct operands *in, const struct hil_op *op) {
  bool is_unsigned = op->imm >> 6 & 1;
  uint32_t bits = op->imm & 0x20 ? 32 : 16, constant = (op->imm & 15) << 1 | (op->imm >> 4 & 1);
  uint32_t fraction = bits - constant;
  if (constant > bits)
    return; /* UNPREDICTABLE: nothing happens (a choice) */
  if (op->e == FLOAT_TO_FIXED) {
    struct hil_real value = read(in, op->a, in->format);
    uint32_t result = hil_to_fixed(value, bits, fraction, is_unsigned, TO_ZERO, in->fpscr);
    put_bits(in, op->a, in->format, is_unsigned ? result : (uint64_t)(int64_t)(int32_t)result);
    return;
  }
  uint32_t word = in->floats[op->a];
  int64_t value = bits == 32 ? (is_unsigned ? (int64_t)word : (int32_t)word)
                             : (is_unsigned ? (int64_t)(uint16_t)word : (int16_t)word);
  struct hil_real number = hil_from_fixed(value, fraction);
  put_bits(in, op->a, in->format, hil_round(number, in->format, TO_NEAREST, in->fpscr));
}

static const enum hil_rounding BY_NAME[] = {TO_NEAREST_AWAY, TO_NEAREST, TO_PLUS_INFINITY, TO_MINUS_INFINITY};

static void to_integer(const struct operands *in, const struct hil_op *op) {
  bool by_name = op->e == FLOAT_TO_INT_BY, is_signed = by_name ? op->imm & 1 : op->imm >> 1 & 1;
  enum hil_rounding rounding = by_name ? BY_NAME[op->imm >> 1] : op->imm & 1 ? TO_ZERO : hil_rounding_of(in->fpscr);
  struct hil_real value = read(in, op->c, in->format);
  in->floats[op->a] = hil_to_fixed(value, 32, 0, !is_signed, rounding, in->fpscr);
}

static void from_integer(const struct operands *in, const struct hil_op *op) {
  uint32_t word = in->floats[op->c];
  put(in, op->a, in->format, hil_from_fixed(op->imm & 1 ? (int32_t)word : (int64_t)word, 0));
}

static void to_integral(const struct operands *in, const struct hil_op *op, enum hil_rounding rounding) {
  struct hil_real value = hil_to_integral(read(in, op->c, in->format), rounding, op->e == FLOAT_RINT_X, in->fpscr);
  put(in, op->a, in->format, value);
}

/* Execute an OP_FLOAT, but for FLOAT_SEL, which goes by the flags of the core. */
void hil_float(struct hil_cpu *cpu, const struct hil_op *op) {
  uint32_t *fpscr = &cpu->state.floats[FPSCR];
  const struct operands all = {cpu->state.floats, fpscr, op->d ? DOUBLE : SINGLE}, *in = &all;
  enum hil_format format = all.format;
  switch ((enum hil_float_kind)op->e) {
  case FLOAT_MLA:
  case FLOAT_MLS:
  case FLOAT_NMLA:
  case FLOAT_NMLS:
    put(in, op->a, format, chained(in, op));
    return;
  case FLOAT_FMA:
  case FLOAT_FMS:
  case FLOAT_FNMA:
  case FLOAT_FNMS:
    put(in, op->a, format, fused(in, op));
    return;
  case FLOAT_CONSTANT: put_bits(in, op->a, format, expanded(op->imm, format)); return;
  case FLOAT_MOV: put_bits(in, op->a, format, bits_of(in, op->c, format)); return;
  case FLOAT_ABS: put_bits(in, op->a, format, bits_of(in, op->c, format) & ~sign_bit(format)); return;
  case FLOAT_NEG: put_bits(in, op->a, format, bits_of(in, op->c, format) ^ sign_bit(format)); return;
  case FLOAT_SQRT: put(in, op->a, format, hil_square_root(read(in, op->c, format), fpscr)); return;
  case FLOAT_FROM_HALF: from_half(in, op); return;
  case FLOAT_TO_HALF: to_half(in, op); return;
  case FLOAT_CMP:
  case FLOAT_CMP_ZERO: compare(in, op); return;
  case FLOAT_RINT_R:
  case FLOAT_RINT_X: to_integral(in, op, hil_rounding_of(fpscr)); return;
  case FLOAT_RINT_Z: to_integral(in, op, TO_ZERO); return;
  case FLOAT_RINT_TO: to_integral(in, op, BY_NAME[op->imm & 3]); return;
  case FLOAT_PRECISION: change_precision(in, op); return;
  case FLOAT_FROM_INT: from_integer(in, op); return;
  case FLOAT_FROM_FIXED:
  case FLOAT_TO_FIXED: fixed_point(in, op); return;
  case FLOAT_TO_INT:
  case FLOAT_TO_INT_BY: to_integer(in, op); return;
  case FLOAT_SEL: return;
  case FLOAT_MUL:
  case FLOAT_NMUL:
  case FLOAT_ADD:
  case FLOAT_SUB:
  case FLOAT_DIV:
  case FLOAT_MAXNM:
  case FLOAT_MINNM: break;
  }
  struct hil_real n = read(in, op->b, format), m = read(in, op->c, format), result;
  switch ((enum hil_float_kind)op->e) {
  case FLOAT_MUL: result = hil_multiply(n, m, fpscr); break;
  case FLOAT_NMUL: result = hil_negated(rounded(in, hil_multiply(n, m, fpscr))); break;
  case FLOAT_ADD: result = hil_add(n, m, fpscr); break;
  case FLOAT_SUB: result = hil_add(n, m.kind < QUIET_NAN ? hil_negated(m) : m, fpscr); break;
  case FLOAT_DIV: result = hil_divide(n, m, fpscr); break;
  default: result = hil_extreme_number(n, m, op->e == FLOAT_MINNM, fpscr); break;
  }
  put(in, op->a, format, result);
}
