/* Exceptions: which is pending, enabled and active (nvic.c), how a core enters and leaves them (entry.c), and the timer
 * that makes one of them pending (systick.c).
 *
 * DDI0403 section B1.5. Sets of exceptions have the bit of each exception number; interrupt n is exception 16 + n. */
#ifndef HIL_EXCEPTIONS_H
#define HIL_EXCEPTIONS_H

#include "layout.h"

#include <stdbool.h>

struct hil_cpu;

/* Exception numbers (DDI0403 table B1-4). */
enum {
  NMI = 2, HARD_FAULT = 3, MEM_MANAGE = 4, BUS_FAULT = 5, USAGE_FAULT = 6, SVCALL = 11, DEBUG_MONITOR = 12,
  PENDSV = 14, SYSTICK = 15, FIRST_IRQ = 16,
};

enum { EXCEPTION_WORDS = 8, MOST_EXCEPTIONS = 32 * EXCEPTION_WORDS };

/* The priority of a core that runs no exception: every one may interrupt it. */
enum { IDLE_PRIORITY = 256 };

/* Which step of entry or return comes next; see entry.c. */
enum { STEP_NONE, STEP_ENTER, STEP_LEAVE };

/* Why a step needs somebody who records a fault. The first two may come together. */
enum hil_trouble {
  TROUBLE_NONE,
  TROUBLE_STACK_FLOATS = 1,   /* the code that was interrupted may not use the registers that were stacked */
  TROUBLE_STACK = 2,          /* the frame could not be written */
  TROUBLE_VECTOR = 4,         /* the vector of `best` cannot be read */
  TROUBLE_STATE,              /* the handler's, or the return address is even */
  TROUBLE_NEVER,              /* nothing can be executed there */
  TROUBLE_RETURN,             /* EXC_RETURN, or the exception number in the frame, cannot be */
  TROUBLE_RETURN_FLOATS,      /* nobody may use the registers that are in the frame */
  TROUBLE_UNSTACK,            /* the frame cannot be read */
  TROUBLE_CALL,               /* SVC where the priority does not allow one */
};

/* count: exception numbers there are; 0: this core has no system control space.
 * priority_mask, group_mask: bits of a priority that are implemented, and that decide over preemption (PRIGROUP).
 * best, best_priority: the pending and enabled exception that goes first, or 0, and its group priority.
 * active_priority: the most urgent group priority of the active exceptions.
 * event, event_on_pend: the event register of WFE, and SCR.SEVONPEND.
 * sleeping, for_event: stopped by WFI, SLEEPONEXIT or WFE; by WFE.
 * locked_up: nothing is executed or taken any more.
 * step, exc_return: of the entry or return that has begun.
 * owed: cycles that pass when the faults of a trouble have been recorded.
 * by_steps: `hil_go` ends after each step. began: since this was last cleared, an exception began or was gone back to.
 * open_faults: those of the exceptions 0 to 31 that a fault began and that have not returned.
 * vtor, ccr, scr, fpccr, fpcar, fpdscr: registers, as a program reads them.
 * last_fpscr: FPSCR when the last floating-point context ended.
 * pending, enabled, active, high: sets; high is the level of interrupt lines.
 * priorities: as configured, by exception number. */
#define HIL_EXCEPTIONS_FIELDS(ONE, MANY) \
    ONE(uint32_t, count) ONE(uint32_t, priority_mask) ONE(int32_t, group_mask) \
    ONE(uint32_t, best) ONE(int32_t, best_priority) ONE(int32_t, active_priority) \
    ONE(uint32_t, event) ONE(uint32_t, event_on_pend) \
    ONE(uint32_t, sleeping) ONE(uint32_t, for_event) ONE(uint32_t, locked_up) \
    ONE(uint32_t, step) ONE(uint32_t, exc_return) ONE(uint32_t, owed) \
    ONE(uint32_t, by_steps) ONE(uint32_t, began) ONE(uint32_t, open_faults) \
    ONE(uint32_t, vtor) ONE(uint32_t, ccr) ONE(uint32_t, scr) \
    ONE(uint32_t, fpccr) ONE(uint32_t, fpcar) ONE(uint32_t, fpdscr) ONE(uint32_t, last_fpscr) \
    MANY(uint32_t, pending, 8) MANY(uint32_t, enabled, 8) MANY(uint32_t, active, 8) MANY(uint32_t, high, 8) \
    MANY(int32_t, priorities, 256)
HIL_STRUCT(hil_exceptions, HIL_EXCEPTIONS_FIELDS);

/* ctrl, load: registers, without COUNTFLAG.
 * value, start: the counter had that value from that cycle on.
 * flag: COUNTFLAG, in its place.
 * held: the clock stands still.
 * cleared: the cycle at which a reload became due, by VAL or a start, unless it is taken. */
#define HIL_SYSTICK_FIELDS(ONE, MANY) \
    ONE(uint64_t, start) ONE(uint64_t, cleared) \
    ONE(uint32_t, ctrl) ONE(uint32_t, load) ONE(uint32_t, value) ONE(uint32_t, flag) ONE(uint32_t, held)
HIL_STRUCT(hil_systick, HIL_SYSTICK_FIELDS);

/* nvic.c; what returns a bool says whether something could be taken now, masks aside, or wake the core. */
void hil_pend(struct hil_cpu *cpu, uint32_t number);
void hil_drive_line(struct hil_cpu *cpu, uint32_t number, uint32_t level);
int32_t hil_boosted_priority(const struct hil_cpu *cpu, bool with_primask);
int32_t hil_execution_priority(const struct hil_cpu *cpu);
int32_t hil_group_priority(const struct hil_exceptions *x, uint32_t number);
void hil_activate(struct hil_cpu *cpu, uint32_t number);
void hil_deactivate(struct hil_cpu *cpu, uint32_t number);
bool hil_scs_read(struct hil_cpu *cpu, uint32_t offset, uint32_t size, uint32_t *value);
bool hil_scs_write(struct hil_cpu *cpu, uint32_t offset, uint32_t size, uint32_t value);

/* systick.c */
void hil_tick(struct hil_cpu *cpu);
bool hil_systick_read(struct hil_cpu *cpu, uint32_t offset, uint32_t *value);
uint32_t hil_systick_lanes(const struct hil_cpu *cpu, uint32_t offset);
bool hil_systick_write(struct hil_cpu *cpu, uint32_t offset, uint32_t value);

/* A frame may put any number into IPSR, up to 511. */
static inline bool hil_in(const uint32_t *set, uint32_t number) {
  return number < MOST_EXCEPTIONS && set[number >> 5] >> (number & 31) & 1;
}

#endif
