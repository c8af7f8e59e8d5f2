/* Which exception is pending, enabled and active, and which of them wins (DDI0403 sections B1.5.4, B3.4).
 *
 * A lower priority is more urgent; its group part decides over preemption, the whole of it over who goes first, and the
 * lower exception number if that is equal. */
#include "cpu.h"

#include <string.h>

enum { ISER = 0x100, ICER = 0x180, ISPR = 0x200, ICPR = 0x280, IABR = 0x300, SETS_END = 0x320, IPR = 0x400, IPR_END = 0x4F0 };
enum { ICSR = 0xD04, STIR = 0xF00 };
enum {
  NMIPENDSET = 1 << 31, PENDSVSET = 1 << 28, PENDSVCLR = 1 << 27, PENDSTSET = 1 << 26, PENDSTCLR = 1 << 25,
  ISRPENDING = 1 << 22, RETTOBASE = 1 << 11,
};

static void include(uint32_t *set, uint32_t number) { set[number >> 5] |= 1u << (number & 31); }
static void exclude(uint32_t *set, uint32_t number) { set[number >> 5] &= ~(1u << (number & 31)); }

static int32_t group(const struct hil_exceptions *x, int32_t priority) {
  return priority < 0 ? priority : priority & x->group_mask;
}

int32_t hil_group_priority(const struct hil_exceptions *x, uint32_t number) { return group(x, x->priorities[number]); }

/* The priority to which the mask registers raise execution (``ExecutionPriority``). */
int32_t hil_boosted_priority(const struct hil_cpu *cpu, bool with_primask) {
  const uint32_t *r = cpu->state.reg;
  if (r[R_FAULTMASK] & 1)
    return -1;
  if (with_primask && r[R_PRIMASK] & 1)
    return 0;
  int32_t basepri = (int32_t)(r[R_BASEPRI] & cpu->exceptions.priority_mask);
  return basepri ? group(&cpu->exceptions, basepri) : IDLE_PRIORITY;
}

int32_t hil_execution_priority(const struct hil_cpu *cpu) {
  int32_t boosted = hil_boosted_priority(cpu, true), active = cpu->exceptions.active_priority;
  return boosted < active ? boosted : active;
}

static void find_best(struct hil_exceptions *x) {
  int32_t best_priority = IDLE_PRIORITY;
  x->best = 0;
  for (uint32_t word = 0; word < EXCEPTION_WORDS; word++)
    for (uint32_t ready = x->pending[word] & x->enabled[word]; ready; ready &= ready - 1) {
      uint32_t number = 32 * word + (uint32_t)__builtin_ctz(ready);
      if (x->priorities[number] < best_priority) {
        x->best = number;
        best_priority = x->priorities[number];
      }
    }
  x->best_priority = group(x, best_priority);
}

static void find_active(struct hil_exceptions *x) {
  int32_t most_urgent = IDLE_PRIORITY;
  for (uint32_t word = 0; word < EXCEPTION_WORDS; word++)
    for (uint32_t active = x->active[word]; active; active &= active - 1) {
      int32_t priority = x->priorities[32 * word + (uint32_t)__builtin_ctz(active)];
      if (priority < most_urgent)
        most_urgent = priority;
    }
  x->active_priority = group(x, most_urgent);
}

/* After a change: who goes first, and whether a running slice must end for that. */
static void refresh(struct hil_cpu *cpu) {
  struct hil_exceptions *x = &cpu->exceptions;
  find_best(x);
  find_active(x);
  if (x->best_priority < x->active_priority)
    cpu->state.attention = cpu->state.changed = 1;
}

/* --- what becomes of one exception */

HIL_EXPORT void hil_pend(struct hil_cpu *cpu, uint32_t number) {
  struct hil_exceptions *x = &cpu->exceptions;
  if (hil_in(x->pending, number))
    return;
  include(x->pending, number);
  x->event |= x->event_on_pend;
  refresh(cpu);
}

/* An inactive interrupt whose line is high stays pending. */
HIL_EXPORT void hil_unpend(struct hil_cpu *cpu, uint32_t number) {
  struct hil_exceptions *x = &cpu->exceptions;
  if (!hil_in(x->high, number) || hil_in(x->active, number))
    exclude(x->pending, number);
  refresh(cpu);
}

HIL_EXPORT void hil_enable(struct hil_cpu *cpu, uint32_t number) {
  include(cpu->exceptions.enabled, number);
  refresh(cpu);
}

/* What is active stays so. */
HIL_EXPORT void hil_disable(struct hil_cpu *cpu, uint32_t number) {
  exclude(cpu->exceptions.enabled, number);
  refresh(cpu);
}

/* As a write to SHCSR does, without consequences. */
HIL_EXPORT void hil_set_active(struct hil_cpu *cpu, uint32_t number, uint32_t active) {
  (active ? include : exclude)(cpu->exceptions.active, number);
  refresh(cpu);
}

void hil_activate(struct hil_cpu *cpu, uint32_t number) {
  exclude(cpu->exceptions.pending, number);
  include(cpu->exceptions.active, number);
  refresh(cpu);
}

/* An interrupt whose line is still high becomes pending again. */
void hil_deactivate(struct hil_cpu *cpu, uint32_t number) {
  if (number >= MOST_EXCEPTIONS)
    return;
  exclude(cpu->exceptions.active, number);
  if (hil_in(cpu->exceptions.high, number))
    hil_pend(cpu, number);
  refresh(cpu);
}

/* The level of an interrupt line: its rising edge makes the interrupt pending, a falling one leaves it so. */
HIL_EXPORT void hil_drive_line(struct hil_cpu *cpu, uint32_t number, uint32_t level) {
  (level ? include : exclude)(cpu->exceptions.high, number);
  if (level)
    hil_pend(cpu, number);
}

/* Bits that are not implemented read as zero. */
HIL_EXPORT void hil_set_priority(struct hil_cpu *cpu, uint32_t number, uint32_t priority) {
  cpu->exceptions.priorities[number] = (int32_t)(priority & cpu->exceptions.priority_mask);
  refresh(cpu);
}

/* Split priorities at a bit, 0 to 7: the bits above it are the group (table B1-6). */
HIL_EXPORT void hil_set_grouping(struct hil_cpu *cpu, uint32_t prigroup) {
  cpu->exceptions.group_mask = -(2 << prigroup);
  refresh(cpu);
}

/* The state after reset: nothing pending, whatever the lines are, for their peripherals are reset too. Sleep, lockup
 * and steps end. */
HIL_EXPORT void hil_reset_exceptions(struct hil_cpu *cpu) {
  static const uint32_t ALWAYS[] = {NMI, HARD_FAULT, SVCALL, PENDSV, SYSTICK};
  struct hil_exceptions *x = &cpu->exceptions;
  hil_begin_elsewhere(&cpu->hooks);
  memset(x->pending, 0, sizeof x->pending);
  memset(x->enabled, 0, sizeof x->enabled);
  memset(x->active, 0, sizeof x->active);
  memset(x->priorities, 0, sizeof x->priorities);
  for (uint32_t n = 0; n < sizeof ALWAYS / sizeof *ALWAYS; n++)
    include(x->enabled, ALWAYS[n]);
  for (int32_t number = 1; number <= HARD_FAULT; number++)
    x->priorities[number] = number - 4;
  x->event = x->event_on_pend = 0;
  x->sleeping = x->for_event = x->locked_up = x->open_faults = 0;
  x->step = STEP_NONE;
  hil_set_grouping(cpu, 0);
}

/* Say how many interrupts there are, and how many bits of a priority. */
HIL_EXPORT void hil_set_up_exceptions(struct hil_cpu *cpu, uint32_t irq_count, uint32_t priority_bits) {
  cpu->exceptions.count = FIRST_IRQ + irq_count;
  cpu->exceptions.priority_mask = 0xFF00 >> priority_bits & 0xFF;
  hil_reset_exceptions(cpu);
}

/* --- registers */

/* Word `word` of a set, of interrupts alone: those begin in the middle of a word. */
static uint32_t interrupts(const uint32_t *set, uint32_t word) {
  return set[word] >> FIRST_IRQ | (word + 1 < EXCEPTION_WORDS ? set[word + 1] << (32 - FIRST_IRQ) : 0);
}

static uint32_t read_icsr(const struct hil_cpu *cpu) {
  const struct hil_exceptions *x = &cpu->exceptions;
  uint32_t value = cpu->state.reg[R_XPSR] & 0x1FF, active = 0, pending = 0;
  for (uint32_t word = 0; word < EXCEPTION_WORDS; word++) {
    active += (uint32_t)__builtin_popcount(x->active[word]);
    pending |= word ? x->pending[word] : x->pending[0] >> FIRST_IRQ;
  }
  if (value && active == hil_in(x->active, value))
    value |= RETTOBASE;
  if (x->best_priority < hil_boosted_priority(cpu, false))
    value |= x->best << 12;
  return value | (pending ? ISRPENDING : 0) | (hil_in(x->pending, NMI) ? (uint32_t)NMIPENDSET : 0) |
         (hil_in(x->pending, PENDSV) ? PENDSVSET : 0) | (hil_in(x->pending, SYSTICK) ? PENDSTSET : 0);
}

/* Of both at once, setting wins (choice; QEMU too). */
static void write_icsr(struct hil_cpu *cpu, uint32_t value) {
  if (value & PENDSVCLR)
    hil_unpend(cpu, PENDSV);
  if (value & PENDSTCLR)
    hil_unpend(cpu, SYSTICK);
  if (value & (uint32_t)NMIPENDSET)
    hil_pend(cpu, NMI);
  if (value & PENDSVSET)
    hil_pend(cpu, PENDSV);
  if (value & PENDSTSET)
    hil_pend(cpu, SYSTICK);
}

static uint32_t read_priorities(const struct hil_exceptions *x, uint32_t first) {
  uint32_t value = 0;
  for (uint32_t lane = 0; lane < 4 && first + lane < x->count; lane++)
    value |= (uint32_t)x->priorities[first + lane] << 8 * lane;
  return value;
}

static bool is_set(uint32_t offset) { return offset >= ISER && offset < SETS_END && (offset & 0x60) == 0; }

static bool read_word(struct hil_cpu *cpu, uint32_t offset, uint32_t *value) {
  const struct hil_exceptions *x = &cpu->exceptions;
  if (offset == ICSR) {
    *value = read_icsr(cpu);
  } else if (offset >= IPR && offset < IPR_END) {
    *value = read_priorities(x, FIRST_IRQ + offset - IPR);
  } else if (is_set(offset)) {
    const uint32_t *set = offset >= IABR ? x->active : offset < ISPR ? x->enabled : x->pending;
    *value = interrupts(set, offset >> 2 & 7);
  } else {
    return hil_systick_read(cpu, offset, value);
  }
  return true;
}

static void write_set(struct hil_cpu *cpu, uint32_t base, uint32_t first, uint32_t ones) {
  for (; ones; ones &= ones - 1) {
    uint32_t number = first + (uint32_t)__builtin_ctz(ones);
    if (number >= cpu->exceptions.count)
      return;
    switch (base) {
    case ISER: hil_enable(cpu, number); break;
    case ICER: hil_disable(cpu, number); break;
    case ISPR: hil_pend(cpu, number); break;
    case ICPR: hil_unpend(cpu, number); break;
    default: break;
    }
  }
}

static bool write_word(struct hil_cpu *cpu, uint32_t offset, uint32_t value) {
  uint32_t count = cpu->exceptions.count;
  if (offset == ICSR) {
    write_icsr(cpu, value);
  } else if (offset == STIR) {
    if (FIRST_IRQ + (value & 0x1FF) >= count)
      return false;
    hil_pend(cpu, FIRST_IRQ + (value & 0x1FF));
  } else if (offset >= IPR && offset < IPR_END) {
    for (uint32_t lane = 0; lane < 4 && FIRST_IRQ + offset - IPR + lane < count; lane++)
      hil_set_priority(cpu, FIRST_IRQ + offset - IPR + lane, value >> 8 * lane & 0xFF);
  } else if (is_set(offset)) {
    write_set(cpu, offset & ~0x7Fu, FIRST_IRQ + 8 * (offset & 0x1C), value);
  } else {
    return hil_systick_write(cpu, offset, value);
  }
  return true;
}

/* Read 1, 2 or 4 bytes of the system control space; false if it is not for here. */
HIL_EXPORT bool hil_scs_read(struct hil_cpu *cpu, uint32_t offset, uint32_t size, uint32_t *value) {
  if (!read_word(cpu, offset & ~3u, value))
    return false;
  if (size < 4)
    *value = *value >> 8 * (offset & 3) & ((1u << 8 * size) - 1);
  return true;
}

/* Write 1, 2 or 4 bytes; where ones act, the other lanes are zeros. */
HIL_EXPORT bool hil_scs_write(struct hil_cpu *cpu, uint32_t offset, uint32_t size, uint32_t value) {
  uint32_t word = offset & ~3u;
  if (size < 4) {
    uint32_t shift = 8 * (offset & 3), mask = (1u << 8 * size) - 1, others = hil_systick_lanes(cpu, word);
    if (word >= IPR && word < IPR_END)
      read_word(cpu, word, &others);
    value = (others & ~(mask << shift)) | (value & mask) << shift;
  }
  return write_word(cpu, word, value);
}
