/* Exception entry and return, and sleep (DDI0403 sections B1.5.6 to B1.5.8, B1.5.17 to B1.5.19).
 *
 * Time. Entry and return go in two steps, so that what happens within their cycles counts:
 *
 * 1. Entry: the frame is stacked and the entry's cycles pass. Events of these cycles happen, and the next step reads
 *    the vector of whatever is most urgent by then: the exception that began the entry or one that arrived late. The
 *    other stays pending. No cycles are paid twice.
 * 2. Return: if an exception is pending that may be taken at the level returned to, it is tail-chained: nothing is
 *    unstacked or stacked. Otherwise the return's cycles pass; whatever became pending in them is then tail-chained too
 *    (the unstacking is abandoned), and only if there is nothing the registers come back.
 *
 * Cycles (Cortex-M3 TRM, sections on exception latency; zero wait states): 12 for entry, 6 for tail-chaining. 12 for
 * return, and that a fault at return costs as much as tail-chaining, are choices; and that a Cortex-M7 takes the same.
 * Choices too: 9 cycles more where 17 words of floating point go to the stack or come from it at once, two in a cycle;
 * none for room that is only reserved.
 *
 * A frame, from the new stack pointer upwards: R0, R1, R2, R3, R12, LR, return address, xPSR; with a floating-point
 * context S0 to S15, FPSCR and a word that nobody uses behind them. With CCR.STKALIGN, and always with a floating-point
 * context, it begins at a multiple of eight, and bit 9 of the xPSR in it says that four bytes were left out for that.
 *
 * Floating point: with FPCCR.LSPEN the registers go into the frame when the handler uses floating point itself
 * (``PreserveFPState``). Here they are written at once, and LSPACT is what it would be: it goes away with the first
 * floating-point instruction, which is seen in CONTROL.FPCA. A program can tell the difference only by reading the
 * reserved words before that instruction. If CPACR denies floating point by the time a context is stacked at once, a
 * UsageFault (NOCP) comes before the handler, as in QEMU; that the context is in the frame all the same is a choice:
 * QEMU leaves what was in memory.
 *
 * A fault needs somebody who writes it down and decides what becomes of it: every step that cannot go on as it should
 * returns its trouble, with everything ready to go on once the fault is pending. */
#include "cpu.h"

#include <string.h>

enum { ENTRY_CYCLES = 12, TAIL_CHAIN_CYCLES = 6, RETURN_CYCLES = 12, FLOAT_CYCLES = 9 };

enum { T_BIT = 1 << 24, APSR = (int32_t)0xF80F0000, IPSR = 0x1FF, ALIGNED = 1 << 9 };
enum { NPRIV = 1, SPSEL = 2, FPCA = 4 };                       /* CONTROL */
enum { NONBASETHRDENA = 1, STKALIGN = 1 << 9 };                /* CCR */
enum { SLEEPONEXIT = 2, SLEEPDEEP = 4 };                       /* SCR */
enum { ASPEN = 1 << 31, LSPEN = 1 << 30, LSPACT = 1 };         /* FPCCR */
enum { THREAD = 1 << 3, USER = 1 << 1, HFRDY = 1 << 4 }; /* FPCCR too */
enum { FPDSCR_BITS = 0x07C00000 };

/* EXC_RETURN (tables B1-8, B1-9); the bit is clear where the frame has floating-point registers. */
#define TO_HANDLER 0xFFFFFFF1u
#define TO_THREAD_MSP 0xFFFFFFF9u
#define TO_THREAD_PSP 0xFFFFFFFDu
#define BASIC 0x10u

enum { WORDS = 8, FLOATS_AT = 32, FLOAT_WORDS = 17, IN_FRAME = 16, BASIC_SIZE = 32, EXTENDED_SIZE = 104 };
static const uint8_t STACKED[WORDS - 1] = {0, 1, 2, 3, 12, R_LR, R_PC};

/* --- memory, as the core's own accesses reach it */

/* What an access to a register has brought about comes before the next step. */
static bool read_words(struct hil_cpu *cpu, uint32_t address, uint32_t *words, uint32_t count) {
  for (uint32_t n = 0; n < count; n++) {
    int how = hil_load_memory(cpu, address + 4 * n, 4, &words[n]);
    if (how == ACCESS_REGISTERS) {
      how = hil_load_register(cpu, address + 4 * n, 4, &words[n]);
      cpu->state.limit_cycle = cpu->state.refused = 0;
    }
    if (how != ACCESS_DONE)
      return false;
  }
  return true;
}

static bool write_words(struct hil_cpu *cpu, uint32_t address, const uint32_t *words, uint32_t count) {
  for (uint32_t n = 0; n < count; n++) {
    int how = hil_store_memory(cpu, address + 4 * n, 4, words[n]);
    if (how == ACCESS_REGISTERS) {
      how = hil_store_beside(cpu, address + 4 * n, words[n]);
      cpu->state.limit_cycle = cpu->state.refused = 0;
    }
    if (how != ACCESS_DONE)
      return false;
  }
  return true;
}

static void add_cycles(struct hil_state *state, uint64_t cycles) {
  state->base += cycles;
  state->cycle += cycles;
}

/* --- floating-point contexts */

/* If there is a context by now, what was to be preserved has been. */
HIL_EXPORT void hil_settle_floats(struct hil_cpu *cpu) {
  if (cpu->state.reg[R_CONTROL] & FPCA)
    cpu->exceptions.fpccr &= ~(uint32_t)LSPACT;
}

/* The first floating-point instruction of a context sets FPSCR (section A2.5.4, ``ExecuteFPCheck``): FPDSCR gives the
 * modes, the flags stay. */
void hil_begin_floats(struct hil_cpu *cpu) {
  const struct hil_exceptions *x = &cpu->exceptions;
  if (x->fpccr & (uint32_t)ASPEN && !(cpu->state.reg[R_CONTROL] & FPCA)) {
    cpu->state.reg[R_CONTROL] |= FPCA;
    cpu->state.floats[FPSCR] = (x->last_fpscr & ~(uint32_t)FPDSCR_BITS) | x->fpdscr;
  }
}

static bool may_use_floats(const struct hil_state *state) {
  return state->float_access == 3 || (state->float_access == 1 && hil_is_privileged(state));
}

/* Which exceptions could be taken now if a register could not be saved later (``UpdateFPCCR``). */
static uint32_t ready(const struct hil_cpu *cpu) {
  static const struct { uint8_t number, bit; } OTHERS[] = {{MEM_MANAGE, 5}, {BUS_FAULT, 6}, {DEBUG_MONITOR, 8}};
  const struct hil_exceptions *x = &cpu->exceptions;
  int32_t now = hil_execution_priority(cpu);
  uint32_t bits = now > -1 ? HFRDY : 0;
  for (uint32_t n = 0; n < sizeof OTHERS / sizeof *OTHERS; n++)
    if (hil_in(x->enabled, OTHERS[n].number) && hil_group_priority(x, OTHERS[n].number) < now)
      bits |= 1u << OTHERS[n].bit;
  return bits;
}

static void reserve_floats(struct hil_cpu *cpu, uint32_t place) {
  struct hil_exceptions *x = &cpu->exceptions;
  x->fpccr &= (uint32_t)ASPEN | LSPEN;
  x->fpccr |= ready(cpu) | (cpu->state.reg[R_XPSR] & IPSR ? 0 : THREAD) |
              (hil_is_privileged(&cpu->state) ? 0 : USER) | LSPACT;
  x->fpcar = place & ~7u;
}

/* --- entry */

/* Put a frame on the stack in use; its pointer moves even if it cannot be written, as on silicon. */
static bool push(struct hil_cpu *cpu, bool extended) {
  struct hil_state *state = &cpu->state;
  struct hil_exceptions *x = &cpu->exceptions;
  uint32_t words[WORDS + FLOAT_WORDS], xpsr = state->reg[R_XPSR], count = WORDS;
  bool of_process = hil_uses_psp(state);
  uint32_t *bank = &state->reg[of_process ? R_PSP : R_MSP], top = *bank & ~3u;
  uint32_t padding = extended || x->ccr & STKALIGN ? top & 4 : 0;
  x->exc_return = xpsr & IPSR ? TO_HANDLER : of_process ? TO_THREAD_PSP : TO_THREAD_MSP;
  for (uint32_t n = 0; n < WORDS - 1; n++)
    words[n] = state->reg[STACKED[n]];
  words[WORDS - 1] = (xpsr & ~(uint32_t)ALIGNED) | (padding ? ALIGNED : 0);
  if (extended) {
    x->exc_return &= ~BASIC;
    memcpy(words + WORDS, state->floats, 4 * IN_FRAME);
    words[WORDS + IN_FRAME] = state->floats[FPSCR];
    count += FLOAT_WORDS;
  }
  *bank = top - (extended ? EXTENDED_SIZE : BASIC_SIZE) - padding;
  return write_words(cpu, *bank, words, count);
}

/* Let the cycles of a step pass, or keep them for when a fault has been recorded. */
static enum hil_trouble go_on(struct hil_cpu *cpu, uint32_t step, uint32_t cycles, enum hil_trouble trouble) {
  cpu->exceptions.step = step;
  if (trouble)
    cpu->exceptions.owed = cycles;
  else
    add_cycles(&cpu->state, cycles);
  return trouble;
}

/* First step of entry: save what the exception interrupts. */
HIL_EXPORT enum hil_trouble hil_stack(struct hil_cpu *cpu) {
  struct hil_exceptions *x = &cpu->exceptions;
  uint32_t cycles = ENTRY_CYCLES, trouble = TROUBLE_NONE;
  hil_settle_floats(cpu);
  bool extended = cpu->state.reg[R_CONTROL] & FPCA;
  if (!push(cpu, extended))
    trouble |= TROUBLE_STACK;
  if (extended) {
    x->last_fpscr = cpu->state.floats[FPSCR];
    if (x->fpccr & LSPEN) {
      reserve_floats(cpu, cpu->state.reg[hil_uses_psp(&cpu->state) ? R_PSP : R_MSP] + FLOATS_AT);
    } else {
      cycles += FLOAT_CYCLES;
      trouble |= may_use_floats(&cpu->state) ? 0 : TROUBLE_STACK_FLOATS;
    }
  }
  return go_on(cpu, STEP_ENTER, cycles, trouble);
}

/* What cannot be executed at the place where the core goes on faults at once. */
static enum hil_trouble check_executable(const struct hil_state *state) {
  if (!(state->reg[R_XPSR] & T_BIT))
    return TROUBLE_STATE;
  uint32_t eighth = state->reg[R_PC] >> 29; /* peripherals, devices, system (table B3-1) */
  return eighth == 2 || eighth >= 5 ? TROUBLE_NEVER : TROUBLE_NONE;
}

/* Second step of entry: begin the handler of what is most urgent by now. */
static enum hil_trouble enter(struct hil_cpu *cpu) {
  struct hil_state *state = &cpu->state;
  struct hil_exceptions *x = &cpu->exceptions;
  uint32_t number = x->best, vector;
  if (!read_words(cpu, x->vtor + 4 * number, &vector, 1))
    return TROUBLE_VECTOR;
  x->step = STEP_NONE;
  hil_activate(cpu, number);
  x->event = x->began = 1;
  state->exclusive = 0;
  state->reg[R_CONTROL] &= ~(uint32_t)(SPSEL | FPCA);
  state->reg[R_LR] = x->exc_return;
  state->reg[R_PC] = vector & ~1u;
  state->reg[R_XPSR] = (state->reg[R_XPSR] & (uint32_t)APSR) | number | (vector & 1 ? T_BIT : 0);
  return check_executable(state);
}

/* --- return */

static bool preempts(const struct hil_cpu *cpu) {
  const struct hil_exceptions *x = &cpu->exceptions;
  return x->best_priority < x->active_priority && x->best_priority < hil_boosted_priority(cpu, true);
}

static bool of_process(uint32_t exc_return) { return (exc_return | BASIC) == TO_THREAD_PSP; }

static bool is_legal(const struct hil_cpu *cpu, uint32_t exc_return, bool alone) {
  if (cpu->has_float)
    exc_return |= BASIC;
  if (exc_return == TO_HANDLER)
    return !alone;
  return (exc_return == TO_THREAD_MSP || exc_return == TO_THREAD_PSP) &&
         (alone || cpu->exceptions.ccr & NONBASETHRDENA);
}

static bool is_alone(const struct hil_exceptions *x, uint32_t number) {
  uint32_t others = 0;
  for (uint32_t word = 0; word < EXCEPTION_WORDS; word++)
    others |= x->active[word] & ~(word == number >> 5 ? 1u << (number & 31) : 0);
  return !others;
}

/* A return that cannot be: its fault is tail-chained, the frame stays where it is. */
static enum hil_trouble bad_return(struct hil_cpu *cpu, enum hil_trouble trouble) {
  return go_on(cpu, STEP_ENTER, TAIL_CHAIN_CYCLES, trouble);
}

/* First step of return from a handler (section B1.5.8, ``ExceptionReturn``). */
static enum hil_trouble exception_return(struct hil_cpu *cpu, uint32_t exc_return) {
  struct hil_state *state = &cpu->state;
  struct hil_exceptions *x = &cpu->exceptions;
  uint32_t number = state->reg[R_XPSR] & IPSR, cycles = RETURN_CYCLES;
  bool was_active = hil_in(x->active, number), alone = is_alone(x, number);
  hil_deactivate(cpu, number);
  if (number < 32)
    x->open_faults &= ~(1u << number);
  if (number != NMI)
    state->reg[R_FAULTMASK] = 0;
  x->exc_return = exc_return;
  if (cpu->has_float) {
    hil_settle_floats(cpu);
    if (state->reg[R_CONTROL] & FPCA)
      x->last_fpscr = state->floats[FPSCR];
    if (!(exc_return & BASIC) && !(x->fpccr & LSPACT))
      cycles += FLOAT_CYCLES;
  }
  if (!was_active || !is_legal(cpu, exc_return, alone))
    return bad_return(cpu, TROUBLE_RETURN);
  if (preempts(cpu))
    return go_on(cpu, STEP_ENTER, TAIL_CHAIN_CYCLES, TROUBLE_NONE);
  return go_on(cpu, STEP_LEAVE, cycles, TROUBLE_NONE);
}

/* Read the frame, and set the floating-point registers that it has. */
static enum hil_trouble unstack(struct hil_cpu *cpu, uint32_t *words) {
  struct hil_exceptions *x = &cpu->exceptions;
  uint32_t place = cpu->state.reg[of_process(x->exc_return) ? R_PSP : R_MSP], floats[FLOAT_WORDS];
  if (!read_words(cpu, place, words, WORDS))
    return TROUBLE_UNSTACK;
  if (!(words[WORDS - 1] & IPSR) == ((x->exc_return | BASIC) == TO_HANDLER))
    return TROUBLE_RETURN;
  if (!cpu->has_float || x->exc_return & BASIC)
    return TROUBLE_NONE;
  if (x->fpccr & LSPACT) { /* the registers are still those of the frame */
    x->fpccr &= ~(uint32_t)LSPACT;
    return TROUBLE_NONE;
  }
  if (!cpu->state.float_access)
    return TROUBLE_RETURN_FLOATS;
  if (!read_words(cpu, place + FLOATS_AT, floats, FLOAT_WORDS))
    return TROUBLE_UNSTACK;
  memcpy(cpu->state.floats, floats, 4 * IN_FRAME);
  cpu->state.floats[FPSCR] = floats[IN_FRAME];
  return TROUBLE_NONE;
}

/* Take the frame with these words off its stack and go on from it. */
static void restore(struct hil_cpu *cpu, const uint32_t *words) {
  struct hil_state *state = &cpu->state;
  uint32_t exc_return = cpu->exceptions.exc_return;
  bool extended = !(exc_return & BASIC);
  bool aligned = extended || cpu->exceptions.ccr & STKALIGN;
  uint32_t *bank = &state->reg[of_process(exc_return) ? R_PSP : R_MSP];
  for (uint32_t n = 0; n < WORDS - 1; n++)
    state->reg[STACKED[n]] = words[n];
  state->reg[R_PC] &= ~1u;
  state->reg[R_XPSR] = words[WORDS - 1] & (cpu->has_dsp ? 0xFF0FFDFFu : 0xFF00FDFFu);
  state->reg[R_CONTROL] = (state->reg[R_CONTROL] & ~(uint32_t)(SPSEL | FPCA)) |
                          (of_process(exc_return) ? SPSEL : 0) | (extended ? FPCA : 0);
  *bank = (*bank + (extended ? EXTENDED_SIZE : BASIC_SIZE)) | (aligned && words[WORDS - 1] & ALIGNED ? 4 : 0);
}

static void fall_asleep(struct hil_cpu *cpu, bool for_event);

/* Second step of return: go back, unless something came in between. */
static enum hil_trouble leave(struct hil_cpu *cpu) {
  struct hil_exceptions *x = &cpu->exceptions;
  uint32_t words[WORDS];
  if (preempts(cpu))
    return go_on(cpu, STEP_ENTER, TAIL_CHAIN_CYCLES, TROUBLE_NONE);
  enum hil_trouble trouble = unstack(cpu, words);
  if (trouble)
    return bad_return(cpu, trouble);
  restore(cpu, words);
  x->step = STEP_NONE;
  x->event = x->began = 1;
  cpu->state.exclusive = 0;
  if (!(words[WORDS - 1] & IPSR) && x->scr & SLEEPONEXIT && x->active_priority == IDLE_PRIORITY)
    fall_asleep(cpu, false);
  return check_executable(&cpu->state);
}

/* --- sleep */

/* Whether a sleeping core wakes: from WFI by an exception that may be taken, PRIMASK aside; from WFE by one that may be
 * taken, or the event register. */
HIL_EXPORT bool hil_wakes(struct hil_cpu *cpu) {
  const struct hil_exceptions *x = &cpu->exceptions;
  hil_tick(cpu);
  if (!x->sleeping)
    return false;
  if (x->for_event && x->event)
    return true;
  return x->best_priority < x->active_priority && x->best_priority < hil_boosted_priority(cpu, x->for_event);
}

/* WFE consumes the event register. */
HIL_EXPORT void hil_wake(struct hil_cpu *cpu) {
  struct hil_exceptions *x = &cpu->exceptions;
  if (x->sleeping && x->for_event)
    x->event = 0;
  x->sleeping = 0;
}

static void fall_asleep(struct hil_cpu *cpu, bool for_event) {
  cpu->exceptions.for_event = for_event;
  cpu->exceptions.sleeping = 1;
  if (hil_wakes(cpu))
    hil_wake(cpu);
}

static void wait_for_event(struct hil_cpu *cpu) {
  if (cpu->exceptions.event)
    cpu->exceptions.event = 0;
  else
    fall_asleep(cpu, true);
}

/* --- between two instructions */

static enum hil_trouble supervisor_call(struct hil_cpu *cpu) {
  if (hil_group_priority(&cpu->exceptions, SVCALL) >= hil_execution_priority(cpu))
    return TROUBLE_CALL;
  hil_pend(cpu, SVCALL);
  return hil_stack(cpu);
}

/* Whether there is an exception to enter, or the second step of entry or return to do. */
HIL_EXPORT bool hil_can_take(struct hil_cpu *cpu) {
  hil_tick(cpu);
  return cpu->exceptions.step || (!cpu->exceptions.locked_up && preempts(cpu));
}

/* Do that step. */
HIL_EXPORT enum hil_trouble hil_take(struct hil_cpu *cpu) {
  cpu->state.loop_instructions = 0; /* the program may go elsewhere */
  hil_begin_elsewhere(&cpu->hooks);
  switch (cpu->exceptions.step) {
  case STEP_ENTER: return enter(cpu);
  case STEP_LEAVE: return leave(cpu);
  default: hil_wake(cpu); return hil_stack(cpu);
  }
}

/* Do what an instruction has asked for, by which a run ended. */
HIL_EXPORT enum hil_trouble hil_act(struct hil_cpu *cpu, enum hil_stop why, uint32_t value) {
  switch (why) {
  case STOP_EXCEPTION_RETURN: return exception_return(cpu, value);
  case STOP_SVC: return supervisor_call(cpu);
  case STOP_WFI: fall_asleep(cpu, false); return TROUBLE_NONE;
  case STOP_WFE: wait_for_event(cpu); return TROUBLE_NONE;
  case STOP_SEV: cpu->exceptions.event = 1; return TROUBLE_NONE;
  default: return TROUBLE_NONE;
  }
}

/* A fault has been recorded, and the core is not locked up: the cycles of its step pass. */
HIL_EXPORT void hil_pay(struct hil_cpu *cpu) {
  add_cycles(&cpu->state, cpu->exceptions.owed);
  cpu->exceptions.owed = 0;
}

/* Sleep up to the next tick or event, or the limit. */
static void sleep_on(struct hil_state *state) {
  uint64_t next = state->alarm < state->due ? state->alarm : state->due;
  add_cycles(state, (next < state->limit_cycle ? next : state->limit_cycle) - state->cycle);
}

static uint32_t go(struct hil_cpu *cpu, uint64_t limit_cycle, uint64_t instructions) {
  struct hil_state *state = &cpu->state;
  struct hil_exceptions *x = &cpu->exceptions;
  uint64_t last = state->retired + instructions;
  state->limit_cycle = limit_cycle;
  state->counting = 0;
  for (;;) {
    enum hil_trouble trouble = TROUBLE_NONE;
    uint32_t why = STOP_STEP;
    bool in_block = cpu->hooks.hit.in_block;
    if (!in_block && (state->cycle >= state->limit_cycle ||
                      (state->due <= state->cycle && !hil_queue_pass(cpu->queue, state->cycle))))
      return STOP_LIMIT;
    if (x->sleeping) {
      if (hil_wakes(cpu)) {
        hil_wake(cpu);
      } else if (x->scr & SLEEPDEEP) {
        return STOP_WFI;
      } else {
        sleep_on(state);
        continue;
      }
    }
    if (!in_block && hil_can_take(cpu)) {
      trouble = hil_take(cpu);
    } else {
      if (!in_block && state->retired >= last)
        return STOP_PAUSE;
      state->until_unmasked = x->best_priority < x->active_priority;
      why = hil_run(cpu, state->limit_cycle, last - state->retired);
      if (why == STOP_FAULT || why == STOP_BREAKPOINT || why == STOP_HIT)
        return why;
      trouble = hil_act(cpu, why, state->stop_value);
      if (!trouble && (state->counting || state->skip == LOOK_ONCE))
        return STOP_PAUSE;
    }
    if (trouble) {
      state->stop_value = trouble;
      return STOP_TROUBLE;
    }
    if (x->by_steps && why != STOP_LIMIT && why != STOP_PAUSE)
      return STOP_STEP;
  }
}

/* Run as `hil_run` does, take exceptions and return from them, sleep from tick to tick, and let events happen. Stop
 * where the queue is halted. At the limit nothing more is done, not even a step that is due. STOP_WFI: the core sleeps
 * deeply. */
HIL_EXPORT uint32_t hil_go(struct hil_cpu *cpu, uint64_t limit_cycle, uint64_t instructions) {
  uint32_t why = go(cpu, limit_cycle, instructions);
  hil_tell_time(cpu);
  return why;
}
