/* Executes random half-words as code: random_code SEED INSTRUCTIONS
 *
 * Half of the code is random bits, half is made from the patterns of isa.h, of which now and then a bit is wrong. Cores
 * of both kinds and both timing models take turns at it, each in one of two ways:
 *
 * wild: what is not memory refuses, moves the limits, changes the timing, the traps, the code, and has code forgotten,
 *   all at random.
 * cut: what is not memory does what its address says; one core runs whole and passes loops over, another one executes
 *   the same code in random pieces, stops at breakpoints and watchpoints, counts edges and writes accesses down, and both
 *   must end alike; the other one again when it was put back.
 *
 * Half of the runs take exceptions, of which any may be enabled, pending and active; a trouble is put right by nobody.
 *
 * Prints the first thing that is wrong and returns 1. It is compiled with sanitizers, for which all memory is made by
 * malloc with its exact size. */
#include "cpu.h"
#include "isa.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct hil_cpu *hil_new(uint32_t is_m7, uint32_t by_table, uint32_t basepri_bits, hil_read read, hil_write write);
void hil_free(struct hil_cpu *cpu);
struct hil_state *hil_state_of(struct hil_cpu *cpu);
int32_t hil_map_memory(struct hil_cpu *cpu, uint32_t base, uint8_t *data, uint32_t size, uint32_t writable);
int32_t hil_map_registers(struct hil_cpu *cpu, uint32_t base, uint32_t size);
void hil_forget(struct hil_cpu *cpu, uint32_t base, uint32_t size);
void hil_set_up_exceptions(struct hil_cpu *cpu, uint32_t irq_count, uint32_t priority_bits);
void hil_reset_exceptions(struct hil_cpu *cpu);
void hil_reset_systick(struct hil_cpu *cpu);
void hil_enable(struct hil_cpu *cpu, uint32_t number);
void hil_set_active(struct hil_cpu *cpu, uint32_t number, uint32_t active);
void hil_set_priority(struct hil_cpu *cpu, uint32_t number, uint32_t priority);
bool hil_can_take(const struct hil_cpu *cpu);
uint32_t hil_go(struct hil_cpu *cpu, uint64_t limit_cycle, uint64_t instructions);

bool hil_set_breakpoints(struct hil_cpu *cpu, const uint32_t *addresses, uint32_t count);
bool hil_set_watchpoints(struct hil_cpu *cpu, const uint32_t *numbers, uint32_t count);
void hil_map_edges(struct hil_cpu *cpu, uint8_t *map, uint32_t size);
void hil_log_accesses(struct hil_cpu *cpu, struct hil_access *room, uint32_t most);
uint64_t hil_saved_size(const struct hil_cpu *cpu);
void hil_save(const struct hil_cpu *cpu, uint8_t *into);
void hil_restore(struct hil_cpu *cpu, const uint8_t *from);

#define ROW(pattern, form, operation, where, m3, m7) pattern,
#define FLOAT_ROW(pattern, kind, single, twice) pattern,
static const char *const PATTERNS[] = {ENCODINGS};
enum { PATTERN_COUNT = sizeof PATTERNS / sizeof *PATTERNS };

enum {
  FLASH = 0x08000000, ALIAS = 0, RAM = 0x20000000, NEXT_RAM = 0x20000400, REGISTERS_AT = 0x40000000,
  SCS_AT = (int32_t)0xE000E000, IRQS = 43, SCS_WINDOW = 4, MEMORY = 0x400, WINDOW = 0x400, AT_ONCE = 400,
};
enum { MEMORIES = 3, MAP = 256, LOGGED = 16, STOPS = 8 };
static const uint32_t BASES[MEMORIES] = {FLASH, RAM, NEXT_RAM};

static uint64_t seed;

/* xorshift64* */
static uint32_t drawn(void) {
  seed ^= seed >> 12;
  seed ^= seed << 25;
  seed ^= seed >> 27;
  return (uint32_t)(seed * 0x2545F4914F6CDD1Du >> 32);
}

static uint32_t below(uint32_t count) { return drawn() % count; }

static bool one_in(uint32_t count) { return below(count) == 0; }

struct chip {
  struct hil_cpu *cpu;
  uint8_t *memory[MEMORIES];
  uint8_t *edges;
  struct hil_access *accesses;
};

static struct chip chips[2], *current;
static bool wild;

/* --- code */

static void put_half(uint8_t *data, uint32_t at, uint16_t half) { memcpy(data + (at & (MEMORY - 2)), &half, 2); }

static void put_instruction(uint8_t *data, uint32_t at) {
  uint32_t code = 0, bits = 0;
  for (const char *digit = PATTERNS[below(PATTERN_COUNT)]; *digit; digit++)
    if (*digit != ' ') {
      code = code << 1 | (*digit == '1' || (*digit != '0' && one_in(2)));
      bits++;
    }
  if (one_in(16))
    code ^= 1u << below(bits);
  if (bits == 32)
    put_half(data, at, (uint16_t)(code >> 16));
  put_half(data, at + (bits == 32 ? 2 : 0), (uint16_t)code);
}

static void write_code(uint8_t *data, uint32_t from, uint32_t to) {
  for (uint32_t at = from & ~1u; at < to; at += 2) {
    if (one_in(2))
      put_half(data, at, (uint16_t)drawn());
    else
      put_instruction(data, at);
  }
}

static uint32_t somewhere(void) {
  static const uint16_t SETS_AND_ICSR[] = {0x010, 0x100, 0x180, 0x200, 0x280, 0x300, 0x400, 0xD04, 0xF00};
  switch (below(10)) {
  case 8: return 0xFFFFFFE1u | drawn();
  case 9: return (uint32_t)SCS_AT + SETS_AND_ICSR[below(9)] + below(one_in(2) ? 4 : 64);
  case 0: return drawn();
  case 1: return REGISTERS_AT + below(WINDOW + 8) - 4;
  case 2: return ALIAS + below(MEMORY + 8);
  case 3: return below(256);
  default: return BASES[below(MEMORIES)] + below(MEMORY + 8) - 4;
  }
}

static uint32_t some_float(void) {
  static const uint32_t EDGES[] = {0, 0x80000000, 0x3F800000, 0x7F800000, 0x7FC00000, 0x7F800001, 0x00800000, 0x007FFFFF,
                                   1, 0x7F7FFFFF, 0x7FEFFFFF, 0x00100000, 0x3FF00000, 0x7FF00000, 0x5F000000, 0xCF000000};
  return one_in(2) ? drawn() : EDGES[below(sizeof EDGES / sizeof *EDGES)];
}

/* --- what is not memory */

static uint32_t mixed(uint32_t a, uint32_t b, uint32_t c) {
  uint32_t value = (a * 0x9E3779B1u) ^ (b * 0x85EBCA77u) ^ (c * 0xC2B2AE3Du);
  return value ^ value >> 15;
}

static void change_code(void) {
  uint32_t which = below(MEMORIES), from = below(MEMORY), length = below(one_in(8) ? MEMORY : 16);
  uint32_t to = from + length < MEMORY ? from + length : MEMORY;
  write_code(current->memory[which], from, to);
  hil_forget(current->cpu, BASES[which] + from, length);
  if (one_in(8))
    hil_forget(current->cpu, somewhere(), drawn());
}

/* As targets/mcu/engine/timing.py does it. */
static void change_timing(struct hil_state *state) {
  state->wait_states = below(8);
  state->base = state->cycle;
  state->since = state->retired;
  state->numerator = 1 + below(40);
  state->denominator = 1 + below(40);
  state->changed = 1;
}

static void draw_hooks(struct chip *chip) {
  uint32_t numbers[3 * STOPS];
  for (uint32_t n = 0; n < 3 * STOPS; n++)
    numbers[n] = somewhere() & ~1u;
  hil_set_breakpoints(chip->cpu, numbers, below(STOPS));
  for (uint32_t n = 0; n < STOPS; n++) {
    numbers[3 * n + 1] = 1 + below(8);
    numbers[3 * n + 2] = 1 + below(3);
  }
  hil_set_watchpoints(chip->cpu, numbers, one_in(2) ? below(STOPS) : 0);
  hil_map_edges(chip->cpu, one_in(2) ? chip->edges : NULL, MAP);
  hil_log_accesses(chip->cpu, one_in(2) ? chip->accesses : NULL, LOGGED);
}

static void do_something(void) {
  struct hil_state *state = hil_state_of(current->cpu);
  switch (below(16)) {
  case 0: state->refused = 1; return;
  case 1: state->limit_cycle = state->cycle + below(8); state->changed = 1; return;
  case 2: state->limit_cycle = 0; state->changed = 1; return;
  case 3: state->limit_retired = 0; state->changed = 1; return;
  case 4: change_timing(state); return;
  case 5: change_code(); return;
  case 6: state->trap_unaligned = below(2); state->trap_division = below(2); return;
  case 7: state->float_access = (uint32_t[]){0, 1, 3}[below(3)]; return;
  case 8: state->exclusive = 0; return;
  case 9: state->live = 1; return;
  case 10: draw_hooks(current); return;
  default: return;
  }
}

/* While a look is on, the core has others answer for its own registers. */
static bool is_for_core(uint32_t window) { return window == SCS_WINDOW && hil_is_privileged(&current->cpu->state); }

static uint32_t on_read(uint32_t window, uint32_t offset, uint32_t size) {
  uint32_t value;
  if (is_for_core(window) && hil_scs_read(current->cpu, offset, size, &value))
    return value;
  if (wild)
    do_something();
  else
    hil_state_of(current->cpu)->refused = mixed(window, offset, size) % 16 == 0;
  return wild ? drawn() : mixed(window, offset, size + 1);
}

static void on_write(uint32_t window, uint32_t offset, uint32_t size, uint32_t value) {
  if (is_for_core(window) && hil_scs_write(current->cpu, offset, size, value))
    return;
  if (wild)
    do_something();
  else
    hil_state_of(current->cpu)->refused = mixed(window ^ value, offset, size) % 16 == 0;
}

/* --- a core */

static bool make(struct chip *chip, uint32_t is_m7, uint32_t by_table) {
  chip->cpu = hil_new(is_m7, by_table, 0xF0, on_read, on_write);
  if (!chip->cpu)
    return false;
  for (uint32_t n = 0; n < MEMORIES; n++) {
    chip->memory[n] = malloc(MEMORY);
    if (!chip->memory[n] || hil_map_memory(chip->cpu, BASES[n], chip->memory[n], MEMORY, n > 0) < 0)
      return false;
  }
  hil_set_up_exceptions(chip->cpu, IRQS, 4);
  chip->edges = calloc(MAP, 1);
  chip->accesses = calloc(LOGGED, sizeof *chip->accesses);
  return chip->edges && chip->accesses && hil_map_memory(chip->cpu, ALIAS, chip->memory[0], MEMORY, 0) >= 0 &&
         hil_map_registers(chip->cpu, (uint32_t)SCS_AT, 0x1000) >= 0 &&
         hil_map_registers(chip->cpu, REGISTERS_AT, WINDOW) >= 0;
}

static void unmake(struct chip *chip) {
  hil_free(chip->cpu);
  for (uint32_t n = 0; n < MEMORIES; n++)
    free(chip->memory[n]);
  free(chip->edges);
  free(chip->accesses);
}

/* As a program and its chip may leave them. */
static void draw_exceptions(struct hil_cpu *cpu) {
  struct hil_exceptions *x = &cpu->exceptions;
  hil_reset_exceptions(cpu);
  for (uint32_t n = below(8); n > 0; n--) {
    uint32_t number = 2 + below(14 + IRQS);
    if (number > HARD_FAULT)
      hil_set_priority(cpu, number, drawn());
    hil_enable(cpu, number);
    hil_set_active(cpu, number, one_in(4));
    hil_drive_line(cpu, number, one_in(2));
    hil_drive_line(cpu, number, one_in(4));
  }
  x->vtor = one_in(16) ? somewhere() & ~0x7Fu : BASES[below(MEMORIES)];
  x->ccr = drawn() & 0x201;
  x->scr = drawn() & 0x16;
  x->event_on_pend = x->scr >> 4;
  x->fpccr = drawn() & (3u << 30 | 1);
  x->fpdscr = drawn() & 0x07C00000;
  hil_reset_systick(cpu);
  hil_systick_write(cpu, 0x14, one_in(2) ? below(16) : below(300));
  hil_systick_write(cpu, 0x10, drawn());
}

/* As a caller of `hil_run` may leave the state, which is as CoreEngine.set does. */
static void restart(struct hil_cpu *cpu) {
  struct hil_state *state = &cpu->state;
  for (uint32_t n = 0; n < 15; n++)
    state->reg[n] = somewhere();
  state->reg[R_MSP] = somewhere() & ~3u;
  state->reg[R_PSP] = somewhere() & ~3u;
  state->reg[R_PC] = somewhere() & ~1u;
  state->reg[R_XPSR] = (drawn() & 0xF8000000) | (one_in(64) ? 0 : 1u << 24) | (one_in(8) ? below(100) : 0);
  if (one_in(8))
    state->reg[R_XPSR] |= drawn() & 0x0600FC00; /* in an IT block, as an exception return may leave it */
  state->reg[R_CONTROL] = one_in(4) ? below(8) : 4;
  for (uint32_t n = 0; n < 32; n++)
    state->floats[n] = some_float();
  state->floats[FPSCR] = drawn() & 0xF7C0009F;
  state->reg[R_PRIMASK] = one_in(4);
  state->reg[R_FAULTMASK] = one_in(8);
  state->reg[R_BASEPRI] = one_in(4) ? drawn() & 0xF0 : 0;
  draw_exceptions(cpu);
  if (one_in(2)) { /* in a handler that began */
    uint32_t number = 2 + below(14 + IRQS);
    hil_set_active(cpu, number, 1);
    state->reg[R_XPSR] = (state->reg[R_XPSR] & ~0x1FFu) | number;
  }
  if (one_in(4))
    state->reg[R_LR] = (uint32_t[]){0xFFFFFFF1, 0xFFFFFFF9, 0xFFFFFFFD}[below(3)] & ~(one_in(2) ? 0x10u : 0);
  if (one_in(8))
    state->reg[R_PC] = state->reg[R_LR] & ~1u;
  state->until_unmasked = one_in(4);
  if (one_in(8))
    change_timing(state);
}

static int wrong(const char *what, const struct hil_state *state) {
  printf("%s: at %08" PRIX32 ", xPSR %08" PRIX32 ", retired %" PRIu64 ", cycle %" PRIu64 ", limits %" PRIu64 ", %" PRIu64
         "\n",
         what, state->reg[R_PC], state->reg[R_XPSR], state->retired, state->cycle, state->limit_retired,
         state->limit_cycle);
  return 1;
}

/* What holds after every run. */
static int check_time(const struct hil_state *state, uint32_t why, uint64_t retired, uint64_t cycle, uint64_t limit) {
  if (why > STOP_PAUSE)
    return wrong("no reason", state);
  if (state->running)
    return wrong("runs on", state);
  if (state->cycle < cycle || state->retired < retired)
    return wrong("time goes back", state);
  return state->retired > limit + 4 ? wrong("beyond the limit", state) : 0;
}

/* What holds after one that has taken no exceptions. */
static int check(const struct hil_state *state, uint32_t why, uint64_t retired, uint64_t cycle, uint64_t limit) {
  if (why != STOP_FAULT && why != STOP_BREAKPOINT && why != STOP_HIT && state->retired == retired && state->cycle == cycle)
    return wrong("no time passes", state);
  if ((why == STOP_LIMIT || why == STOP_PAUSE) && state->reg[R_XPSR] & 0x0600FC00)
    return wrong("ended within an IT block", state);
  if (state->reg[R_SP] & 3)
    return wrong("a stack pointer that is not aligned", state);
  return check_time(state, why, retired, cycle, limit);
}

static int run_wild(struct chip *chip, uint64_t instructions) {
  struct hil_state *state = hil_state_of(chip->cpu);
  uint64_t end = state->retired + instructions;
  uint32_t idle = 0;
  current = chip;
  restart(chip->cpu);
  while (state->retired < end && idle < 4 * AT_ONCE) {
    uint64_t retired = state->retired, cycle = state->cycle, limit = retired + 1 + below(AT_ONCE);
    state->skip = below(LOOK_ONCE + 1);
    bool takes = one_in(2);
    if (!takes)
      hil_reset_systick(chip->cpu);
    uint32_t why = (takes ? hil_go : hil_run)(chip->cpu, one_in(2) ? cycle + 20 * AT_ONCE : cycle + below(AT_ONCE), limit - retired);
    if (takes ? check_time(state, why, retired, cycle, limit) : check(state, why, retired, cycle, limit))
      return 1;
    idle = state->retired == retired ? idle + 1 : 0;
    if (why == STOP_BREAKPOINT && one_in(2))
      state->reg[R_PC] += 2;
    else if (why == STOP_FAULT || why == STOP_BREAKPOINT || why == STOP_TROUBLE || chip->cpu->exceptions.sleeping || one_in(16))
      restart(chip->cpu);
    if (one_in(64))
      change_code();
  }
  return 0;
}

/* --- whole and in pieces */

static const char *difference(const struct chip *whole, const struct chip *cut) {
  struct hil_state *a = hil_state_of(whole->cpu), *b = hil_state_of(cut->cpu);
  for (uint32_t n = 0; n < MEMORIES; n++)
    if (memcmp(whole->memory[n], cut->memory[n], MEMORY) != 0)
      return "memory";
  if (memcmp(a->reg, b->reg, sizeof a->reg) != 0)
    return "registers";
  if (memcmp(a->floats, b->floats, sizeof a->floats) != 0)
    return "floating-point registers";
  if (a->cycle != b->cycle || a->retired != b->retired)
    return "time";
  if (a->fault != b->fault || a->fault_address != b->fault_address || a->stop_value != b->stop_value)
    return "reason";
  if (memcmp(&whole->cpu->exceptions, &cut->cpu->exceptions, sizeof whole->cpu->exceptions) != 0)
    return "exceptions";
  if (memcmp(&whole->cpu->systick, &cut->cpu->systick, sizeof whole->cpu->systick) != 0)
    return "timer";
  return a->exclusive != b->exclusive ? "monitor" : NULL;
}

/* Until so many instructions have retired, or so many cycles passed, at most `most` of either at a time. */
static uint32_t run_to(struct chip *chip, uint64_t end, uint64_t end_cycle, uint32_t most, bool takes) {
  struct hil_state *state = hil_state_of(chip->cpu);
  bool whole = most > AT_ONCE, asleep = false;
  uint32_t why;
  current = chip;
  do {
    uint64_t limit = state->retired + 1 + below(most), limit_cycle = state->cycle + 1 + below(most);
    if (whole || limit > end)
      limit = end > state->retired ? end : state->retired;
    if (whole || asleep || limit_cycle > end_cycle || one_in(2))
      limit_cycle = end_cycle;
    why = (takes ? hil_go : hil_run)(chip->cpu, limit_cycle, limit - state->retired);
    asleep = why == STOP_WFI && takes && state->alarm < end_cycle && !(chip->cpu->exceptions.scr & 4) && !asleep;
  } while (asleep || why == STOP_HIT || ((why == STOP_LIMIT || why == STOP_PAUSE) && state->cycle < end_cycle &&
                      (state->retired < end || (takes && (hil_can_take(chip->cpu) || chip->cpu->exceptions.sleeping)))));
  return why == STOP_PAUSE ? STOP_LIMIT : why;
}

static void tell_registers(const struct hil_state *a, const struct hil_state *b, uint32_t begin) {
  for (uint32_t n = 0; n < REGISTERS; n++)
    if (a->reg[n] != b->reg[n])
      printf("register %" PRIu32 ": %08" PRIX32 " and %08" PRIX32 "\n", n, a->reg[n], b->reg[n]);
  for (uint32_t n = 0; n < FLOATS; n++)
    if (a->floats[n] != b->floats[n])
      printf("S%" PRIu32 ": %08" PRIX32 " and %08" PRIX32 "\n", n, a->floats[n], b->floats[n]);
  for (uint32_t at = begin; at < begin + 24; at += 2)
    for (uint32_t n = 0; n < MEMORIES; n++)
      if (at - BASES[n] < MEMORY)
        printf("%02X%02X ", chips[0].memory[n][at - BASES[n] + 1], chips[0].memory[n][at - BASES[n]]);
  printf("\n");
}

/* What a chip is, to be put back; NULL: there is no memory. */
static uint8_t *saved_of(const struct chip *chip) {
  uint64_t size = hil_saved_size(chip->cpu);
  uint8_t *saved = malloc(size + MEMORIES * MEMORY);
  if (!saved)
    return NULL;
  hil_save(chip->cpu, saved);
  for (uint32_t n = 0; n < MEMORIES; n++)
    memcpy(saved + size + n * MEMORY, chip->memory[n], MEMORY);
  return saved;
}

static void put_back(struct chip *chip, const uint8_t *saved) {
  hil_restore(chip->cpu, saved);
  for (uint32_t n = 0; n < MEMORIES; n++)
    memcpy(chip->memory[n], saved + hil_saved_size(chip->cpu) + n * MEMORY, MEMORY);
}

static int run_cut(uint64_t instructions) {
  struct hil_state *whole = hil_state_of(chips[0].cpu);
  uint64_t end = whole->retired + instructions;
  for (uint32_t n = 0; n < MEMORIES; n++)
    memcpy(chips[1].memory[n], chips[0].memory[n], MEMORY);
  for (uint32_t rounds = 0; whole->retired < end && rounds < instructions; rounds++) {
    bool takes = one_in(2);
    restart(chips[0].cpu);
    if (!takes)
      hil_reset_systick(chips[0].cpu);
    whole->until_unmasked = 0;
    whole->skip = SKIP_NOTHING;
    draw_hooks(&chips[1]);
    chips[1].cpu->state = *whole;
    chips[1].cpu->exceptions = chips[0].cpu->exceptions;
    chips[1].cpu->systick = chips[0].cpu->systick;
    uint32_t begin = whole->reg[R_PC];
    whole->skip = one_in(2) ? SKIP_NOTHING : SKIP_LOOPS;
    uint64_t until = whole->retired + 1 + below(AT_ONCE), retired = whole->retired, cycle = whole->cycle;
    uint64_t until_cycle = takes ? cycle + 20 * AT_ONCE : UINT64_MAX;
    uint32_t why = run_to(&chips[0], until, until_cycle, AT_ONCE + 1, takes);
    uint8_t *saved = one_in(8) ? saved_of(&chips[1]) : NULL;
    uint32_t other = run_to(&chips[1], until, until_cycle, 1 + below(6), takes);
    if (saved) {
      put_back(&chips[1], saved);
      free(saved);
      other = run_to(&chips[1], until, until_cycle, 1 + below(6), takes);
    }
    const char *what = why == other ? difference(&chips[0], &chips[1]) : "reason";
    if (what) {
      printf("cut, from %08" PRIX32 ": %s differ: %" PRIu32 " and %" PRIu32 "\n", begin, what, why, other);
      tell_registers(whole, hil_state_of(chips[1].cpu), begin);
      wrong("whole", whole);
      return wrong("cut", hil_state_of(chips[1].cpu));
    }
    if (takes ? check_time(whole, why, retired, cycle, until) : check(whole, why, retired, cycle, until))
      return 1;
  }
  return 0;
}

int main(int count, char **words) {
  if (count != 3)
    return 2;
  uint64_t left = strtoull(words[2], NULL, 10);
  const uint64_t each = 20000;
  seed = strtoull(words[1], NULL, 10) * 0x9E3779B97F4A7C15u + 1;
  for (uint32_t round = 0; left > 0; round++, left -= left < each ? left : each) {
    wild = round & 4;
    for (uint32_t n = 0; n < 2; n++)
      if (!make(&chips[n], round & 1, round >> 1 & 1))
        return 2;
    for (uint32_t n = 0; n < MEMORIES; n++)
      write_code(chips[0].memory[n], 0, MEMORY);
    if (wild ? run_wild(&chips[0], each) : run_cut(each)) {
      printf("in round %" PRIu32 " of seed %s: %s, timing model \"%s\"\n", round, words[1], round & 1 ? "M7" : "M3",
             round & 2 ? "table" : "flat");
      return 1;
    }
    for (uint32_t n = 0; n < 2; n++)
      unmake(&chips[n]);
  }
  return 0;
}
