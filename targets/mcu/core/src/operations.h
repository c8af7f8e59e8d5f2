/* What a decoded instruction may ask for: the operations of isa.h, and those of DSP and floating point in them. */
#ifndef HIL_OPERATIONS_H
#define HIL_OPERATIONS_H

#include "cpu.h"
#include "isa.h"

enum {
#define X(operation) OP_##operation,
  OPERATIONS(X)
#undef X
  OPERATION_COUNT,
};

/* `e` of OP_DSP. Those of parallel addition and subtraction are below 64: what they do and how, as encoded. */
enum { DSP_EXTENDED = 64, DSP_SATURATED = 72, DSP_SEL = 80, DSP_SSAT16, DSP_USAT16 };

/* `e` of OP_FLOAT. */
enum hil_float_kind {
  FLOAT_MLA, FLOAT_MLS, FLOAT_NMLA, FLOAT_NMLS, FLOAT_MUL, FLOAT_NMUL, FLOAT_ADD, FLOAT_SUB, FLOAT_DIV,
  FLOAT_FMA, FLOAT_FMS, FLOAT_FNMA, FLOAT_FNMS, FLOAT_CONSTANT, FLOAT_MOV, FLOAT_ABS, FLOAT_NEG, FLOAT_SQRT,
  FLOAT_FROM_HALF, FLOAT_TO_HALF, FLOAT_CMP, FLOAT_CMP_ZERO, FLOAT_RINT_R, FLOAT_RINT_Z, FLOAT_RINT_X,
  FLOAT_PRECISION, FLOAT_FROM_INT, FLOAT_FROM_FIXED, FLOAT_TO_INT, FLOAT_TO_FIXED, FLOAT_SEL, FLOAT_MAXNM,
  FLOAT_MINNM, FLOAT_RINT_TO, FLOAT_TO_INT_BY,
};

/* dsp.c */
uint32_t hil_dsp(uint32_t operation, const struct hil_op *op, const uint32_t *reg, uint32_t *xpsr);
uint32_t hil_multiply_add(const struct hil_op *op, const uint32_t *reg, uint32_t *xpsr);
uint64_t hil_multiply_add_long(uint32_t operation, uint32_t n, uint32_t m, uint64_t sum);
uint32_t hil_saturate(int64_t value, uint32_t bits, bool is_signed, bool *saturated);

/* vfp.c */
void hil_float(struct hil_cpu *cpu, const struct hil_op *op);

#endif
