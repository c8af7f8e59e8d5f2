/* What somebody wants to know of a program while it runs: breakpoints, watchpoints, edges of the control flow, accesses
 * to registers. None of it costs anything unless it is asked for, and none changes what a program does, or when.
 *
 * A breakpoint, and an instruction whose edges are counted, is decoded to OP_HOOK; memory that is watched is never
 * `near` (cpu.h); registers are reached by memory.c alone. */
#ifndef HIL_HOOKS_H
#define HIL_HOOKS_H

#include "layout.h"

#include <stdbool.h>

enum { MOST_BREAKPOINTS = 256, MOST_WATCHPOINTS = 64 };

/* What a run has stopped for, and what a watchpoint is for: READ + WRITE is both. */
enum { HIT_READ = 1, HIT_WRITE = 2, HIT_BREAKPOINT = 4 };

/* Where a run stopped, before the instruction at `pc`.
 *
 * kind: one of HIT_; 0: it did not.
 * address, size: of the access, of several words the first that is watched; for a breakpoint, that of the instruction.
 * value, known: what is to be written, or stands in the memory that is to be read; a register is not read for that.
 * in_block: an IT block has begun, and nothing may come between this instruction and those before it. */
#define HIL_HIT_FIELDS(ONE, MANY) \
    ONE(uint32_t, kind) ONE(uint32_t, pc) ONE(uint32_t, address) ONE(uint32_t, size) \
    ONE(uint32_t, value) ONE(uint32_t, known) ONE(uint32_t, in_block)
HIL_STRUCT(hil_hit, HIL_HIT_FIELDS);

/* An access of the program to a register: the cycle at which its instruction began, the instruction, 1, 2 or 4 bytes. */
#define HIL_ACCESS_FIELDS(ONE, MANY) \
    ONE(uint64_t, cycle) ONE(uint32_t, pc) ONE(uint32_t, address) ONE(uint32_t, value) ONE(uint32_t, size) \
    ONE(uint32_t, writes)
HIL_STRUCT(hil_access, HIL_ACCESS_FIELDS);

struct hil_hooks {
  struct hil_hit hit;
  uint64_t passed_at;         /* the instruction before which a run stopped: how many had retired, */
  uint32_t passed_pc;         /* where it stands, */
  uint32_t passed;            /* and for what: it does not stop there for that again */
  uint32_t breakpoint_count, watchpoint_count;
  uint32_t breakpoints[MOST_BREAKPOINTS];
  struct {
    uint32_t address, size, kinds;
  } watchpoints[MOST_WATCHPOINTS];
  uint8_t *edges;             /* NULL: nobody counts them */
  uint32_t edge_mask;
  uint32_t branch;            /* the last instruction, if it may branch: its address + 1; else 0 */
  struct hil_access *accesses; /* NULL: nobody writes them down */
  uint32_t access_room, access_count;
};

struct hil_cpu;
struct hil_op;

void hil_hook(struct hil_cpu *cpu, uint32_t pc, struct hil_op *op);
bool hil_breaks(struct hil_cpu *cpu);
bool hil_watch_stops(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t kind, const uint32_t *stored);
void hil_count_edge(struct hil_cpu *cpu, const struct hil_op *op, uint32_t pc);
void hil_note_access(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t value, bool writes);
void hil_begin_elsewhere(struct hil_hooks *hooks);

#endif
