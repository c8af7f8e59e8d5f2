/* Breakpoints, watchpoints, edges and accesses to registers; see hooks.h.
 *
 * A run stops before the instruction, which has changed nothing, and is executed when a run begins there again. What
 * is told or written down anew makes a lap one that is not like the next (loops.c): loops with a stop in them, or with
 * something new to write down, are executed. So nothing here depends on which loops are passed over, or how a run is
 * cut. */
#include "operations.h"

#include <string.h>

enum { REPEATED_WITHIN = 8 };

static void decode_all_anew(struct hil_cpu *cpu) {
  for (uint32_t n = 0; n < cpu->region_count; n++)
    if (cpu->regions[n].data)
      hil_forget(cpu, cpu->regions[n].base, cpu->regions[n].size);
}

/* --- what is asked for */

/* Stop before these instructions, and no others. Returns false if there are too many. */
HIL_EXPORT bool hil_set_breakpoints(struct hil_cpu *cpu, const uint32_t *addresses, uint32_t count) {
  struct hil_hooks *hooks = &cpu->hooks;
  if (count > MOST_BREAKPOINTS)
    return false;
  for (uint32_t n = 0; n < hooks->breakpoint_count; n++)
    hil_forget(cpu, hooks->breakpoints[n], 2);
  memcpy(hooks->breakpoints, addresses, count * sizeof *addresses);
  hooks->breakpoint_count = count;
  for (uint32_t n = 0; n < count; n++)
    hil_forget(cpu, addresses[n], 2);
  return true;
}

/* Stop before accesses to these bytes, and no others: address, size, HIT_READ or HIT_WRITE or both, of each. Returns
 * false if there are too many. */
HIL_EXPORT bool hil_set_watchpoints(struct hil_cpu *cpu, const uint32_t *numbers, uint32_t count) {
  struct hil_hooks *hooks = &cpu->hooks;
  if (count > MOST_WATCHPOINTS)
    return false;
  memcpy(hooks->watchpoints, numbers, count * sizeof *hooks->watchpoints);
  hooks->watchpoint_count = count;
  cpu->near[0] = cpu->near[1] = &cpu->nowhere;
  for (uint32_t n = 0; n < cpu->region_count; n++) {
    struct hil_region *region = &cpu->regions[n];
    region->watched = false;
    for (uint32_t at = 0; at < count; at++) {
      uint64_t address = hooks->watchpoints[at].address, end = address + hooks->watchpoints[at].size;
      region->watched |= address < (uint64_t)region->base + region->size && end > region->base;
    }
  }
  return true;
}

/* Count edges into a map, whose size is a power of two; NULL: no more. It must last as long. */
HIL_EXPORT void hil_map_edges(struct hil_cpu *cpu, uint8_t *map, uint32_t size) {
  cpu->hooks.edges = map;
  cpu->hooks.edge_mask = size - 1;
  cpu->hooks.branch = 0;
  decode_all_anew(cpu);
}

/* Write accesses to registers down, as many as there is room for; NULL: no more. It must last as long. */
HIL_EXPORT void hil_log_accesses(struct hil_cpu *cpu, struct hil_access *room, uint32_t most) {
  cpu->hooks.accesses = room;
  cpu->hooks.access_room = room ? most : 0;
  cpu->hooks.access_count = 0;
}

HIL_EXPORT uint32_t hil_accesses_logged(const struct hil_cpu *cpu) { return cpu->hooks.access_count; }

/* Where the last run has stopped. */
HIL_EXPORT const struct hil_hit *hil_hit_of(const struct hil_cpu *cpu) { return &cpu->hooks.hit; }

/* --- stops */

/* What comes next was not led to by an instruction: an exception, the return from one, a reset. */
void hil_begin_elsewhere(struct hil_hooks *hooks) { hooks->branch = hooks->passed = hooks->hit.in_block = 0; }

/* Whether to stop before the instruction in flight, of which the state tells; a second time it is passed. */
static bool stops(struct hil_cpu *cpu, uint32_t kind) {
  struct hil_hooks *hooks = &cpu->hooks;
  const struct hil_state *state = &cpu->state;
  if (hooks->passed_at != state->retired || hooks->passed_pc != state->reg[R_PC])
    hooks->passed = 0;
  cpu->look.told = true;
  if (hooks->passed & kind)
    return false;
  hooks->passed_at = state->retired;
  hooks->passed_pc = state->reg[R_PC];
  hooks->passed |= kind;
  hooks->branch = 0; /* the edge that led here has been counted */
  hooks->hit = (struct hil_hit){.kind = kind, .pc = state->reg[R_PC]};
  hooks->hit.in_block = (state->reg[R_XPSR] & 0x0600FC00) != 0;
  return true;
}

bool hil_breaks(struct hil_cpu *cpu) {
  if (!stops(cpu, HIT_BREAKPOINT))
    return false;
  cpu->hooks.hit.address = cpu->hooks.hit.pc;
  return true;
}

/* Before an access of the instruction in flight to so many bytes; `stored`: the words that it is about to write. */
bool hil_watch_stops(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t kind, const uint32_t *stored) {
  struct hil_hooks *hooks = &cpu->hooks;
  uint32_t first = UINT32_MAX;
  for (uint32_t n = 0; n < hooks->watchpoint_count; n++) {
    uint64_t begin = hooks->watchpoints[n].address, end = begin + hooks->watchpoints[n].size;
    if (hooks->watchpoints[n].kinds & kind && begin < (uint64_t)address + size && end > address) {
      uint32_t offset = begin > address ? (uint32_t)begin - address : 0;
      first = offset < first ? offset : first;
    }
  }
  if (first == UINT32_MAX || !stops(cpu, kind))
    return false;
  struct hil_hit *hit = &hooks->hit;
  uint32_t word = size > 4 ? first / 4 : 0;
  hit->address = address + 4 * word;
  hit->size = size > 4 ? 4 : size;
  hit->known = stored || hil_peek_memory(cpu, hit->address, hit->size, &hit->value) == ACCESS_DONE;
  if (stored)
    hit->value = hit->size < 4 ? stored[word] & ((1u << 8 * hit->size) - 1) : stored[word];
  return true;
}

/* --- edges */

static bool may_branch(const struct hil_op *op) {
  switch (op->real) {
  case OP_BX: case OP_BLX: case OP_BL: case OP_CBZ: case OP_CBNZ: case OP_TBB: case OP_TBH:
  case OP_LDR_PC: case OP_LDR_PC_LITERAL:
    return true;
  case OP_ADD_HIGH: case OP_MOV_HIGH: return op->a == R_PC;
  case OP_LDM: return op->imm >> R_PC & 1;
  default: return op->real >= OP_B && op->real <= OP_BLE;
  }
}

/* An instruction has been decoded: let it be stopped at, or counted. */
void hil_hook(struct hil_cpu *cpu, uint32_t pc, struct hil_op *op) {
  const struct hil_hooks *hooks = &cpu->hooks;
  bool counted = hooks->edges;
  for (uint32_t n = 0; n < hooks->breakpoint_count; n++)
    if (hooks->breakpoints[n] == pc)
      op->flags |= OP_BREAKS;
  if (counted && may_branch(op))
    op->flags |= OP_BRANCHES;
  if (counted || op->flags & OP_BREAKS)
    op->code = OP_HOOK;
}

/* Spread what differs in the lower bits of an address over all (Knuth, section 6.4). */
static uint32_t spread(uint32_t address) { return (address >> 1) * 2654435761u >> 8; }

/* Before an instruction is executed: count how it was come to, if that was by one that may branch. A count stays at
 * 255. */
void hil_count_edge(struct hil_cpu *cpu, const struct hil_op *op, uint32_t pc) {
  struct hil_hooks *hooks = &cpu->hooks;
  if (!hooks->edges)
    return;
  if (hooks->branch) {
    uint8_t *count = &hooks->edges[(spread(hooks->branch) >> 1 ^ spread(pc)) & hooks->edge_mask];
    if (*count < UINT8_MAX) {
      ++*count;
      cpu->look.told = true;
    }
  }
  hooks->branch = op->flags & OP_BRANCHES ? pc | 1 : 0;
}

/* --- accesses */

static bool is_repeated(const struct hil_hooks *hooks, uint32_t address, uint32_t size, uint32_t value, uint32_t pc) {
  for (uint32_t n = 1; n <= REPEATED_WITHIN && n <= hooks->access_count; n++) {
    const struct hil_access *last = &hooks->accesses[hooks->access_count - n];
    if (last->address == address)
      return !last->writes && last->size == size && last->value == value && last->pc == pc;
  }
  return false;
}

/* A register was read or written. A read is left out that is the same as the last access to that register: by the same
 * instruction, with the same value; of the last accesses written down, that is. */
void hil_note_access(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t value, bool writes) {
  struct hil_hooks *hooks = &cpu->hooks;
  uint32_t pc = cpu->state.reg[R_PC];
  if (hooks->access_count == hooks->access_room || (!writes && is_repeated(hooks, address, size, value, pc)))
    return;
  hooks->accesses[hooks->access_count++] = (struct hil_access){
      .cycle = cpu->state.cycle, .pc = pc, .address = address, .value = value, .size = size, .writes = writes};
  cpu->look.told = true;
}
