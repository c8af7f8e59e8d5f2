/* Executes decoded instructions, one after the other (DDI0403 chapters A2, A6 and A7).
 *
 * The loop is threaded: each operation ends by jumping to the next one. What is checked after every instruction is one
 * counter, `left`: in its upper bits the instructions to the limit in the timing model "flat", cycles in "table"; below
 * (see `HIL_UNIT`) how many instructions have retired since time was settled. Whatever else needs a look
 * between two instructions - an IT block, a stack pointer to be aligned - lowers it by `ASIDE` for as long as it lasts.
 *
 * A run ends at an instruction boundary, never within an IT block. An instruction that fails leaves everything as it
 * was before it. */
#include "limits.h"
#include "operations.h"

#include <stdlib.h>
#include <string.h>

#define ASIDE ((int64_t)1 << 60)

enum { N = 1u << 31, Z = 1u << 30, C = 1u << 29, V = 1u << 28, Q = 1u << 27, T = 1u << 24, GE = 0x000F0000 };
enum { IPSR = 0x1FF, FPCA = 4 };
enum { EXC_RETURN = 0xF0000000 };

/* --- time */

/* What is left until the limits: instructions, or in the model "table" cycles, fewer than until either limit. */
static int64_t left_until_limit(const struct hil_state *state) {
  if (hil_is_over(state))
    return 0;
  uint64_t instructions = hil_smaller(state->limit_retired - state->retired, MOST_AT_ONCE);
  if (state->skip && !state->looking)
    instructions = state->look_at <= state->retired ? 1 : hil_smaller(instructions, state->look_at - state->retired);
  if (state->table)
    return (int64_t)hil_smaller(hil_cycles_left(state), instructions);
  if (hil_end_of(state) <= state->base)
    return 0;
  uint64_t reached = hil_reached_after(state, hil_cycles_left(state));
  uint64_t done = state->retired - state->since;
  return reached <= done ? 0 : (int64_t)hil_smaller(reached - done, instructions);
}

/* --- conditions */

static bool holds(uint32_t condition, uint32_t n, uint32_t z, uint32_t c, uint32_t v) {
  bool result;
  switch (condition >> 1) {
  case 0: result = !z; break;
  case 1: result = c; break;
  case 2: result = n >> 31; break;
  case 3: result = v >> 31; break;
  case 4: result = c && z; break;
  case 5: result = !((n ^ v) >> 31); break;
  case 6: result = z && !((n ^ v) >> 31); break;
  default: return true;
  }
  return condition & 1 ? !result : result;
}

static uint32_t it_advanced(uint32_t it) { return it & 7 ? (it & 0xE0) | (it << 1 & 0x1F) : 0; }

/* --- shifts (section A2.2.1), each with the carry out of it */

static uint32_t shifted(uint32_t type, uint32_t value, uint32_t by, uint32_t *carry) {
  if (type == 4) {
    uint32_t result = value >> 1 | *carry << 31;
    *carry = value & 1;
    return result;
  }
  if (by == 0)
    return value;
  switch (type) {
  case 0:
    *carry = by <= 32 ? (uint32_t)((uint64_t)value << by >> 32) & 1 : 0;
    return by < 32 ? value << by : 0;
  case 1:
    *carry = by <= 32 ? value >> (by - 1) & 1 : 0;
    return by < 32 ? value >> by : 0;
  case 2:
    *carry = by <= 32 ? (uint32_t)((int32_t)value >> (by - 1)) & 1 : value >> 31;
    return (uint32_t)((int32_t)value >> (by < 32 ? by : 31));
  default:
    value = hil_rotated(value, by & 31);
    *carry = value >> 31;
    return value;
  }
}

static uint32_t bits_reversed(uint32_t value) {
  value = (value >> 1 & 0x55555555) | (value & 0x55555555) << 1;
  value = (value >> 2 & 0x33333333) | (value & 0x33333333) << 2;
  value = (value >> 4 & 0x0F0F0F0F) | (value & 0x0F0F0F0F) << 4;
  return __builtin_bswap32(value);
}

static uint32_t divided(int32_t n, int32_t m) {
  if (m == 0)
    return 0;
  return m == -1 ? 0 - (uint32_t)n : (uint32_t)(n / m);
}

static uint32_t field_mask(uint32_t width) { return width < 32 ? (1u << width) - 1 : UINT32_MAX; }

/* --- the state between the loop and everybody else */

static bool may_float(const struct hil_state *state) {
  if (state->float_access == 3)
    return true;
  return state->float_access == 1 && hil_is_privileged(state);
}

static bool has_code(struct hil_region *region, int32_t jump_at_end) {
  if (!region->ops) {
    size_t count = region->size / 2;
    region->ops = calloc(count + 2, sizeof *region->ops);
    if (!region->ops)
      return false;
    for (size_t at = count; at < count + 2; at++) {
      region->ops[at].code = OP_END_OF_MEMORY;
      region->ops[at].jump = jump_at_end;
    }
  }
  return true;
}

static uint32_t first_half(struct hil_cpu *cpu, const struct hil_region *code, uint32_t pc) {
  bool ignored;
  return hil_fetch(cpu, code, pc, &ignored) & 0xFFFF;
}

/* Whether an instruction has been decoded and cannot have changed since. */
static bool is_known(const struct hil_region *code, const struct hil_op *op) { return op->jump && !code->writable; }

/* BKPT is executed whatever the condition (section A7.7.17). */
static bool begins_breakpoint(struct hil_cpu *cpu, const struct hil_region *code, const struct hil_op *op,
                              uint32_t pc) {
  return is_known(code, op) ? op->real == OP_BKPT : first_half(cpu, code, pc) >> 8 == 0xBE;
}

static uint32_t length_of(struct hil_cpu *cpu, const struct hil_region *code, const struct hil_op *op, uint32_t pc) {
  if (is_known(code, op))
    return op->halves;
  return hil_is_wide(first_half(cpu, code, pc)) ? 2 : 1;
}

/* Whether an instruction is another than was decoded there. */
static bool is_stale(struct hil_cpu *cpu, const struct hil_region *code, const struct hil_op *op, uint32_t pc) {
  bool complete;
  uint32_t raw = hil_fetch(cpu, code, pc, &complete);
  return (op->halves == 1 ? raw & 0xFFFF : raw) != op->raw || !complete;
}

/* Words that go to or come from memory in one instruction, most of them. */
enum { MOST_WORDS = 32 };

/* Run up to a cycle, or for so many instructions, or until something is for the caller to do; at least one instruction
 * is executed.
 *
 * Returns why it ended; `state` says more. */
HIL_EXPORT uint32_t hil_run(struct hil_cpu *cpu, uint64_t limit_cycle, uint64_t instructions) {
  static const void *const LABELS[] = {
#define X(operation) &&L_##operation,
      OPERATIONS(X)
#undef X
  };
  struct hil_state *const state = &cpu->state;
  uint32_t *const r = state->reg;
  struct hil_region *code = NULL;
  struct hil_op nowhere = {0}, *ops = &nowhere, *op = &nowhere;
  uint32_t code_base = 0, code_size = 0, destination = r[R_PC];
  uint32_t n, z, c, v, rest, it, aligns_sp = 0, value = 0, address;
  uint32_t refill, literal_wait, passed_over;
  int64_t left, start, aside = 0;
  int fault = NO_FAULT;
  bool looking = false, in_it = false;
  uint32_t why = STOP_LIMIT;

#define UNPACK_FLAGS()                                                                                                \
  (n = r[R_XPSR], z = ~r[R_XPSR] & Z, c = r[R_XPSR] >> 29 & 1, v = r[R_XPSR] << 3, rest = r[R_XPSR] & (Q | GE | IPSR))
#define PACK_FLAGS()                                                                                                  \
  (r[R_XPSR] = (n & N) | (z ? 0 : Z) | c << 29 | (v >> 31) << 28 | rest | T | (it & 3) << 25 | (it & 0xFC) << 8)
#define PC_OF(which) (code_base + (uint32_t)((which) - ops) * 2)
#define TAKE_TIMING()                                                                                                 \
  (refill = state->table ? (state->refill + state->wait_states) * HIL_UNIT : 0,                                       \
   literal_wait = state->table ? state->wait_states * HIL_UNIT : 0, passed_over = state->table ? HIL_UNIT : 0)
  /* Time up to the instruction in flight, or the next. */
#define SETTLE_TIME()                                                                                                 \
  do {                                                                                                                \
    int64_t all = left + aside, units = all >> 24;                                                                    \
    state->retired += (uint64_t)(all & (HIL_UNIT - 1));                                                               \
    state->cycle = state->table ? state->cycle + (uint64_t)(start - units) : hil_cycle_at(state, state->retired);     \
    start = units;                                                                                                    \
    left = start * HIL_UNIT - aside;                                                                                  \
  } while (0)
  /* Before and after somebody else may look at the state or change it. */
#define LEAVE()                                                                                                       \
  do {                                                                                                                \
    SETTLE_TIME();                                                                                                    \
    r[R_PC] = PC_OF(op);                                                                                              \
    PACK_FLAGS();                                                                                                     \
    r[hil_uses_psp(state) ? R_PSP : R_MSP] = r[R_SP];                                                                 \
  } while (0)
#define COME_BACK()                                                                                                   \
  do {                                                                                                                \
    if (state->changed) {                                                                                             \
      state->changed = 0;                                                                                             \
      cpu->look.dirty = true;                                                                                         \
      start = left_until_limit(state);                                                                                \
      left = start * HIL_UNIT - aside;                                                                                \
      TAKE_TIMING();                                                                                                  \
    }                                                                                                                 \
  } while (0)

#define JUMP_TO(operation) (int32_t)((const char *)LABELS[operation] - (const char *)&&L_UNDECODED)
#define DISPATCH() goto *(&&L_UNDECODED + op->jump)
#define NEXT()                                                                                                        \
  do {                                                                                                                \
    left -= op->cost;                                                                                                 \
    op += op->halves;                                                                                                 \
    if (UNLIKELY(left < HIL_UNIT))                                                                                    \
      goto pause;                                                                                                     \
    DISPATCH();                                                                                                       \
  } while (0)
#define JUMP(target)                                                                                                  \
  do {                                                                                                                \
    destination = (target);                                                                                           \
    left -= op->cost;                                                                                                 \
    if (UNLIKELY(refill) && destination != PC_OF(op) + 2u * op->halves)                                               \
      left -= refill;                                                                                                 \
    if (UNLIKELY(destination - code_base >= code_size))                                                               \
      goto far;                                                                                                       \
    op = ops + ((destination - code_base) >> 1);                                                                      \
    if (UNLIKELY(left < HIL_UNIT))                                                                                    \
      goto pause;                                                                                                     \
    DISPATCH();                                                                                                       \
  } while (0)
#define STOP(reason)                                                                                                  \
  do {                                                                                                                \
    why = (reason);                                                                                                   \
    goto retire_and_stop;                                                                                             \
  } while (0)
#define FAIL(kind)                                                                                                    \
  do {                                                                                                                \
    fault = (kind);                                                                                                   \
    goto failed;                                                                                                      \
  } while (0)

#define ALIGN_SP()                                                                                                    \
  do {                                                                                                                \
    if (aligns_sp) {                                                                                                  \
      aligns_sp = 0;                                                                                                  \
      r[R_SP] &= ~3u;                                                                                                 \
      left += ASIDE;                                                                                                  \
      aside -= ASIDE;                                                                                                 \
    }                                                                                                                 \
  } while (0)

#define BEGIN_BLOCK()                                                                                                 \
  do {                                                                                                                \
    if (!in_it) {                                                                                                     \
      in_it = true;                                                                                                   \
      left -= ASIDE;                                                                                                  \
      aside += ASIDE;                                                                                                 \
    }                                                                                                                 \
  } while (0)
#define END_BLOCK()                                                                                                   \
  do {                                                                                                                \
    if (in_it) {                                                                                                      \
      in_it = false;                                                                                                  \
      left += ASIDE;                                                                                                  \
      aside -= ASIDE;                                                                                                 \
    }                                                                                                                 \
  } while (0)

  /* --- memory */

#define NEAR_LOAD(type, target)                                                                                       \
  do {                                                                                                                \
    const struct hil_region *near = cpu->near[0];                                                                     \
    uint32_t offset = address - near->base;                                                                           \
    if (UNLIKELY(offset >= near->size)) {                                                                             \
      near = cpu->near[1];                                                                                            \
      offset = address - near->base;                                                                                  \
    }                                                                                                                 \
    if (LIKELY(offset < near->size && !(address & (sizeof(type) - 1)))) {                                             \
      type loaded;                                                                                                    \
      memcpy(&loaded, near->data + offset, sizeof loaded);                                                            \
      target = (uint32_t)loaded;                                                                                      \
    } else {                                                                                                          \
      FAR_LOAD(sizeof(type));                                                                                         \
      target = (uint32_t)(type)value;                                                                                 \
    }                                                                                                                 \
  } while (0)
#define FAR_LOAD(size)                                                                                                \
  do {                                                                                                                \
    int how = hil_load_memory(cpu, address, size, &value);                                                            \
    if (how == ACCESS_REGISTERS) {                                                                                    \
      LEAVE();                                                                                                        \
      how = hil_load_register(cpu, address, size, &value);                                                            \
      COME_BACK();                                                                                                    \
    }                                                                                                                 \
    if (UNLIKELY(how != ACCESS_DONE))                                                                                 \
      FAIL(how);                                                                                                      \
  } while (0)
#define NEAR_STORE(type, what)                                                                                        \
  do {                                                                                                                \
    uint32_t stored = (what), offset = address - cpu->near[0]->base;                                                  \
    if (LIKELY(offset < cpu->near[0]->size && !(address & (sizeof(type) - 1)))) {                                     \
      type kept = (type)stored;                                                                                       \
      memcpy(cpu->near[0]->data + offset, &kept, sizeof kept);                                                        \
    } else {                                                                                                          \
      FAR_STORE(sizeof(type), stored);                                                                                \
    }                                                                                                                 \
  } while (0)
#define FAR_STORE(size, what)                                                                                         \
  do {                                                                                                                \
    int how = hil_store_memory(cpu, address, size, what);                                                             \
    if (how == ACCESS_REGISTERS) {                                                                                    \
      LEAVE();                                                                                                        \
      how = hil_store_register(cpu, address, size, what, (op->cost + 1) / HIL_UNIT);                                  \
      COME_BACK();                                                                                                    \
    }                                                                                                                 \
    if (UNLIKELY(how != ACCESS_DONE))                                                                                 \
      FAIL(how);                                                                                                      \
  } while (0)
  /* Several words must be aligned, always (section A3.2.1). */
#define CHECK_ALIGNED()                                                                                               \
  do {                                                                                                                \
    if (UNLIKELY(address & 3)) {                                                                                      \
      state->fault_address = address;                                                                                 \
      FAIL(FAULT_UNALIGNED);                                                                                          \
    }                                                                                                                 \
  } while (0)
  /* Before the first of several words is accessed: a register must not be read twice. */
#define STOP_IF_WATCHED(count, kind, stored)                                                                          \
  do {                                                                                                                \
    if (UNLIKELY(cpu->hooks.watchpoint_count)) {                                                                      \
      LEAVE();                                                                                                        \
      if (hil_watch_stops(cpu, address, 4u * (count), kind, stored))                                                  \
        FAIL(ACCESS_HIT);                                                                                             \
    }                                                                                                                 \
  } while (0)
#define ALL_NEAR(count)                                                                                               \
  (address - cpu->near[0]->base < cpu->near[0]->size &&                                                               \
   cpu->near[0]->size - (address - cpu->near[0]->base) >= 4u * (count))
#define NEAR_BYTES() (cpu->near[0]->data + (address - cpu->near[0]->base))
#define LOAD_WORDS(words, count)                                                                                      \
  do {                                                                                                                \
    CHECK_ALIGNED();                                                                                                  \
    if (LIKELY(ALL_NEAR(count))) {                                                                                    \
      memcpy(words, NEAR_BYTES(), 4u * (count));                                                                      \
      break;                                                                                                          \
    }                                                                                                                 \
    STOP_IF_WATCHED(count, HIT_READ, NULL);                                                                           \
    for (uint32_t at_ = 0; at_ < (count); at_++, address += 4)                                                        \
      NEAR_LOAD(uint32_t, (words)[at_]);                                                                              \
  } while (0)
  /* A store that fails takes those before it back, as far as they went to memory. */
#define STORE_WORDS(words, count)                                                                                     \
  do {                                                                                                                \
    CHECK_ALIGNED();                                                                                                  \
    if (LIKELY(ALL_NEAR(count))) {                                                                                    \
      memcpy(NEAR_BYTES(), words, 4u * (count));                                                                      \
      break;                                                                                                          \
    }                                                                                                                 \
    STOP_IF_WATCHED(count, HIT_WRITE, words);                                                                         \
    for (uint32_t at_ = 0; at_ < (count); at_++, address += 4) {                                                      \
      undo_address[undo_count] = address;                                                                             \
      undo_count += hil_peek_memory(cpu, address, 4, &undo_word[undo_count]) == ACCESS_DONE;                          \
      NEAR_STORE(uint32_t, (words)[at_]);                                                                             \
    }                                                                                                                 \
    undo_count = 0;                                                                                                   \
  } while (0)
  uint32_t words[MOST_WORDS + 1], undo_address[MOST_WORDS + 1], undo_word[MOST_WORDS + 1], undo_count = 0;

  /* --- begin */

  state->limit_cycle = limit_cycle;
  state->limit_retired = state->retired + instructions;
  state->changed = state->attention = 0;
  state->running = 1;
  cpu->executing = true;
  state->fault = NO_FAULT;
  state->fault_address = 0;
  state->stop_value = 0;
  cpu->hooks.hit.kind = cpu->hooks.hit.in_block = 0;
  r[R_SP] = r[hil_uses_psp(state) ? R_PSP : R_MSP];
  state->counting = 0;
  hil_look_from(state);
  start = left_until_limit(state);
  if (start < 1)
    start = 1;
  left = start * HIL_UNIT;
  TAKE_TIMING();
  UNPACK_FLAGS();
  it = (r[R_XPSR] >> 25 & 3) | (r[R_XPSR] >> 8 & 0xFC);
  if (!(r[R_XPSR] & T)) {
    state->fault = FAULT_STATE;
    why = STOP_FAULT;
    goto end;
  }
  goto enter;

  /* --- between two instructions */

pause:
  ALIGN_SP();
  if (it) {
    it = it_advanced(it);
  in_block:
    while (it && !holds(it >> 4, n, z, c, v)) {
      if (op->code == OP_END_OF_MEMORY || begins_breakpoint(cpu, code, op, PC_OF(op)))
        break;
      op += length_of(cpu, code, op, PC_OF(op));
      left -= passed_over;
      it = it_advanced(it);
    }
    if (it)
      goto dispatch_in_block;
    END_BLOCK();
  }
  if (looking) {
    left += ASIDE;
    aside -= ASIDE;
    goto look;
  }
  if (left < HIL_UNIT) {
    LEAVE();
    looking = hil_look_begins(cpu);
    start = left_until_limit(state);
    left = start * HIL_UNIT;
    if (start <= 0)
      goto end;
    if (looking)
      goto next_in_look;
  }
  DISPATCH();

  /* During a look, after each instruction that is not in an IT block. */
look: {
  bool at_start = PC_OF(op) == cpu->look.before.reg[R_PC];
  if (at_start)
    LEAVE();
  enum hil_lap lap = hil_look_step(cpu, at_start);
  if (lap != LAP_GOES_ON) {
    LEAVE();
    looking = false;
    if (!hil_look_goes_on(cpu, lap))
      goto end;
    start = left_until_limit(state);
    left = start * HIL_UNIT;
    if (start <= 0)
      goto end;
    DISPATCH();
  }
  if (left < HIL_UNIT) {
    LEAVE();
    if (hil_is_over(state)) {
      hil_look_end(cpu, LAP_GOES_ON);
      goto end;
    }
    start = left_until_limit(state);
    left = start * HIL_UNIT;
  }
}
next_in_look:
  left -= ASIDE;
  aside += ASIDE;
  DISPATCH();

dispatch_in_block:
  if (op->flags & OP_NARROW && op->code > OP_END_OF_MEMORY)
    goto *LABELS[op->code + 1];
  DISPATCH();

  /* A branch to other memory, or to where there is none. */
far:
  ALIGN_SP();
  if (it)
    it = it_advanced(it);
enter:
  code = hil_region_at(cpu, destination);
  if (UNLIKELY(!code || !code->data || !has_code(code, JUMP_TO(OP_END_OF_MEMORY)))) {
    op = ops = &nowhere;
    code_base = destination;
    code_size = 0;
    LEAVE();
    if (!it && start <= 0 && left_until_limit(state) <= 0)
      goto end;
    state->fault = FAULT_FETCH;
    state->fault_address = destination;
    why = STOP_FAULT;
    goto end;
  }
  ops = code->ops;
  code_base = code->base;
  code_size = code->size;
  op = ops + ((destination - code_base) >> 1);
  if (it) {
    BEGIN_BLOCK();
    goto in_block;
  }
  END_BLOCK();
  if (state->skip == LOOK_ONCE && !looking && !it) {
    LEAVE();
    hil_look_begin(cpu);
    looking = true;
    goto next_in_look;
  }
  if (left < HIL_UNIT)
    goto pause;
  DISPATCH();

L_END_OF_MEMORY:
  destination = PC_OF(op); /* a wide instruction may have ended beyond */
  goto enter;

L_UNDECODED: {
  bool complete;
  uint32_t raw = hil_fetch(cpu, code, PC_OF(op), &complete);
  if (!complete) {
    state->fault_address = PC_OF(op);
    FAIL(FAULT_FETCH);
  }
  hil_decode(cpu, PC_OF(op), raw, code->writable, op);
  hil_hook(cpu, PC_OF(op), op);
  op->jump = JUMP_TO(op->code);
  if (it)
    goto dispatch_in_block;
  DISPATCH();
}

  /* Code in writable memory may have changed, whoever did that. */
L_VERIFY:
  if (UNLIKELY(is_stale(cpu, code, op, PC_OF(op))))
    goto L_UNDECODED;
  if (op->flags & OP_ALIGNS_SP)
    goto L_TO_SP;
  goto *LABELS[op->real + (it && op->flags & OP_NARROW)];

  /* One that is stopped at, or whose edges are counted. */
L_HOOK:
  if (code->writable && is_stale(cpu, code, op, PC_OF(op)))
    goto L_UNDECODED;
  if (op->flags & OP_BREAKS) {
    LEAVE();
    if (hil_breaks(cpu)) {
      why = STOP_HIT;
      goto end;
    }
  }
  hil_count_edge(cpu, op, PC_OF(op));
  if (op->flags & OP_ALIGNS_SP)
    goto L_TO_SP;
  goto *LABELS[op->real + (it && op->flags & OP_NARROW)];

L_TO_SP:
  aligns_sp = 1;
  left -= ASIDE;
  aside += ASIDE;
  goto *LABELS[op->real];

  /* --- ends */

retire_and_stop:
  left -= op->cost;
  op += op->halves;
  if (it)
    it = it_advanced(it);
  LEAVE();
  goto end;

failed:
  for (; undo_count > 0; undo_count--)
    hil_poke_memory(cpu, undo_address[undo_count - 1], 4, undo_word[undo_count - 1]);
  LEAVE();
  if (fault == ACCESS_HIT) {
    why = STOP_HIT;
    goto end;
  }
  state->fault = fault;
  why = STOP_FAULT;
  goto end;

end:
  if (looking && state->looking)
    hil_look_end(cpu, LAP_GOES_ON);
  state->running = 0;
  cpu->executing = false;
  hil_tell_time(cpu);
  return why == STOP_LIMIT && state->cycle < state->limit_cycle ? STOP_PAUSE : why;

  /* --- data processing (section A5.2.2, A5.3.1, A5.3.11) */

#define KEEP_FLAGS(result) ((void)0)
#define SET_NZ(result) (n = z = (result))
#define REG_OPERAND() uint32_t second = r[op->c], carry = c
#define SHIFT_OPERAND() uint32_t carry = c, second = shifted(op->d, r[op->c], op->imm, &carry)
#define IMM_OPERAND() uint32_t second = op->imm, carry = op->d ? op->d & 1 : c
#define LOGICAL(operation, expression)                                                                                \
  LOGICAL_WITH(operation, REG, expression) LOGICAL_WITH(operation, SHIFT, expression)                                 \
  LOGICAL_WITH(operation, IMM, expression)
#define LOGICAL_WITH(operation, kind, expression)                                                                     \
  L_##operation##_##kind : {                                                                                          \
    kind##_OPERAND();                                                                                                 \
    uint32_t result = (expression);                                                                                   \
    r[op->a] = result;                                                                                                \
    SET_NZ(result);                                                                                                   \
    c = carry;                                                                                                        \
    NEXT();                                                                                                           \
  }                                                                                                                   \
  L_##operation##_##kind##_NF : {                                                                                     \
    kind##_OPERAND();                                                                                                 \
    (void)carry;                                                                                                      \
    r[op->a] = (expression);                                                                                          \
    NEXT();                                                                                                           \
  }
#define LOGICAL_TEST(operation, expression)                                                                           \
  LOGICAL_TEST_WITH(operation, REG, expression) LOGICAL_TEST_WITH(operation, SHIFT, expression)                       \
  LOGICAL_TEST_WITH(operation, IMM, expression)
#define LOGICAL_TEST_WITH(operation, kind, expression)                                                                \
  L_##operation##_##kind : {                                                                                          \
    kind##_OPERAND();                                                                                                 \
    SET_NZ(expression);                                                                                               \
    c = carry;                                                                                                        \
    NEXT();                                                                                                           \
  }
  /* AddWithCarry (section A2.2.1) */
#define ADD_WITH_CARRY(x, y, carry_in)                                                                                \
  uint32_t x_ = (x), y_ = (y);                                                                                        \
  uint64_t wide_ = (uint64_t)x_ + y_ + (carry_in);                                                                    \
  uint32_t result = (uint32_t)wide_
#define SET_NZCV() (SET_NZ(result), c = (uint32_t)(wide_ >> 32), v = ~(x_ ^ y_) & (x_ ^ result))
#define ARITHMETIC(operation, x, y, carry_in)                                                                         \
  ARITHMETIC_WITH(operation, REG, x, y, carry_in) ARITHMETIC_WITH(operation, SHIFT, x, y, carry_in)                   \
  ARITHMETIC_WITH(operation, IMM, x, y, carry_in)
#define ARITHMETIC_WITH(operation, kind, x, y, carry_in)                                                              \
  L_##operation##_##kind : {                                                                                          \
    kind##_OPERAND();                                                                                                 \
    (void)carry;                                                                                                      \
    ADD_WITH_CARRY(x, y, carry_in);                                                                                   \
    r[op->a] = result;                                                                                                \
    SET_NZCV();                                                                                                       \
    NEXT();                                                                                                           \
  }                                                                                                                   \
  L_##operation##_##kind##_NF : {                                                                                     \
    kind##_OPERAND();                                                                                                 \
    (void)carry;                                                                                                      \
    r[op->a] = (x) + (y) + (carry_in);                                                                                \
    NEXT();                                                                                                           \
  }
#define COMPARISON(operation, x, y, carry_in)                                                                         \
  COMPARISON_WITH(operation, REG, x, y, carry_in) COMPARISON_WITH(operation, SHIFT, x, y, carry_in)                   \
  COMPARISON_WITH(operation, IMM, x, y, carry_in)
#define COMPARISON_WITH(operation, kind, x, y, carry_in)                                                              \
  L_##operation##_##kind : {                                                                                          \
    kind##_OPERAND();                                                                                                 \
    (void)carry;                                                                                                      \
    ADD_WITH_CARRY(x, y, carry_in);                                                                                   \
    SET_NZCV();                                                                                                       \
    NEXT();                                                                                                           \
  }

  LOGICAL(AND, r[op->b] & second)
  LOGICAL(BIC, r[op->b] & ~second)
  LOGICAL(ORR, r[op->b] | second)
  LOGICAL(ORN, r[op->b] | ~second)
  LOGICAL(EOR, r[op->b] ^ second)
  LOGICAL(MOV, second)
  LOGICAL(MVN, ~second)
  LOGICAL_TEST(TST, r[op->b] & second)
  LOGICAL_TEST(TEQ, r[op->b] ^ second)
  ARITHMETIC(ADD, r[op->b], second, 0)
  ARITHMETIC(ADC, r[op->b], second, c)
  ARITHMETIC(SBC, r[op->b], ~second, c)
  ARITHMETIC(SUB, r[op->b], ~second, 1)
  ARITHMETIC(RSB, ~r[op->b], second, 1)
  COMPARISON(CMP, r[op->b], ~second, 1)
  COMPARISON(CMN, r[op->b], second, 0)

#define SHIFT_BY_CONSTANT(operation, type)                                                                            \
  L_##operation##_IMM : {                                                                                             \
    uint32_t result = shifted(type, r[op->c], op->imm, &c);                                                           \
    r[op->a] = result;                                                                                                \
    SET_NZ(result);                                                                                                   \
    NEXT();                                                                                                           \
  }                                                                                                                   \
  L_##operation##_IMM_NF : {                                                                                          \
    uint32_t carry = 0;                                                                                               \
    r[op->a] = shifted(type, r[op->c], op->imm, &carry);                                                              \
    NEXT();                                                                                                           \
  }
#define SHIFT_BY_REGISTER(operation, type)                                                                            \
  L_##operation##_BY : {                                                                                              \
    uint32_t result = shifted(type, r[op->b], r[op->c] & 0xFF, &c);                                                   \
    r[op->a] = result;                                                                                                \
    SET_NZ(result);                                                                                                   \
    NEXT();                                                                                                           \
  }                                                                                                                   \
  L_##operation##_BY_NF : {                                                                                           \
    uint32_t carry = 0;                                                                                               \
    r[op->a] = shifted(type, r[op->b], r[op->c] & 0xFF, &carry);                                                      \
    NEXT();                                                                                                           \
  }
  SHIFT_BY_CONSTANT(LSL, 0)
  SHIFT_BY_CONSTANT(LSR, 1)
  SHIFT_BY_CONSTANT(ASR, 2)
  SHIFT_BY_REGISTER(LSL, 0)
  SHIFT_BY_REGISTER(LSR, 1)
  SHIFT_BY_REGISTER(ASR, 2)
  SHIFT_BY_REGISTER(ROR, 3)

#define SIMPLE(operation, statement)                                                                                  \
  L_##operation : {                                                                                                   \
    statement;                                                                                                        \
    NEXT();                                                                                                           \
  }
  SIMPLE(NOP, (void)0)
  SIMPLE(MOVT, r[op->a] = (r[op->a] & 0xFFFF) | op->imm << 16)
  SIMPLE(SXTH, r[op->a] = (uint32_t)(int16_t)shifted(3, r[op->c], op->imm, &value))
  SIMPLE(SXTB, r[op->a] = (uint32_t)(int8_t)shifted(3, r[op->c], op->imm, &value))
  SIMPLE(UXTH, r[op->a] = (uint16_t)shifted(3, r[op->c], op->imm, &value))
  SIMPLE(UXTB, r[op->a] = (uint8_t)shifted(3, r[op->c], op->imm, &value))
  SIMPLE(REV, r[op->a] = __builtin_bswap32(r[op->c]))
  SIMPLE(REV16, r[op->a] = (r[op->c] >> 8 & 0x00FF00FF) | (r[op->c] & 0x00FF00FF) << 8)
  SIMPLE(REVSH, r[op->a] = (uint32_t)(int16_t)__builtin_bswap16((uint16_t)r[op->c]))
  SIMPLE(RBIT, r[op->a] = bits_reversed(r[op->c]))
  SIMPLE(CLZ, r[op->a] = r[op->c] ? (uint32_t)__builtin_clz(r[op->c]) : 32)
  SIMPLE(UBFX, r[op->a] = r[op->b] >> op->imm & field_mask(op->e))
  SIMPLE(SBFX, r[op->a] = (uint32_t)((int32_t)(r[op->b] << (32 - op->imm - op->e)) >> (32 - op->e)))
  SIMPLE(BFC, r[op->a] &= ~(field_mask(op->e) << op->imm))
  SIMPLE(BFI, uint32_t mask = field_mask(op->e) << op->imm;
         r[op->a] = (r[op->a] & ~mask) | (r[op->b] << op->imm & mask))
  SIMPLE(MLA, r[op->a] = r[op->d] + r[op->b] * r[op->c])
  SIMPLE(MLS, r[op->a] = r[op->d] - r[op->b] * r[op->c])
  SIMPLE(MUL, r[op->a] = r[op->b] * r[op->c]; SET_NZ(r[op->a]))
  SIMPLE(MUL_NF, r[op->a] = r[op->b] * r[op->c])

#define LONG_RESULT(expression)                                                                                       \
  uint64_t result = (expression);                                                                                     \
  r[op->a] = (uint32_t)result;                                                                                        \
  r[op->d] = (uint32_t)(result >> 32)
#define LONG_SUM ((uint64_t)r[op->d] << 32 | r[op->a])
#define SIGNED_PRODUCT ((uint64_t)((int64_t)(int32_t)r[op->b] * (int32_t)r[op->c]))
#define UNSIGNED_PRODUCT ((uint64_t)r[op->b] * r[op->c])
  SIMPLE(SMULL, LONG_RESULT(SIGNED_PRODUCT))
  SIMPLE(UMULL, LONG_RESULT(UNSIGNED_PRODUCT))
  SIMPLE(SMLAL, LONG_RESULT(LONG_SUM + SIGNED_PRODUCT))
  SIMPLE(UMLAL, LONG_RESULT(LONG_SUM + UNSIGNED_PRODUCT))
  SIMPLE(UMAAL, LONG_RESULT(UNSIGNED_PRODUCT + r[op->a] + r[op->d]))
  SIMPLE(SMLALX, LONG_RESULT(hil_multiply_add_long(op->e, r[op->b], r[op->c], LONG_SUM)))

L_SDIV:
  if (!r[op->c] && state->trap_division)
    FAIL(FAULT_DIVISION);
  r[op->a] = divided((int32_t)r[op->b], (int32_t)r[op->c]);
  NEXT();
L_UDIV:
  if (!r[op->c] && state->trap_division)
    FAIL(FAULT_DIVISION);
  r[op->a] = r[op->c] ? r[op->b] / r[op->c] : 0;
  NEXT();

L_PKH: {
  uint32_t carry = 0, second = shifted(op->d ? 2 : 0, r[op->c], op->imm, &carry);
  r[op->a] = op->d ? (r[op->b] & 0xFFFF0000) | (second & 0xFFFF) : (r[op->b] & 0xFFFF) | (second & 0xFFFF0000);
  NEXT();
}
L_SSAT:
L_USAT: {
  uint32_t carry = 0;
  bool saturated = false;
  int32_t operand = (int32_t)shifted(op->d, r[op->b], op->imm, &carry);
  r[op->a] = hil_saturate(operand, op->e, op->real == OP_SSAT, &saturated);
  rest |= saturated ? Q : 0;
  NEXT();
}
L_DSP:
  r[op->a] = hil_dsp(op->e, op, r, &rest);
  NEXT();
L_SMLAX:
  r[op->a] = hil_multiply_add(op, r, &rest);
  NEXT();

  /* --- with high registers, of which PC may be one (section A5.2.3) */

#define READ_PC() (r[R_PC] = PC_OF(op) + 4)

L_ADD_HIGH: {
  READ_PC();
  uint32_t result = r[op->a] + r[op->c];
  if (op->a == R_PC)
    JUMP(result & ~1u);
  r[op->a] = result;
  NEXT();
}
L_MOV_HIGH:
  READ_PC();
  if (op->a == R_PC)
    JUMP(r[op->c] & ~1u);
  r[op->a] = r[op->c];
  NEXT();
L_CMP_HIGH: {
  READ_PC();
  ADD_WITH_CARRY(r[op->b], ~r[op->c], 1);
  SET_NZCV();
  NEXT();
}

  /* --- branches */

#define BRANCH_IF(operation, condition)                                                                               \
  L_##operation : {                                                                                                   \
    if (condition)                                                                                                    \
      JUMP(op->imm);                                                                                                  \
    NEXT();                                                                                                           \
  }
  BRANCH_IF(BEQ, !z)
  BRANCH_IF(BNE, z)
  BRANCH_IF(BCS, c)
  BRANCH_IF(BCC, !c)
  BRANCH_IF(BMI, n >> 31)
  BRANCH_IF(BPL, !(n >> 31))
  BRANCH_IF(BVS, v >> 31)
  BRANCH_IF(BVC, !(v >> 31))
  BRANCH_IF(BHI, c && z)
  BRANCH_IF(BLS, !c || !z)
  BRANCH_IF(BGE, !((n ^ v) >> 31))
  BRANCH_IF(BLT, (n ^ v) >> 31)
  BRANCH_IF(BGT, z && !((n ^ v) >> 31))
  BRANCH_IF(BLE, !z || (n ^ v) >> 31)
  BRANCH_IF(CBZ, !r[op->b])
  BRANCH_IF(CBNZ, r[op->b])
L_B:
  JUMP(op->imm);
L_BL:
  r[R_LR] = (PC_OF(op) + 4) | 1;
  JUMP(op->imm);
L_BLX:
  READ_PC();
  value = r[op->c];
  r[R_LR] = (PC_OF(op) + 2) | 1;
  goto interwork;
L_BX:
  READ_PC();
  value = r[op->c];
  if (value >= EXC_RETURN && rest & IPSR)
    goto exception_return;

  /* To `value`, whose bit 0 says that there is Thumb code (``BXWritePC``). */
interwork:
  if (LIKELY(value & 1))
    JUMP(value & ~1u);
  ALIGN_SP();
  left -= op->cost;
  if (value != PC_OF(op) + 2u * op->halves)
    left -= refill;
  if (it)
    it = it_advanced(it);
  LEAVE();
  r[R_PC] = value;
  r[R_XPSR] &= ~T;
  if (!it && start <= 0 && left_until_limit(state) <= 0)
    goto end;
  state->fault = FAULT_STATE;
  why = STOP_FAULT;
  goto end;

exception_return:
  ALIGN_SP();
  left -= op->cost;
  if (it)
    it = it_advanced(it);
  LEAVE();
  r[R_PC] = value & ~1u;
  state->stop_value = value | 1;
  why = STOP_EXCEPTION_RETURN;
  goto end;

  /* A load to PC (``LoadWritePC``). */
branch_to_loaded:
  if (value >= EXC_RETURN && rest & IPSR)
    goto exception_return;
  goto interwork;

L_TBB:
  READ_PC();
  address = r[op->b] + r[op->c];
  NEAR_LOAD(uint8_t, value);
  JUMP(PC_OF(op) + 4 + 2 * value);
L_TBH:
  READ_PC();
  address = r[op->b] + 2 * r[op->c];
  NEAR_LOAD(uint16_t, value);
  JUMP(PC_OF(op) + 4 + 2 * value);
  /* Within a block it is UNPREDICTABLE, and here UNDEFINED: a loop of blocks that never end could not be left. */
L_IT:
  if (it)
    FAIL(FAULT_UNDEFINED);
  left -= op->cost;
  BEGIN_BLOCK();
  it = op->imm;
  op++;
  goto in_block;

  /* --- loads and stores of one register */

#define LOAD_FORMS(operation, type)                                                                                   \
  L_##operation##_OFFSET : address = r[op->b] + op->imm;                                                              \
  NEAR_LOAD(type, r[op->a]);                                                                                          \
  NEXT();                                                                                                             \
  L_##operation##_INDEX : address = r[op->b] + (r[op->c] << op->imm);                                                 \
  NEAR_LOAD(type, r[op->a]);                                                                                          \
  NEXT();                                                                                                             \
  L_##operation##_BEFORE : address = r[op->b] + op->imm;                                                              \
  NEAR_LOAD(type, value);                                                                                             \
  r[op->b] += op->imm;                                                                                                \
  r[op->a] = value;                                                                                                   \
  NEXT();                                                                                                             \
  L_##operation##_AFTER : address = r[op->b];                                                                         \
  NEAR_LOAD(type, value);                                                                                             \
  r[op->b] += op->imm;                                                                                                \
  r[op->a] = value;                                                                                                   \
  NEXT();
#define LOAD_LITERAL(operation, type)                                                                                 \
  L_##operation##_LITERAL : address = op->imm;                                                                        \
  NEAR_LOAD(type, r[op->a]);                                                                                          \
  left -= literal_wait;                                                                                               \
  NEXT();
#define STORE_FORMS(operation, type)                                                                                  \
  L_##operation##_OFFSET : address = r[op->b] + op->imm;                                                              \
  NEAR_STORE(type, r[op->a]);                                                                                         \
  NEXT();                                                                                                             \
  L_##operation##_INDEX : address = r[op->b] + (r[op->c] << op->imm);                                                 \
  NEAR_STORE(type, r[op->a]);                                                                                         \
  NEXT();                                                                                                             \
  L_##operation##_BEFORE : address = r[op->b] + op->imm;                                                              \
  NEAR_STORE(type, r[op->a]);                                                                                         \
  r[op->b] += op->imm;                                                                                                \
  NEXT();                                                                                                             \
  L_##operation##_AFTER : address = r[op->b];                                                                         \
  NEAR_STORE(type, r[op->a]);                                                                                         \
  r[op->b] += op->imm;                                                                                                \
  NEXT();
  LOAD_FORMS(LDR, uint32_t)
  LOAD_FORMS(LDRH, uint16_t)
  LOAD_FORMS(LDRB, uint8_t)
  LOAD_FORMS(LDRSH, int16_t)
  LOAD_FORMS(LDRSB, int8_t)
  LOAD_LITERAL(LDR, uint32_t)
  LOAD_LITERAL(LDRH, uint16_t)
  LOAD_LITERAL(LDRB, uint8_t)
  LOAD_LITERAL(LDRSH, int16_t)
  LOAD_LITERAL(LDRSB, int8_t)
  STORE_FORMS(STR, uint32_t)
  STORE_FORMS(STRH, uint16_t)
  STORE_FORMS(STRB, uint8_t)

L_LDR_PC:
  address = r[op->b] + (op->d == 0 || op->d == 2 ? op->imm : op->d == 1 ? r[op->c] << op->imm : 0);
  NEAR_LOAD(uint32_t, value);
  if (op->flags & OP_WRITES_BACK)
    r[op->b] += op->imm;
  goto branch_to_loaded;
L_LDR_PC_LITERAL:
  address = op->imm;
  NEAR_LOAD(uint32_t, value);
  left -= literal_wait;
  goto branch_to_loaded;

  /* --- several registers (sections A7.7.41, A7.7.159) */

L_LDM: {
  address = r[op->b] - (op->d ? 4u * op->c : 0);
  uint32_t after = op->d ? address : address + 4u * op->c, at = 0;
  LOAD_WORDS(words, op->c);
  if (op->flags & OP_WRITES_BACK)
    r[op->b] = after;
  for (uint32_t list = op->imm & 0x7FFF; list; list &= list - 1)
    r[__builtin_ctz(list)] = words[at++];
  if (op->imm >> R_PC & 1) {
    value = words[at];
    goto branch_to_loaded;
  }
  NEXT();
}
L_STM: {
  address = r[op->b] - (op->d ? 4u * op->c : 0);
  uint32_t after = op->d ? address : address + 4u * op->c, at = 0;
  for (uint32_t list = op->imm; list; list &= list - 1)
    words[at++] = r[__builtin_ctz(list)];
  STORE_WORDS(words, op->c);
  if (op->flags & OP_WRITES_BACK)
    r[op->b] = after;
  NEXT();
}
L_LDRD:
  address = r[op->b] + (op->e ? op->imm : 0);
  LOAD_WORDS(words, 2);
  if (op->flags & OP_WRITES_BACK)
    r[op->b] += op->imm;
  r[op->a] = words[0];
  r[op->d] = words[1];
  NEXT();
L_LDRD_LITERAL:
  address = op->imm;
  LOAD_WORDS(words, 2);
  r[op->a] = words[0];
  r[op->d] = words[1];
  left -= literal_wait;
  NEXT();
L_STRD:
  address = r[op->b] + (op->e ? op->imm : 0);
  words[0] = r[op->a];
  words[1] = r[op->d];
  STORE_WORDS(words, 2);
  if (op->flags & OP_WRITES_BACK)
    r[op->b] += op->imm;
  NEXT();

  /* --- exclusive accesses: the monitor keeps the address (section A3.4; a choice that the manual leaves) */

L_LDREX:
  address = r[op->b] + op->imm;
  if (address & (op->e - 1u)) {
    state->fault_address = address;
    FAIL(FAULT_UNALIGNED);
  }
  FAR_LOAD(op->e);
  state->exclusive = 1;
  state->exclusive_address = address;
  r[op->a] = value;
  NEXT();
L_STREX:
  address = r[op->b] + op->imm;
  if (address & (op->e - 1u)) {
    state->fault_address = address;
    FAIL(FAULT_UNALIGNED);
  }
  value = !state->exclusive || state->exclusive_address != address;
  if (!value)
    FAR_STORE(op->e, r[op->a]);
  state->exclusive = 0;
  r[op->d] = value;
  NEXT();
L_CLREX:
  state->exclusive = 0;
  NEXT();

  /* --- what is for the caller */

L_UNDEFINED:
  FAIL(FAULT_UNDEFINED);
L_BKPT:
  LEAVE();
  state->stop_value = op->imm;
  why = STOP_BREAKPOINT;
  goto end;
L_SVC:
  state->stop_value = op->imm;
  STOP(STOP_SVC);
L_WFI:
  STOP(STOP_WFI);
L_WFE:
  STOP(STOP_WFE);
L_SEV:
  STOP(STOP_SEV);

  /* --- special registers; they need the state as others see it */

#define AFTER_SPECIAL(may_unmask)                                                                                     \
  do {                                                                                                                \
    bool unmasked = (may_unmask);                                                                                     \
    UNPACK_FLAGS();                                                                                                   \
    if (unmasked && state->until_unmasked) {                                                                          \
      state->attention = state->changed = 1;                                                                          \
      COME_BACK();                                                                                                    \
    }                                                                                                                 \
  } while (0)

L_MRS:
  LEAVE();
  r[op->a] = hil_read_special(cpu, op->e);
  NEXT();
L_MSR:
  LEAVE();
  AFTER_SPECIAL(hil_write_special(cpu, op->e, op->c, r[op->b]));
  NEXT();
L_CPS:
  LEAVE();
  AFTER_SPECIAL(hil_change_masks(cpu, op->imm));
  NEXT();

  /* --- floating point */

#define CHECK_FLOAT()                                                                                                 \
  do {                                                                                                                \
    if (UNLIKELY(state->float_access != 3)) {                                                                         \
      LEAVE();                                                                                                        \
      if (!may_float(state))                                                                                          \
        FAIL(FAULT_UNDEFINED);                                                                                        \
    }                                                                                                                 \
    if (UNLIKELY(!(r[R_CONTROL] & FPCA)))                                                                             \
      hil_begin_floats(cpu);                                                                                     \
  } while (0)

L_FLOAT:
  CHECK_FLOAT();
  if (op->e == FLOAT_SEL) {
    static const uint8_t CONDITIONS[] = {0, 6, 10, 12}; /* EQ, VS, GE, GT */
    uint32_t from = holds(CONDITIONS[op->imm], n, z, c, v) ? op->b : op->c;
    memmove(&state->floats[op->a], &state->floats[from], op->d ? 8 : 4);
  } else {
    hil_float(cpu, op);
  }
  NEXT();
L_VMRS:
  CHECK_FLOAT();
  if (op->a == R_PC) {
    uint32_t flags = state->floats[FPSCR];
    n = flags;
    z = ~flags & Z;
    c = flags >> 29 & 1;
    v = flags << 3;
  } else {
    r[op->a] = state->floats[FPSCR];
  }
  NEXT();
L_VMSR:
  CHECK_FLOAT();
  state->floats[FPSCR] = r[op->a] & 0xF7C0009F;
  NEXT();
L_VMOV_FROM_CORE:
  CHECK_FLOAT();
  state->floats[op->c] = r[op->a];
  NEXT();
L_VMOV_TO_CORE:
  CHECK_FLOAT();
  r[op->a] = state->floats[op->c];
  NEXT();
L_VMOV_PAIR_FROM_CORE:
  CHECK_FLOAT();
  state->floats[op->c] = r[op->a];
  state->floats[op->c + 1] = r[op->d];
  NEXT();
L_VMOV_PAIR_TO_CORE:
  CHECK_FLOAT();
  r[op->a] = state->floats[op->c];
  r[op->d] = state->floats[op->c + 1];
  NEXT();
L_VLDR:
  CHECK_FLOAT();
  address = r[op->b] + op->imm;
  goto load_float;
L_VLDR_LITERAL:
  CHECK_FLOAT();
  address = op->imm;
load_float:
  LOAD_WORDS(words, 1u + op->e);
  memcpy(&state->floats[op->a], words, 4u << op->e);
  NEXT();
L_VSTR:
  CHECK_FLOAT();
  address = r[op->b] + op->imm;
  STORE_WORDS(&state->floats[op->a], 1u + op->e);
  NEXT();
  /* An odd number of words of doubles is FLDMX, FSTMX: the last one is room that nobody uses (section A7.7.235). */
L_VLDM: {
  CHECK_FLOAT();
  uint32_t used = op->e ? op->imm & ~1u : op->imm, base = r[op->b];
  address = base - (op->d ? 4 * op->imm : 0);
  LOAD_WORDS(words, used);
  memcpy(&state->floats[op->a], words, 4 * used);
  if (op->flags & OP_WRITES_BACK)
    r[op->b] = op->d ? base - 4 * op->imm : base + 4 * op->imm;
  NEXT();
}
L_VSTM: {
  CHECK_FLOAT();
  uint32_t used = op->e ? op->imm & ~1u : op->imm, base = r[op->b];
  address = base - (op->d ? 4 * op->imm : 0);
  STORE_WORDS(&state->floats[op->a], used);
  if (op->flags & OP_WRITES_BACK)
    r[op->b] = op->d ? base - 4 * op->imm : base + 4 * op->imm;
  NEXT();
}
}
