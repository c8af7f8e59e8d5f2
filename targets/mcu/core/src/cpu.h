/* A Cortex-M core: registers, memory and instructions (DDI0403, chapters A2 to A7), and exceptions (exceptions.h).
 *
 * `hil_run` executes instructions alone, `hil_go` takes exceptions too. What faults become is for the caller.
 *
 * All state that a caller may see or change stands in `struct hil_state`; there are no globals. Addresses are those of
 * the emulated chip; the host is little-endian, as the core is. */
#ifndef HIL_CPU_H
#define HIL_CPU_H

#include "block.h"
#include "exceptions.h"
#include "hooks.h"
#include "layout.h"
#include "queue.h"

#include <stdbool.h>
#include <stddef.h>

#if defined(__GNUC__)
#define LIKELY(condition) __builtin_expect(!!(condition), 1)
#define UNLIKELY(condition) __builtin_expect(!!(condition), 0)
#else
#error "gcc or clang is needed: labels as values, 128-bit integers"
#endif

enum {
  R_SP = 13, R_LR = 14, R_PC = 15, R_XPSR = 16, R_MSP = 17, R_PSP = 18,
  R_PRIMASK = 19, R_BASEPRI = 20, R_FAULTMASK = 21, R_CONTROL = 22, REGISTERS = 23,
};

enum { FLOATS = 33, FPSCR = 32 };

/* Why a run ended; the numbers are those of `StopKind` in engine/api.py, in its order. STOP_PAUSE: before its limit. */
enum hil_stop {
  STOP_LIMIT, STOP_WFI, STOP_WFE, STOP_SEV, STOP_SVC, STOP_BREAKPOINT, STOP_EXCEPTION_RETURN, STOP_FAULT,
  STOP_TROUBLE, STOP_STEP, STOP_HIT, STOP_PAUSE,
};

/* What an instruction could not do; in the order of `FaultKind`. */
enum hil_fault {
  FAULT_READ, FAULT_WRITE, FAULT_FETCH, FAULT_UNDEFINED, FAULT_STATE, FAULT_DIVISION, FAULT_UNALIGNED, NO_FAULT = -1,
};

/* Called for an access that is not memory's: its window, the offset in it and 1, 2 or 4 bytes. */
typedef uint32_t (*hil_read)(uint32_t window, uint32_t offset, uint32_t size);
typedef void (*hil_write)(uint32_t window, uint32_t offset, uint32_t size, uint32_t value);

/* Everything that is read or set from outside, between two runs and within an access to a register.
 *
 * cycle, retired: time, of the next instruction or of the one in flight.
 * limit_cycle, limit_retired: a run ends at the first boundary at or after either; set by `hil_run`, and lowered from
 *   within an access, which then sets `changed`.
 * alarm: the same for the next cycle at which something is to be done here; set by what does it (systick.c).
 * due: the same for the next event; set by the queue.
 * base, since, numerator, denominator: timing model "flat": instruction number `since` began at cycle `base`, and each
 *   takes numerator / denominator cycles.
 * table, refill, wait_states: timing model "table": whether it is that; the refill comes with every branch taken, wait
 *   states on top of that and of loads of constants.
 * until_unmasked: a run ends after an instruction that may take an interrupt mask away.
 * trap_division, trap_unaligned: as in CCR.
 * float_access: CPACR.CP10: 0 nobody, 1 privileged, 3 everybody.
 * refused: set within an access: it fails.
 * changed: set within an access: so were limits or timing.
 * attention: an exception has become more urgent than what runs, masks aside: a slice ends. Since it last began.
 * through_python: every access to registers goes by `hil_read`, also to those that C knows.
 * writes, block_writes: how many registers of the system control space, and of blocks in C, were written without
 *   `hil_write`.
 * polled, polls: the register beside the core that was read last, and how often in a row before. polls_wanted: after so
 *   many a loop is looked for at once, and `polled_often` is set.
 * running: a run is on.
 * stop_value: of SVC and BKPT; EXC_RETURN; a trouble.
 * fault, fault_address: of STOP_FAULT.
 * exclusive, exclusive_address: what LDREX marked.
 * skip: how loops that change nothing are taken; see loops.c. look_at, look_wait: the instruction before which one is
 *   looked for next, and how many lie between two looks.
 * looking: a look is on; an access to a register that may give something else the next time sets `live`.
 * loop_pc, loop_instructions: the loop that the last look found, an instruction of it and how many it has; 0: none.
 * lap, loop_lap: the number of the lap that is looked at, of all, and of the one that was the loop.
 * counting: the run ended within a loop that reads such registers.
 * reg: SP is the one in use at the end of a run; MSP and PSP count.
 * floats: S0 to S31 and FPSCR. */
#define HIL_STATE_FIELDS(ONE, MANY) \
    ONE(uint64_t, cycle) ONE(uint64_t, retired) \
    ONE(uint64_t, limit_cycle) ONE(uint64_t, limit_retired) ONE(uint64_t, alarm) ONE(uint64_t, due) \
    ONE(uint64_t, base) ONE(uint64_t, since) ONE(uint64_t, numerator) ONE(uint64_t, denominator) \
    ONE(uint32_t, table) ONE(uint32_t, refill) ONE(uint32_t, wait_states) \
    ONE(uint32_t, until_unmasked) \
    ONE(uint32_t, trap_division) ONE(uint32_t, trap_unaligned) \
    ONE(uint32_t, float_access) ONE(uint32_t, attention) ONE(uint32_t, through_python) \
    ONE(uint32_t, writes) ONE(uint32_t, block_writes) \
    ONE(uint32_t, polled) ONE(uint32_t, polls) ONE(uint32_t, polls_wanted) ONE(uint32_t, polled_often) \
    ONE(uint32_t, refused) ONE(uint32_t, changed) ONE(uint32_t, running) \
    ONE(uint32_t, stop_value) ONE(int32_t, fault) ONE(uint32_t, fault_address) \
    ONE(uint32_t, exclusive) ONE(uint32_t, exclusive_address) \
    ONE(uint64_t, look_at) ONE(uint32_t, look_wait) ONE(uint32_t, skip) \
    ONE(uint32_t, looking) ONE(uint32_t, live) ONE(uint32_t, counting) \
    ONE(uint32_t, loop_pc) ONE(uint32_t, loop_instructions) ONE(uint32_t, lap) ONE(uint32_t, loop_lap) \
    MANY(uint32_t, reg, 23) \
    MANY(uint32_t, floats, 33)
HIL_STRUCT(hil_state, HIL_STATE_FIELDS);

/* A decoded instruction. */
struct hil_op {
  int32_t jump;               /* to what executes `code`, in run.c */
  uint32_t imm;
  uint32_t raw;               /* as it stands in memory; the second half above the first */
  uint8_t a, b, c, d;         /* registers, mostly destination, first, second operand, other */
  uint32_t cost;              /* cycles times HIL_UNIT, less one */
  uint8_t halves;             /* its length */
  uint8_t flags;
  uint8_t e;
  uint16_t code;              /* what to do; see isa.h */
  uint16_t real;              /* what it is, where `code` is something to be done before */
  uint32_t room;              /* a power of two is found faster */
};

/* Cycles and instructions are counted in one number: down by the cycles in its upper bits, up by one below. */
#define HIL_UNIT (1u << 24)

enum {
  OP_NARROW = 1,              /* sets the flags outside of an IT block only: `code` + 1 is the same without */
  OP_WRITES_BACK = 2,
  OP_ALIGNS_SP = 4,           /* in writable memory, and with OP_HOOK: to be executed as OP_TO_SP does */
  OP_BREAKS = 8,              /* a breakpoint */
  OP_BRANCHES = 16,           /* where edges are counted: it may branch */
};

struct hil_region {
  uint32_t base, size;
  uint8_t *data;              /* NULL: registers */
  struct hil_op *ops;         /* one for each half-word and one for the end; NULL until something is executed */
  uint8_t *executed;          /* see coverage.c; NULL: nobody wants to know */
  bool writable;
  bool watched;               /* a watchpoint is there */
};

enum { MOST_REGIONS = 64, MOST_BLOCKS = 32 };

/* What was when a look began, and what has been stored since; see loops.c. */
enum { MOST_STORES = 64 };

struct hil_look {
  struct hil_state before;
  uint32_t steps, laps;
  uint32_t store_count;
  bool dirty;                 /* registers were written, limits or timing changed, or more stored than is kept */
  bool told;                  /* a hook has had something to tell in this lap */
  struct {
    uint8_t *place;
    uint32_t size, value;
  } stores[MOST_STORES];
};

struct hil_decoder;

struct hil_cpu {
  struct hil_state state;
  struct hil_exceptions exceptions;
  struct hil_systick systick;
  struct hil_region regions[MOST_REGIONS];
  uint32_t region_count;
  struct hil_region nowhere;
  struct hil_block *blocks[MOST_BLOCKS];
  uint32_t block_count;
  struct hil_region *near[2]; /* memory that was accessed last: writable, and read-only */
  struct hil_look look;
  struct hil_hooks hooks;
  struct hil_queue *queue;    /* NULL: nothing happens but in the core */
  bool executing;             /* within `hil_run`, also where `running` says that an instruction has ended */
  hil_read read;
  hil_write write;
  struct hil_decoder *decoder;
  bool has_dsp, has_float, is_m7;
  uint32_t basepri_bits;
};

/* decode.c */
struct hil_decoder *hil_decoder_new(bool has_dsp, bool has_float, bool is_m7);
void hil_decoder_free(struct hil_decoder *decoder);
void hil_decode(const struct hil_cpu *cpu, uint32_t address, uint32_t raw, bool in_writable, struct hil_op *op);
bool hil_is_wide(uint32_t first);

/* Somebody else is about to ask what time it is. */
static inline void hil_tell_time(struct hil_cpu *cpu) {
  if (cpu->queue)
    hil_time_of(cpu->queue)->now = cpu->state.cycle;
}

/* memory.c: how an access went, or a fault. */
enum { ACCESS_DONE = -1, ACCESS_REGISTERS = -2, ACCESS_HIT = -3 };
/* The window of `hil_write` for stores into read-only memory; the offset is their address. */
#define HIL_READ_ONLY UINT32_MAX

struct hil_region *hil_region_at(struct hil_cpu *cpu, uint32_t address);
int hil_peek_memory(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t *value);
int hil_poke_memory(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t value);
int hil_load_memory(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t *value);
int hil_store_memory(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t value);
int hil_load_register(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t *value);
int hil_store_register(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t value, uint32_t cost);
int hil_store_beside(struct hil_cpu *cpu, uint32_t address, uint32_t value);
bool hil_master_load(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t *value);
bool hil_master_store(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t value);
uint32_t hil_fetch(struct hil_cpu *cpu, const struct hil_region *region, uint32_t address, bool *complete);

/* cpu.c */
void hil_forget(struct hil_cpu *cpu, uint32_t base, uint32_t size);

/* coverage.c */
void hil_remember(struct hil_region *region, size_t first, size_t last);

/* loops.c */
enum hil_skip { SKIP_NOTHING, SKIP_LOOPS, LOOK_ONCE };
enum hil_lap { LAP_GOES_ON, LAP_SAME, LAP_COUNTS, LAP_GIVEN_UP };

enum { HIL_FIRST_WAIT = 160 };

void hil_look_from(struct hil_state *state);
void hil_look_begin(struct hil_cpu *cpu);
bool hil_look_begins(struct hil_cpu *cpu);
void hil_look_store(struct hil_cpu *cpu, uint8_t *place, uint32_t size);
enum hil_lap hil_look_step(struct hil_cpu *cpu, bool at_start);
void hil_look_end(struct hil_cpu *cpu, enum hil_lap lap);
bool hil_look_goes_on(struct hil_cpu *cpu, enum hil_lap lap);

static inline uint32_t hil_rotated(uint32_t value, uint32_t by) {
  return by ? value >> by | value << (32 - by) : value;
}

/* special.c */
bool hil_uses_psp(const struct hil_state *state);
bool hil_is_privileged(const struct hil_state *state);
uint32_t hil_read_special(const struct hil_cpu *cpu, uint32_t number);
bool hil_write_special(struct hil_cpu *cpu, uint32_t number, uint32_t mask, uint32_t value);
bool hil_change_masks(struct hil_cpu *cpu, uint32_t bits);

/* entry.c */
void hil_begin_floats(struct hil_cpu *cpu);

/* run.c */
uint32_t hil_run(struct hil_cpu *cpu, uint64_t limit_cycle, uint64_t instructions);

#endif
