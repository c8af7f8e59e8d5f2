/* The DSP extension: arithmetic on parts of words, saturation, products of halves (DDI0403 chapter A7). */
#include "operations.h"

enum { Q = 1u << 27, GE_AT = 16 };

static int32_t low(uint32_t word) { return (int16_t)word; }
static int32_t high(uint32_t word) { return (int16_t)(word >> 16); }
static int32_t half(uint32_t word, bool upper) { return upper ? high(word) : low(word); }

/* SatQ: signed to -2^(bits-1)..., unsigned to 0... (section A2.2.1). */
uint32_t hil_saturate(int64_t value, uint32_t bits, bool is_signed, bool *saturated) {
  int64_t most = is_signed ? ((int64_t)1 << (bits - 1)) - 1 : ((int64_t)1 << bits) - 1;
  int64_t least = is_signed ? -most - 1 : 0;
  if (value > most || value < least)
    *saturated = true;
  return (uint32_t)(value > most ? most : value < least ? least : value);
}

/* --- parallel addition and subtraction */

enum { ADD8, ADD16, ASX, SUB8 = 4, SUB16, SAX };
enum { PLAIN, SATURATING, HALVING, UNSIGNED = 4 };

struct lanes {
  uint32_t how, bits;
  uint32_t result, ge;
};

static int32_t part(uint32_t word, uint32_t bits, uint32_t lane, bool is_unsigned) {
  uint32_t value = word >> bits * lane;
  if (bits == 8)
    return is_unsigned ? (uint8_t)value : (int8_t)value;
  return is_unsigned ? (uint16_t)value : (int16_t)value;
}

static void put_lane(struct lanes *lanes, uint32_t lane, int32_t value, bool subtracts) {
  bool is_unsigned = lanes->how & UNSIGNED, ignored = false;
  bool ge = is_unsigned && !subtracts ? value >> lanes->bits : value >= 0;
  uint32_t kind = lanes->how & 3, mask = (1u << lanes->bits) - 1;
  uint32_t stored = (uint32_t)value;
  if (kind == SATURATING)
    stored = hil_saturate(value, lanes->bits, !is_unsigned, &ignored);
  else if (kind == HALVING)
    stored = (uint32_t)(value >> 1);
  lanes->result |= (stored & mask) << lanes->bits * lane;
  if (ge)
    lanes->ge |= (lanes->bits == 8 ? 1u : 3u) << (lanes->bits == 8 ? lane : 2 * lane);
}

static uint32_t parallel(uint32_t operation, uint32_t how, uint32_t n, uint32_t m, uint32_t *xpsr) {
  struct lanes lanes = {.how = how, .bits = operation == ADD8 || operation == SUB8 ? 8 : 16};
  bool crossed = operation == ASX || operation == SAX;
  for (uint32_t lane = 0; lane < 32 / lanes.bits; lane++) {
    bool subtracts = operation == SUB8 || operation == SUB16 || (operation == ASX && lane == 0) ||
                     (operation == SAX && lane == 1);
    int32_t first = part(n, lanes.bits, lane, how & UNSIGNED);
    int32_t second = part(m, lanes.bits, crossed ? 1 - lane : lane, how & UNSIGNED);
    put_lane(&lanes, lane, subtracts ? first - second : first + second, subtracts);
  }
  if ((how & 3) == PLAIN)
    *xpsr = (*xpsr & ~(0xFu << GE_AT)) | lanes.ge << GE_AT;
  return lanes.result;
}

/* --- others */

static uint32_t extended(uint32_t kind, uint32_t n, uint32_t m) {
  switch (kind) {
  case 0: return n + (uint32_t)(int16_t)m;
  case 1: return n + (uint16_t)m;
  case 2:
    return ((n + (uint32_t)(int8_t)m) & 0xFFFF) | ((n >> 16) + (uint32_t)(int8_t)(m >> 16)) << 16;
  case 3:
    return ((n + (uint8_t)m) & 0xFFFF) | ((n >> 16) + (uint8_t)(m >> 16)) << 16;
  case 4: return n + (uint32_t)(int8_t)m;
  default: return n + (uint8_t)m;
  }
}

/* QADD, QDADD, QSUB, QDSUB */
static uint32_t saturated_sum(uint32_t kind, uint32_t n, uint32_t m, bool *q) {
  int64_t first = (int32_t)m, second = (int32_t)n;
  if (kind & 1)
    second = (int32_t)hil_saturate(2 * second, 32, true, q);
  return hil_saturate(kind & 2 ? first - second : first + second, 32, true, q);
}

static uint32_t saturated_halves(uint32_t n, uint32_t bits, bool is_signed, bool *q) {
  uint32_t lower = hil_saturate(low(n), bits, is_signed, q), upper = hil_saturate(high(n), bits, is_signed, q);
  return (lower & 0xFFFF) | upper << 16;
}

/* SEL: each byte of the first operand whose GE flag is set, of the second otherwise. */
static uint32_t selected(uint32_t n, uint32_t m, uint32_t ge) {
  uint32_t mask = 0;
  for (uint32_t lane = 0; lane < 4; lane++)
    mask |= ge >> lane & 1 ? 0xFFu << 8 * lane : 0;
  return (n & mask) | (m & ~mask);
}

/* The result of OP_DSP; sets Q and GE in `xpsr`. */
uint32_t hil_dsp(uint32_t operation, const struct hil_op *op, const uint32_t *reg, uint32_t *xpsr) {
  uint32_t n = op->b == R_PC ? 0 : reg[op->b], m = reg[op->c], result;
  bool q = false;
  if (operation < DSP_EXTENDED)
    return parallel(operation >> 3, operation & 7, n, m, xpsr);
  if (operation < DSP_SATURATED)
    return extended(operation - DSP_EXTENDED, n, hil_rotated(m, op->imm));
  if (operation == DSP_SEL)
    return selected(n, m, *xpsr >> GE_AT);
  if (operation < DSP_SEL)
    result = saturated_sum(operation - DSP_SATURATED, n, m, &q);
  else
    result = saturated_halves(n, op->imm, operation == DSP_SSAT16, &q);
  if (q)
    *xpsr |= Q;
  return result;
}

/* --- products */

static uint32_t sum_of_differences(uint32_t n, uint32_t m) {
  uint32_t sum = 0;
  for (uint32_t lane = 0; lane < 4; lane++) {
    int32_t difference = part(n, 8, lane, true) - part(m, 8, lane, true);
    sum += (uint32_t)(difference < 0 ? -difference : difference);
  }
  return sum;
}

static int64_t dual_product(uint32_t n, uint32_t m, bool exchanged, bool subtracts) {
  if (exchanged)
    m = hil_rotated(m, 16);
  int64_t first = (int64_t)low(n) * low(m), second = (int64_t)high(n) * high(m);
  return subtracts ? first - second : first + second;
}

/* SMLAxy, SMLAD, SMLAWy, SMLSD, SMMLA, SMMLS, USADA8 and those without an addend; sets Q in `xpsr`. */
uint32_t hil_multiply_add(const struct hil_op *op, const uint32_t *reg, uint32_t *xpsr) {
  uint32_t n = reg[op->b], m = reg[op->c], kind = op->e >> 2, which = op->e & 3;
  int64_t addend = op->d == R_PC ? 0 : (int32_t)reg[op->d], sum;
  switch (kind) {
  case 1: sum = (int64_t)half(n, which >> 1) * half(m, which & 1) + addend; break;
  case 2: sum = dual_product(n, m, which, false) + addend; break;
  case 3: sum = ((int64_t)(int32_t)n * half(m, which) >> 16) + addend; break;
  case 4: sum = dual_product(n, m, which, true) + addend; break;
  case 5:
  case 6: {
    uint64_t product = (uint64_t)((int64_t)(int32_t)n * (int32_t)m), whole = (uint64_t)addend << 32;
    whole = kind == 5 ? whole + product : whole - product;
    return (uint32_t)((whole + (which ? 0x80000000 : 0)) >> 32);
  }
  default: return (uint32_t)addend + sum_of_differences(n, m);
  }
  if (sum != (int32_t)sum)
    *xpsr |= Q;
  return (uint32_t)sum;
}

/* SMLALxy, SMLALD, SMLSLD. */
uint64_t hil_multiply_add_long(uint32_t operation, uint32_t n, uint32_t m, uint64_t sum) {
  if (operation < 4)
    return sum + (uint64_t)((int64_t)half(n, operation >> 1) * half(m, operation & 1));
  return sum + (uint64_t)dual_product(n, m, operation & 1, operation & 8);
}
