/* The SysTick timer (DDI0403 section B3.3, PM0056 section 4.5), exact to the cycle.
 *
 * The counter steps once per clock: from zero to the reload value, from anything else down by one. Arriving at zero
 * from one sets COUNTFLAG and, with TICKINT, makes the exception pending. So a reload value of N gives a period of
 * N + 1, a reload value of zero stops at zero, and enabling does not itself reload: it goes on from the value there is.
 *
 * The clock is HCLK, or HCLK/8 from a divider that runs on its own (choice: it steps at multiples of eight cycles since
 * the chip was made, whenever the timer starts; in QEMU a period of the reference begins with each start, which a clock
 * that others share cannot do). Both divide HCLK, so a change of the clock needs no care here. The value is computed
 * when it is read; the next arrival at zero that anybody could notice is `alarm`, at which every run ends.
 *
 * In silicon no two stores come to it in one cycle; with less than a cycle for an instruction they do here. A LOAD
 * written in the cycle in which VAL was cleared, or in which the timer started at zero, then comes after the reload
 * from the LOAD before it, as the program has it. */
#include "cpu.h"

enum { CTRL = 0x10, LOAD = 0x14, VAL = 0x18 };
enum { ENABLE = 1, TICKINT = 2, CLKSOURCE = 4, COUNTFLAG = 1 << 16, WIDTH = 0x00FFFFFF };
enum { REFERENCE_DIVIDER = 8 };

static bool counts(const struct hil_systick *timer) { return timer->ctrl & ENABLE && !timer->held; }

/* How often the counter has stepped from `start` to a cycle, which may be the one before it. */
static uint64_t steps_at(const struct hil_systick *timer, uint64_t cycle) {
  uint64_t divider = timer->ctrl & CLKSOURCE ? 1 : REFERENCE_DIVIDER;
  uint64_t now = cycle / divider, start = timer->start / divider;
  return now > start ? now - start : 0;
}

/* The cycle at which the counter has stepped so often; for 0 one not after `start`. */
static uint64_t cycle_of(const struct hil_systick *timer, uint64_t steps) {
  uint64_t divider = timer->ctrl & CLKSOURCE ? 1 : REFERENCE_DIVIDER;
  return (timer->start / divider + steps) * divider;
}

static uint32_t value_at(const struct hil_systick *timer, uint64_t cycle) {
  uint64_t steps = counts(timer) ? steps_at(timer, cycle) : 0;
  if (steps <= timer->value)
    return timer->value - (uint32_t)steps;
  return timer->load - (uint32_t)((steps - timer->value - 1) % (timer->load + 1));
}

/* Find the next arrival at zero after a cycle, if anybody could notice it. */
static void plan(struct hil_cpu *cpu, uint64_t cycle) {
  const struct hil_systick *timer = &cpu->systick;
  uint64_t before = cpu->state.alarm, steps = steps_at(timer, cycle), period = timer->load + 1;
  cpu->state.alarm = UINT64_MAX;
  if (counts(timer) && (!timer->flag || timer->ctrl & TICKINT)) {
    if (timer->value > steps)
      cpu->state.alarm = cycle_of(timer, timer->value);
    else if (period > 1)
      cpu->state.alarm = cycle_of(timer, timer->value + ((steps - timer->value) / period + 1) * period);
  }
  if (cpu->state.alarm != before)
    cpu->state.changed = 1;
}

/* Let every arrival at zero happen that is due. */
HIL_EXPORT void hil_tick(struct hil_cpu *cpu) {
  struct hil_systick *timer = &cpu->systick;
  while (cpu->state.alarm <= cpu->state.cycle) {
    timer->value = 0;
    timer->start = cpu->state.alarm;
    timer->flag = COUNTFLAG;
    cpu->state.loop_instructions = 0; /* the program may go elsewhere */
    if (timer->ctrl & TICKINT)
      hil_pend(cpu, SYSTICK);
    plan(cpu, timer->start);
  }
}

/* Make the present value the one to count on from, after what was due, which may come late within an IT block. */
static void settle(struct hil_cpu *cpu) {
  struct hil_systick *timer = &cpu->systick;
  uint64_t now = cpu->state.cycle;
  hil_tick(cpu);
  if (timer->start < now) {
    timer->value = value_at(timer, now);
    timer->start = now;
  }
}

/* Let the clock stand still, as in Stop mode, or run again; the counter keeps its value. */
HIL_EXPORT void hil_hold_systick(struct hil_cpu *cpu, uint32_t held) {
  settle(cpu);
  cpu->systick.held = held;
  plan(cpu, cpu->state.cycle);
}

/* Stop, with all registers zero; that LOAD and VAL are, which silicon leaves unknown, is a choice; QEMU too. */
HIL_EXPORT void hil_reset_systick(struct hil_cpu *cpu) {
  struct hil_systick *timer = &cpu->systick;
  timer->ctrl = timer->load = timer->value = timer->flag = timer->held = 0;
  plan(cpu, cpu->state.cycle);
}

/* How VAL counts down from now on: from a value that it had at a cycle, by one in so many cycles, until another; false
 * if it stands, or is not known. */
HIL_EXPORT bool hil_systick_count(const struct hil_cpu *cpu, uint32_t *value, uint32_t *divider, uint64_t *origin,
                                  uint64_t *until) {
  const struct hil_systick *timer = &cpu->systick;
  uint64_t now = cpu->state.cycle, steps = steps_at(timer, now), first = 0;
  if (!counts(timer) || timer->start > now)
    return false;
  *value = timer->value;
  if (steps > timer->value) { /* it was reloaded since */
    *value = timer->load;
    first = timer->value + 1 + (steps - timer->value - 1) / (timer->load + 1ull) * (timer->load + 1ull);
  }
  *divider = timer->ctrl & CLKSOURCE ? 1 : REFERENCE_DIVIDER;
  *origin = cycle_of(timer, first);
  *until = cycle_of(timer, first + *value + 1);
  return true;
}

/* --- registers */

/* Reading CTRL clears COUNTFLAG. */
bool hil_systick_read(struct hil_cpu *cpu, uint32_t offset, uint32_t *value) {
  struct hil_systick *timer = &cpu->systick;
  switch (offset) {
  case CTRL:
    hil_tick(cpu);
    *value = timer->ctrl | timer->flag;
    timer->flag = 0;
    plan(cpu, cpu->state.cycle);
    return true;
  case LOAD: *value = timer->load; return true;
  case VAL: *value = value_at(timer, cpu->state.cycle); return true;
  default: return false;
  }
}

/* What the lanes keep that are not written. */
HIL_EXPORT uint32_t hil_systick_lanes(const struct hil_cpu *cpu, uint32_t offset) {
  return offset == CTRL ? cpu->systick.ctrl : offset == LOAD ? cpu->systick.load : 0;
}

/* A start keeps the counter. A new LOAD takes effect when the counter is next reloaded. Whatever is written into VAL
 * clears it and COUNTFLAG, and no exception follows from that. */
bool hil_systick_write(struct hil_cpu *cpu, uint32_t offset, uint32_t value) {
  struct hil_systick *timer = &cpu->systick;
  uint64_t now = cpu->state.cycle;
  if (offset != CTRL && offset != LOAD && offset != VAL)
    return false;
  settle(cpu);
  if (offset == CTRL) {
    bool stood = !counts(timer);
    timer->ctrl = value & (ENABLE | TICKINT | CLKSOURCE);
    if (stood && counts(timer) && !timer->value)
      timer->cleared = now;
  } else if (offset == LOAD) {
    if (timer->cleared == now && counts(timer) && timer->ctrl & CLKSOURCE) {
      timer->value = timer->load;
      timer->start = now + 1;
    }
    timer->cleared = UINT64_MAX;
    timer->load = value & WIDTH;
  } else {
    timer->value = timer->flag = 0;
    timer->start = timer->cleared = now;
  }
  plan(cpu, now);
  return true;
}
