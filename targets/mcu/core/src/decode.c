/* Turns encodings into decoded instructions, by the rows of isa.h.
 *
 * What the manual calls UNPREDICTABLE is UNDEFINED here wherever PC is an operand that it may not be, a list of
 * registers is empty, a field has no width, or IT is in an IT block. Elsewhere it is what the pseudocode does. */
#include "operations.h"

#include <stdlib.h>
#include <string.h>

enum { BASE, DSP, FP };

enum form {
  F_PLAIN, F_NARROW, F_NARROW_TO_SELF, F_SHIFT_NARROW, F_HIGH, F_LITERAL_NARROW, F_WORDS, F_HALVES, F_WORDS_AT_SP,
  F_ADR_NARROW, F_SP_PLUS, F_COMPARE_BRANCH, F_PUSH, F_POP, F_MULTIPLE_NARROW, F_BRANCH_8, F_BRANCH_11,
  F_MULTIPLE_UP, F_MULTIPLE_DOWN, F_EXCLUSIVE_WORD, F_EXCLUSIVE_BYTE, F_EXCLUSIVE_HALF, F_TABLE, F_PAIR, F_SHIFTED,
  F_PACK, F_CONSTANT, F_ADR_UP, F_ADR_DOWN, F_WIDE, F_CONSTANT_16, F_DSP_SSAT16, F_DSP_USAT16, F_SATURATE, F_FIELD,
  F_FIELD_TO, F_SPECIAL, F_BRANCH_20, F_BRANCH_24, F_LITERAL, F_ADDRESS_12, F_ADDRESS_INDEX, F_ADDRESS_8, F_ROTATED,
  F_DSP_EXTEND, F_DSP_PARALLEL, F_DSP_SATURATE, F_DSP_SELECT, F_DSP_PRODUCT, F_LONG, F_DSP_LONG,
  F_DSP_LONG_DIFFERENCE, F_FLOAT_CORE_PAIR, F_FLOAT_ADDRESS, F_FLOAT_MULTIPLE, F_FLOAT_CORE, F_FLOAT_CORE_HALF,
  F_FLOAT_DATA,
};

struct description {
  const char *pattern;
  uint8_t form, where;
  uint16_t code;
  uint8_t kind;               /* of FLOAT */
  uint8_t m3, m7, m7_double;
};

static const struct description DESCRIPTIONS[] = {
#define ROW(pattern, form, operation, where, m3, m7) {pattern, F_##form, where, OP_##operation, 0, m3, m7, m7},
#define FLOAT_ROW(pattern, kind, single, twice) {pattern, F_FLOAT_DATA, FP, OP_FLOAT, FLOAT_##kind, 1, single, twice},
    ENCODINGS
#undef ROW
#undef FLOAT_ROW
};

enum { ROWS = sizeof DESCRIPTIONS / sizeof *DESCRIPTIONS, LETTERS = 26 };

/* A pattern: the bits that stand for themselves, and those of the fields. */
struct row {
  uint32_t mask, value;
  bool wide;
  uint8_t length;             /* of `letters`: the bits from the highest down, 0 for none */
  char letters[32];
};

struct hil_decoder {
  bool is_m7;
  struct row rows[ROWS];
  uint16_t start[257];        /* by the upper byte of the first half: its rows in `candidates` */
  uint16_t candidates[256 * 24];
};

bool hil_is_wide(uint32_t first) { return first >> 11 >= 0x1D; }

static void read_pattern(const char *pattern, struct row *row) {
  uint32_t bits = 0;
  for (const char *at = pattern; *at; at++) {
    if (*at == ' ')
      continue;
    row->mask = row->mask << 1 | (*at == '0' || *at == '1');
    row->value = row->value << 1 | (*at == '1');
    row->letters[bits++] = *at >= 'a' && *at <= 'z' ? *at : 0;
  }
  row->length = (uint8_t)bits;
  row->wide = bits == 32;
}

/* Returns false if the core does not have what the row describes. */
static bool is_there(const struct description *row, bool has_dsp, bool has_float) {
  return row->where == BASE || (row->where == DSP && has_dsp) || (row->where == FP && has_float);
}

struct hil_decoder *hil_decoder_new(bool has_dsp, bool has_float, bool is_m7) {
  struct hil_decoder *decoder = calloc(1, sizeof *decoder);
  if (!decoder)
    return NULL;
  decoder->is_m7 = is_m7;
  for (uint32_t n = 0; n < ROWS; n++)
    read_pattern(DESCRIPTIONS[n].pattern, &decoder->rows[n]);
  uint16_t count = 0;
  for (uint32_t top = 0; top < 256; top++) {
    decoder->start[top] = count;
    for (uint16_t n = 0; n < ROWS; n++) {
      const struct row *row = &decoder->rows[n];
      uint32_t shift = row->length - 8u;
      if (is_there(&DESCRIPTIONS[n], has_dsp, has_float) && row->wide == hil_is_wide(top << 8) &&
          !((top ^ row->value >> shift) & row->mask >> shift))
        decoder->candidates[count++] = n;
    }
  }
  decoder->start[256] = count;
  return decoder;
}

void hil_decoder_free(struct hil_decoder *decoder) { free(decoder); }

static int find_row(const struct hil_decoder *decoder, uint32_t code, uint32_t top) {
  for (uint32_t at = decoder->start[top]; at < decoder->start[top + 1]; at++) {
    const struct row *row = &decoder->rows[decoder->candidates[at]];
    if ((code & row->mask) == row->value)
      return decoder->candidates[at];
  }
  return -1;
}

/* --- fields to operands */

struct fields {
  uint32_t of[LETTERS];
};

#define FIELD(letter) (fields->of[letter - 'a'])

static uint32_t sign_extended(uint32_t value, uint32_t bits) {
  uint32_t sign = 1u << (bits - 1);
  return (value ^ sign) - sign;
}

static uint32_t counted(uint32_t list) { return (uint32_t)__builtin_popcount(list); }

static void undefined(struct hil_op *op) { op->code = OP_UNDEFINED; }

static bool has_pc(const struct hil_op *op) { return op->a == R_PC || op->b == R_PC || op->c == R_PC; }

/* ThumbExpandImm_C (section A5.3.2): `d` is 2 or 3 for a carry that is known, 0 for one that stays. */
static void expand_constant(struct hil_op *op, uint32_t constant) {
  uint32_t byte = constant & 0xFF, rotation = constant >> 7;
  op->d = 0;
  if (rotation >= 8) {
    op->imm = hil_rotated(0x80 | (constant & 0x7F), rotation);
    op->d = (uint8_t)(2 | op->imm >> 31);
    return;
  }
  static const uint32_t REPEATED[] = {1, 0x00010001, 0x01000100, 0x01010101};
  op->imm = byte * REPEATED[constant >> 8 & 3];
}

/* DecodeImmShift (section A7.4.2): type 4 is RRX. The operation changes to the form with or without a shift. */
static void shift_by(struct hil_op *op, uint32_t type, uint32_t amount, bool flags_alone) {
  if (type == 0 && amount == 0)
    return;
  bool simple_move = (op->code == OP_MOV_REG || op->code == OP_MOV_REG_NF) && type < 3;
  if (amount == 0)
    type == 3 ? (void)(type = 4) : (void)(amount = 32);
  op->d = (uint8_t)type;
  op->imm = amount;
  if (simple_move) {
    uint16_t without = op->code == OP_MOV_REG_NF;
    op->code = (uint16_t)(OP_LSL_IMM + 2 * type + without);
  } else {
    op->code = (uint16_t)(op->code + (flags_alone ? 1 : 2));
  }
}

static uint32_t from_pc(uint32_t address, uint32_t offset, bool up) {
  uint32_t pc = (address + 4) & ~3u;
  return up ? pc + offset : pc - offset;
}

static void several(struct hil_op *op, uint32_t list, uint32_t base, bool down, bool writes_back) {
  op->imm = list;
  op->b = (uint8_t)base;
  op->c = (uint8_t)counted(list);
  op->d = down;
  op->flags = writes_back ? OP_WRITES_BACK : 0;
  if (!list || base == R_PC)
    undefined(op);
}

static void address_8(struct hil_op *op, const struct fields *fields) {
  bool before = FIELD('p'), up = FIELD('u'), back = FIELD('w');
  if (!before && !back) {
    undefined(op);
    return;
  }
  op->imm = up ? FIELD('i') : 0 - FIELD('i');
  if (back) {
    op->code = (uint16_t)(op->code + (before ? 2 : 3));
    op->flags = OP_WRITES_BACK;
  }
}

/* LDR to PC is a branch; its way of addressing goes to `d`. Nothing else may load or store PC. */
static void one_register(struct hil_op *op, uint32_t n, uint32_t t) {
  if (op->code == OP_UNDEFINED)
    return;
  if (t == R_PC && op->code >= OP_LDR_OFFSET && op->code <= OP_LDR_AFTER) {
    op->d = (uint8_t)(op->code - OP_LDR_OFFSET);
    op->code = OP_LDR_PC;
  } else if (t == R_PC) {
    undefined(op);
  }
  if (n == R_PC || op->c == R_PC)
    undefined(op);
}

/* Offsets of branches (sections A7.7.12, A7.7.18): I1 and I2 are NOT(J EOR S). */
static uint32_t far_offset(const struct fields *fields) {
  uint32_t sign = FIELD('g'), j = FIELD('j');
  uint32_t i1 = !(j >> 1 ^ sign), i2 = !((j & 1) ^ sign);
  return sign_extended((sign << 23 | i1 << 22 | i2 << 21 | FIELD('i')) << 1, 25);
}

static void pair(struct hil_op *op, const struct fields *fields, uint32_t address) {
  bool before = FIELD('p'), up = FIELD('u'), back = FIELD('w');
  uint32_t offset = 4 * FIELD('i');
  op->e = before;
  op->flags = back ? OP_WRITES_BACK : 0;
  op->imm = up ? offset : 0 - offset;
  if (op->code == OP_LDRD_LITERAL)
    op->imm = from_pc(address, offset, up);
  if ((!before && !back) || FIELD('t') == R_PC || FIELD('a') == R_PC || (op->code != OP_LDRD_LITERAL && op->b == R_PC))
    undefined(op);
}

/* Numbers of floating-point registers, in words: D:dddd for a double, dddd:D for a single. 0xFF: there is none. */
static uint8_t float_register(uint32_t number, bool twice) {
  if (!twice)
    return (uint8_t)((number & 15) << 1 | number >> 4);
  return number < 16 ? (uint8_t)(2 * number) : 0xFF;
}

static void float_data(struct hil_op *op, const struct fields *fields, uint32_t kind) {
  bool twice = FIELD('z'), to = twice, from = twice;
  if (kind == FLOAT_TO_INT || kind == FLOAT_TO_INT_BY || kind == FLOAT_TO_HALF)
    to = false;
  else if (kind == FLOAT_FROM_INT || kind == FLOAT_FROM_HALF)
    from = false;
  else if (kind == FLOAT_PRECISION)
    to = !twice;
  uint32_t n = FIELD('n');
  op->e = (uint8_t)kind;
  op->d = twice;
  op->a = float_register(FIELD('d'), to);
  op->b = float_register((n & 1) << 4 | n >> 1, from);
  op->c = float_register(FIELD('m'), from);
  op->imm = FIELD('i');
  if (op->a == 0xFF || op->b == 0xFF || op->c == 0xFF)
    undefined(op);
}

static void float_several(struct hil_op *op, const struct fields *fields) {
  bool before = FIELD('p'), up = FIELD('u'), back = FIELD('w'), twice = FIELD('z');
  uint32_t words = FIELD('i');
  op->a = float_register(FIELD('d'), twice);
  op->e = twice;
  op->imm = words;
  op->d = before;
  op->flags = back ? OP_WRITES_BACK : 0;
  if (op->a == 0xFF || !words || op->a + words > 32u + twice || before == up || (before && !back) || op->b == R_PC)
    undefined(op);
}

/* Fields to operands; the generic ones are there already. */
static void apply_form(struct hil_op *op, const struct description *row, const struct fields *fields,
                       uint32_t address) {
  bool twice = FIELD('z');
  uint32_t i = FIELD('i');
  switch ((enum form)row->form) {
  case F_PLAIN:
    break;
  case F_NARROW:
    op->flags = OP_NARROW;
    break;
  case F_NARROW_TO_SELF:
    op->flags = OP_NARROW;
    op->b = op->a;
    break;
  case F_SHIFT_NARROW:
    op->flags = OP_NARROW;
    if (op->code == OP_LSL_IMM && i == 0)
      op->code = OP_MOV_REG;
    else if (i == 0)
      op->imm = 32;
    break;
  case F_HIGH:
    break;
  case F_LITERAL_NARROW:
    op->imm = from_pc(address, 4 * i, true);
    break;
  case F_WORDS:
    op->imm = 4 * i;
    break;
  case F_HALVES:
    op->imm = 2 * i;
    break;
  case F_WORDS_AT_SP:
    op->b = R_SP;
    op->imm = 4 * i;
    break;
  case F_ADR_NARROW:
    op->imm = from_pc(address, 4 * i, true);
    break;
  case F_SP_PLUS:
    op->a = op->b = R_SP;
    op->imm = 4 * i;
    break;
  case F_COMPARE_BRANCH:
    op->imm = address + 4 + 2 * i;
    break;
  case F_PUSH:
    several(op, (FIELD('r') & 0xFF) | FIELD('r') >> 8 << R_LR, R_SP, true, true);
    break;
  case F_POP:
    several(op, (FIELD('r') & 0xFF) | FIELD('r') >> 8 << R_PC, R_SP, false, true);
    break;
  case F_MULTIPLE_NARROW:
    several(op, FIELD('r'), FIELD('n'), false, op->code == OP_STM || !(FIELD('r') >> FIELD('n') & 1));
    break;
  case F_MULTIPLE_UP:
  case F_MULTIPLE_DOWN:
    several(op, (FIELD('r') & 0x1FFF) | FIELD('r') >> 13 << 14, FIELD('n'), row->form == F_MULTIPLE_DOWN, FIELD('w'));
    break;
  case F_BRANCH_8:
    op->code = (uint16_t)(OP_BEQ + FIELD('c'));
    op->imm = address + 4 + sign_extended(2 * i, 9);
    break;
  case F_BRANCH_11:
    op->imm = address + 4 + sign_extended(2 * i, 12);
    break;
  case F_BRANCH_20: {
    uint32_t j = FIELD('j');
    op->code = (uint16_t)(OP_BEQ + FIELD('c'));
    op->imm = address + 4 + sign_extended((FIELD('g') << 19 | (j & 1) << 18 | j >> 1 << 17 | i) << 1, 21);
    if (FIELD('c') >= 14)
      undefined(op);
    break;
  }
  case F_BRANCH_24:
    op->imm = address + 4 + far_offset(fields);
    break;
  case F_EXCLUSIVE_WORD:
    op->imm = 4 * i;
    op->e = 4;
    goto exclusive;
  case F_EXCLUSIVE_BYTE:
    op->e = 1;
    goto exclusive;
  case F_EXCLUSIVE_HALF:
    op->e = 2;
  exclusive:
    if (op->b == R_PC || FIELD('t') == R_PC || FIELD('a') == R_PC)
      undefined(op);
    break;
  case F_TABLE:
    if (op->c == R_PC)
      undefined(op);
    break;
  case F_PAIR:
    pair(op, fields, address);
    break;
  case F_SHIFTED: {
    bool flags_alone = op->code >= OP_TST_REG && op->code <= OP_CMN_IMM;
    if (!flags_alone && !FIELD('s'))
      op->code++;
    shift_by(op, FIELD('y'), i, flags_alone);
    if ((!flags_alone && op->a == R_PC) || op->b == R_PC || op->c == R_PC)
      undefined(op);
    break;
  }
  case F_PACK:
    op->d = (uint8_t)FIELD('y');
    op->imm = op->d && !i ? 32 : i;
    if (has_pc(op))
      undefined(op);
    break;
  case F_CONSTANT: {
    bool flags_alone = op->code >= OP_TST_REG && op->code <= OP_CMN_IMM;
    if (!flags_alone && !FIELD('s'))
      op->code++;
    expand_constant(op, i);
    if ((!flags_alone && op->a == R_PC) || op->b == R_PC)
      undefined(op);
    break;
  }
  case F_ADR_UP:
  case F_ADR_DOWN:
    op->imm = from_pc(address, i, row->form == F_ADR_UP);
    op->b = 0;
    if (op->a == R_PC)
      undefined(op);
    break;
  case F_WIDE:
    if (op->code >= OP_LSL_BY && op->code <= OP_ROR_BY_NF && !FIELD('s'))
      op->code++;
    if (has_pc(op) || FIELD('a') == R_PC)
      undefined(op);
    break;
  case F_CONSTANT_16:
    op->imm = (i >> 11 & 15) << 12 | i >> 15 << 11 | (i & 0x7FF);
    if (op->a == R_PC)
      undefined(op);
    break;
  case F_DSP_SSAT16:
    op->e = DSP_SSAT16;
    op->imm = i + 1;
    if (has_pc(op))
      undefined(op);
    break;
  case F_DSP_USAT16:
    op->e = DSP_USAT16;
    if (has_pc(op))
      undefined(op);
    break;
  case F_SATURATE:
    op->d = (uint8_t)(FIELD('y') ? 2 : 0);
    op->e = (uint8_t)(FIELD('a') + (op->code == OP_SSAT));
    if ((FIELD('y') && !i) || op->a == R_PC || op->b == R_PC)
      undefined(op);
    break;
  case F_FIELD:
    op->e = (uint8_t)(FIELD('a') + 1);
    if (i + op->e > 32 || op->a == R_PC || op->b == R_PC)
      undefined(op);
    break;
  case F_FIELD_TO:
    op->e = (uint8_t)(FIELD('a') + 1 - i);
    if (FIELD('a') < i || op->a == R_PC)
      undefined(op);
    break;
  case F_SPECIAL:
    op->e = (uint8_t)FIELD('a');
    op->c = (uint8_t)i;
    if (op->code == OP_MSR ? op->b == R_PC : op->a == R_PC)
      undefined(op);
    break;
  case F_LITERAL:
    op->imm = from_pc(address, i, FIELD('u'));
    break;
  case F_ADDRESS_12:
  case F_ADDRESS_INDEX:
    one_register(op, op->b, FIELD('t'));
    break;
  case F_ADDRESS_8:
    address_8(op, fields);
    one_register(op, op->b, FIELD('t'));
    break;
  case F_ROTATED:
    op->imm = 8 * i;
    if (op->a == R_PC || op->c == R_PC)
      undefined(op);
    break;
  case F_DSP_EXTEND:
    op->e = (uint8_t)(DSP_EXTENDED + FIELD('y'));
    op->imm = 8 * i;
    if (FIELD('y') > 5 || op->a == R_PC || op->c == R_PC)
      undefined(op);
    break;
  case F_DSP_PARALLEL:
    op->e = (uint8_t)(FIELD('y') << 3 | FIELD('a'));
    if (FIELD('y') == 3 || FIELD('y') == 7 || (FIELD('a') & 3) == 3 || has_pc(op))
      undefined(op);
    break;
  case F_DSP_SATURATE:
    op->e = (uint8_t)(DSP_SATURATED + FIELD('y'));
    if (has_pc(op))
      undefined(op);
    break;
  case F_DSP_SELECT:
    op->e = DSP_SEL;
    if (has_pc(op))
      undefined(op);
    break;
  case F_DSP_PRODUCT:
    op->e = (uint8_t)(FIELD('y') << 2 | i);
    if (FIELD('y') == 0 || (FIELD('y') > 1 && i > 1) || (FIELD('y') == 7 && i) || has_pc(op))
      undefined(op);
    break;
  case F_LONG:
    if (has_pc(op) || op->d == R_PC)
      undefined(op);
    break;
  case F_DSP_LONG:
    op->e = (uint8_t)i;
    if (i > 5 || has_pc(op) || op->d == R_PC)
      undefined(op);
    break;
  case F_DSP_LONG_DIFFERENCE:
    op->e = (uint8_t)(8 | i);
    if (has_pc(op) || op->d == R_PC)
      undefined(op);
    break;
  case F_FLOAT_CORE_PAIR:
    op->c = float_register(FIELD('m'), twice);
    if (op->c >= 31 || op->a == R_PC || op->d == R_PC)
      undefined(op);
    break;
  case F_FLOAT_ADDRESS:
    op->a = float_register(FIELD('d'), twice);
    op->e = twice;
    op->imm = FIELD('u') ? 4 * i : 0 - 4 * i;
    if (op->code == OP_VLDR_LITERAL)
      op->imm = from_pc(address, 4 * i, FIELD('u'));
    if (op->a == 0xFF || (op->code != OP_VLDR_LITERAL && op->b == R_PC))
      undefined(op);
    break;
  case F_FLOAT_MULTIPLE:
    float_several(op, fields);
    break;
  case F_FLOAT_CORE:
    op->c = (uint8_t)FIELD('n');
    if (op->a == R_PC)
      undefined(op);
    break;
  case F_FLOAT_CORE_HALF:
    op->c = (uint8_t)((FIELD('n') >> 1) * 2 + i);
    if (FIELD('n') & 1 || op->a == R_PC)
      undefined(op);
    break;
  case F_FLOAT_DATA:
    float_data(op, fields, row->kind);
    break;
  }
}

/* Operations of which `d` is a core register that they write. */
static bool writes_d(uint32_t code) {
  return (code >= OP_SMULL && code <= OP_UMLAL) || code == OP_SMLALX || code == OP_UMAAL || code == OP_LDRD ||
         code == OP_LDRD_LITERAL || code == OP_STREX || code == OP_VMOV_PAIR_TO_CORE;
}

/* Operations of which `a` is a core register that they write. */
static bool writes_a(uint32_t code) {
  return (code >= OP_AND_REG && code <= OP_MVN_IMM_NF) || (code >= OP_LSL_IMM && code <= OP_USAT) ||
         (code >= OP_LDR_OFFSET && code <= OP_LDRSB_AFTER) || (code >= OP_LDR_LITERAL && code <= OP_LDRSB_LITERAL) ||
         code == OP_MRS || code == OP_DSP || code == OP_SMLAX || code == OP_LDREX || code == OP_VMOV_TO_CORE ||
         code == OP_VMRS || writes_d(code);
}

/* Bits 1 and 0 of SP are zero whatever is written (section B1.4.1): most writes need a step more. */
static bool may_misalign_sp(const struct hil_op *op) {
  bool keeps = (op->code == OP_ADD_IMM_NF || op->code == OP_SUB_IMM_NF) && op->b == R_SP && !(op->imm & 3);
  bool is_compare = op->code == OP_CMP_HIGH;
  bool single = (op->code >= OP_LDR_OFFSET && op->code <= OP_STRB_AFTER) || op->code == OP_LDR_PC;
  bool back = single && op->flags & OP_WRITES_BACK && op->b == R_SP && op->imm & 3;
  return (writes_a(op->code) && op->a == R_SP && !keeps && !is_compare) || back ||
         (writes_d(op->code) && op->d == R_SP) ||
         (op->code == OP_LDM && (op->imm >> R_SP & 1));
}

static uint32_t cost_of(const struct hil_decoder *decoder, const struct description *row, const struct hil_op *op,
                        uint32_t words) {
  uint32_t cost = !decoder->is_m7 ? row->m3 : op->d && row->form == F_FLOAT_DATA ? row->m7_double : row->m7;
  if (cost == EACH)
    return 1 + words;
  if (cost == PAIRS)
    return words < 2 ? 1 : (words + 1) / 2;
  return cost;
}

static void take_fields(const struct row *row, uint32_t code, struct fields *fields) {
  memset(fields, 0, sizeof *fields);
  for (uint32_t n = 0; n < row->length; n++) {
    char letter = row->letters[n];
    if (letter) {
      uint32_t *field = &fields->of[letter - 'a'];
      *field = *field << 1 | (code >> (row->length - 1u - n) & 1);
    }
  }
}

/* Decode what stands at an address: `raw`, the first half below the second. */
void hil_decode(const struct hil_cpu *cpu, uint32_t address, uint32_t raw, bool in_writable, struct hil_op *op) {
  const struct hil_decoder *decoder = cpu->decoder;
  uint32_t first = raw & 0xFFFF;
  bool wide = hil_is_wide(first);
  uint32_t code = wide ? first << 16 | raw >> 16 : first;
  int found = find_row(decoder, code, first >> 8);
  memset(op, 0, sizeof *op);
  op->raw = wide ? raw : first;
  op->halves = wide ? 2 : 1;
  op->cost = HIL_UNIT - 1;
  op->code = OP_UNDEFINED;
  if (found >= 0) {
    const struct description *row = &DESCRIPTIONS[found];
    struct fields of, *fields = &of;
    take_fields(&decoder->rows[found], code, fields);
    op->code = row->code;
    op->a = (uint8_t)(FIELD('d') | FIELD('t'));
    op->b = (uint8_t)FIELD('n');
    op->c = (uint8_t)FIELD('m');
    op->d = (uint8_t)FIELD('a');
    op->imm = FIELD('i');
    apply_form(op, row, fields, address);
    if (cpu->state.table) {
      uint32_t words = row->form == F_FLOAT_MULTIPLE ? FIELD('i') : counted(FIELD('r'));
      op->cost = cost_of(decoder, row, op, words) * HIL_UNIT - 1;
    }
  }
  op->real = op->code;
  if (may_misalign_sp(op)) {
    op->code = OP_TO_SP;
    op->flags |= OP_ALIGNS_SP;
  }
  if (in_writable)
    op->code = OP_VERIFY;
}
