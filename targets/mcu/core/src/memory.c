/* Accesses of the core to memory and registers (DDI0403 sections A3.2, B2.4). */
#include "limits.h"

#include <string.h>

#define SCS 0xE000E000u

struct hil_region *hil_region_at(struct hil_cpu *cpu, uint32_t address) {
  for (uint32_t n = 0; n < cpu->region_count; n++) {
    struct hil_region *region = &cpu->regions[n];
    if (address - region->base < region->size)
      return region;
  }
  return NULL;
}

static struct hil_region *memory_at(struct hil_cpu *cpu, uint32_t address, uint32_t size) {
  struct hil_region *region = hil_region_at(cpu, address);
  if (!region || !region->data || region->size - (address - region->base) < size)
    return NULL;
  if (!cpu->state.looking && !region->watched)
    cpu->near[region->writable ? 0 : 1] = region;
  return region;
}

static int unaligned(struct hil_cpu *cpu, uint32_t address) {
  cpu->state.fault_address = address;
  return FAULT_UNALIGNED;
}

static int load(const struct hil_region *region, uint32_t address, uint32_t size, uint32_t *value) {
  *value = 0;
  memcpy(value, region->data + (address - region->base), size);
  return ACCESS_DONE;
}

static int store(struct hil_cpu *cpu, const struct hil_region *region, uint32_t address, uint32_t size,
                 uint32_t value) {
  uint8_t *place = region->data + (address - region->base);
  if (cpu->state.looking)
    hil_look_store(cpu, place, size);
  memcpy(place, &value, size);
  return ACCESS_DONE;
}

/* Read and write memory without anybody being told; ACCESS_REGISTERS if none is there. */
int hil_peek_memory(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t *value) {
  const struct hil_region *region = memory_at(cpu, address, size);
  return region ? load(region, address, size, value) : ACCESS_REGISTERS;
}

int hil_poke_memory(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t value) {
  const struct hil_region *region = memory_at(cpu, address, size);
  return region && region->writable ? store(cpu, region, address, size, value) : ACCESS_REGISTERS;
}

/* Whether an instruction's access to memory goes the way of those to registers, where somebody looks at it. */
static bool is_watched(const struct hil_cpu *cpu, const struct hil_region *region) {
  return UNLIKELY(region->watched) && cpu->state.running;
}

/* Read memory; ACCESS_REGISTERS if none is there, or it is watched. */
int hil_load_memory(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t *value) {
  if (address & (size - 1) && cpu->state.trap_unaligned)
    return unaligned(cpu, address);
  const struct hil_region *region = memory_at(cpu, address, size);
  return region && !is_watched(cpu, region) ? load(region, address, size, value) : ACCESS_REGISTERS;
}

/* Write memory; ACCESS_REGISTERS if none is there that can be written, or it is watched. */
int hil_store_memory(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t value) {
  if (address & (size - 1) && cpu->state.trap_unaligned)
    return unaligned(cpu, address);
  const struct hil_region *region = memory_at(cpu, address, size);
  bool stores = region && region->writable && !is_watched(cpu, region);
  return stores ? store(cpu, region, address, size, value) : ACCESS_REGISTERS;
}

static int failed(struct hil_cpu *cpu, uint32_t address, int fault) {
  cpu->state.fault_address = address;
  return fault;
}

/* An unaligned access that reaches over the end of a region goes byte by byte. */
static bool crosses(const struct hil_region *region, uint32_t address, uint32_t size) {
  return region && region->size - (address - region->base) < size;
}

/* Whether an access is for the system control space, and nobody else wants to see it. */
static bool is_for_core(const struct hil_cpu *cpu, uint32_t address) {
  const struct hil_state *state = &cpu->state;
  return address - SCS < 0x1000 && cpu->exceptions.count && !state->looking && !state->through_python &&
         hil_is_privileged(state);
}

/* Python is about to be called. */
static void begin_call(struct hil_cpu *cpu) {
  cpu->state.refused = 0;
  hil_tell_time(cpu);
}

/* The block in C at an address, unless its clock stands still. */
static struct hil_block *block_at(struct hil_cpu *cpu, uint32_t address) {
  for (uint32_t n = 0; n < cpu->block_count; n++) {
    struct hil_block *block = cpu->blocks[n];
    if (address - block->registers.base < BLOCK_SIZE)
      return block->registers.clocked && (address & (BLOCK_SIZE - 1)) < 4 * BLOCK_WORDS ? block : NULL;
  }
  return NULL;
}

/* Whether somebody else wants to see the accesses of the core. */
static bool goes_by_python(const struct hil_state *state) { return state->looking || state->through_python; }

static uint32_t word_of(uint32_t address) { return (address & (BLOCK_SIZE - 1)) / 4; }

static bool read_block(struct hil_block *block, uint32_t address, uint32_t size, uint32_t *value) {
  if (!block || !block->read || !block->read(block, word_of(address), value))
    return false;
  if (size < 4)
    *value = *value >> 8 * (address & 3) & ((1u << 8 * size) - 1);
  return true;
}

/* A byte or half-word is repeated over the whole word on its way to a register on APB (RM0008 section 3.1); on AHB the
 * rest of the word keeps what it has. */
static bool write_block(struct hil_block *block, uint32_t address, uint32_t size, uint32_t value) {
  static const uint32_t REPEATED[] = {[1] = 0x01010101, [2] = 0x00010001, [4] = 1};
  if (!block || !block->write)
    return false;
  uint32_t word = word_of(address), at = 8 * (address & 3);
  if (size == 4 || !block->on_ahb)
    return block->write(block, word, value * REPEATED[size]);
  uint32_t mask = ((1u << 8 * size) - 1) << at;
  return block->write(block, word, (block->registers.values[word] & ~mask) | value << at);
}

/* --- accesses of others than the core; false: nothing was done, they are for Python */

/* The address is a multiple of the size. */
bool hil_master_load(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t *value) {
  const struct hil_region *region = hil_region_at(cpu, address);
  if (!region || !region->data)
    return region && read_block(block_at(cpu, address), address, size, value);
  *value = 0;
  memcpy(value, region->data + (address - region->base), size);
  return true;
}

bool hil_master_store(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t value) {
  const struct hil_region *region = hil_region_at(cpu, address);
  if (!region || (region->data && !region->writable))
    return false;
  if (region->data) {
    memcpy(region->data + (address - region->base), &value, size);
    return true;
  }
  if (!write_block(block_at(cpu, address), address, size, value))
    return false;
  cpu->state.block_writes++;
  return true;
}

/* --- accesses of the core */

/* A program that reads the same register again and again may be waiting for it. */
static void count_polls(struct hil_state *state, uint32_t address) {
  if (state->through_python)
    return;
  if (address != state->polled) {
    state->polled = address;
    state->polls = 0;
  } else if (state->polls < state->polls_wanted) {
    state->polls++;
  } else {
    state->polls = 0;
    state->polled_often = 1;
    if (!state->looking) {
      state->look_at = 0;
      state->changed = 1;
    }
  }
}

static int read_register(struct hil_cpu *cpu, const struct hil_region *region, uint32_t address, uint32_t size,
                         uint32_t *value) {
  if (is_for_core(cpu, address) && hil_scs_read(cpu, address - SCS, size, value))
    return ACCESS_DONE;
  count_polls(&cpu->state, address);
  begin_call(cpu);
  if (!goes_by_python(&cpu->state) && read_block(block_at(cpu, address), address, size, value))
    return ACCESS_DONE;
  uint32_t window = (uint32_t)(region - cpu->regions);
  *value = cpu->read(window, address - region->base, size);
  if (size < 4)
    *value &= (1u << 8 * size) - 1;
  return cpu->state.refused ? failed(cpu, address, FAULT_READ) : ACCESS_DONE;
}

/* Whether the program is told to stop before an access. */
static bool is_hit(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t kind, const uint32_t *stored) {
  return UNLIKELY(cpu->hooks.watchpoint_count) && cpu->state.running &&
         hil_watch_stops(cpu, address, size, kind, stored);
}

/* Read what is not memory alone, or is watched. */
int hil_load_register(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t *value) {
  const struct hil_region *region = hil_region_at(cpu, address);
  if (is_hit(cpu, address, size, HIT_READ, NULL))
    return ACCESS_HIT;
  if (crosses(region, address, size)) {
    *value = 0;
    for (uint32_t n = 0; n < size; n++) {
      uint32_t byte = 0;
      int how = hil_load_memory(cpu, address + n, 1, &byte);
      if (how == ACCESS_REGISTERS)
        how = hil_load_register(cpu, address + n, 1, &byte);
      if (how != ACCESS_DONE)
        return how;
      *value |= byte << 8 * n;
    }
    return ACCESS_DONE;
  }
  if (!region)
    return failed(cpu, address, FAULT_READ);
  if (region->data)
    return load(region, address, size, value);
  int how = read_register(cpu, region, address, size, value);
  if (UNLIKELY(cpu->hooks.accesses) && cpu->state.running && how == ACCESS_DONE)
    hil_note_access(cpu, address, size, *value, false);
  return how;
}

/* A store into read-only memory is one at the end of its instruction, which takes `cost` cycles, and ends the run. */
static void store_read_only(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t value, uint32_t cost) {
  struct hil_state *state = &cpu->state;
  uint64_t cycle = state->cycle;
  state->cycle = state->table ? cycle + cost : hil_cycle_at(state, state->retired + 1);
  state->running = 0;
  hil_tell_time(cpu);
  cpu->write(HIL_READ_ONLY, address, size, value);
  state->running = 1;
  state->cycle = cycle;
  state->limit_cycle = 0;
  state->changed = 1;
}

static int write_register(struct hil_cpu *cpu, const struct hil_region *region, uint32_t address, uint32_t size,
                          uint32_t value) {
  if (is_for_core(cpu, address) && hil_scs_write(cpu, address - SCS, size, value)) {
    cpu->state.writes++;
    return ACCESS_DONE;
  }
  cpu->state.polled = UINT32_MAX;
  begin_call(cpu);
  if (!goes_by_python(&cpu->state) && write_block(block_at(cpu, address), address, size, value)) {
    cpu->state.block_writes++;
    return ACCESS_DONE;
  }
  cpu->write((uint32_t)(region - cpu->regions), address - region->base, size, value);
  return cpu->state.refused ? failed(cpu, address, FAULT_WRITE) : ACCESS_DONE;
}

/* Write what is not writable memory alone, or is watched. */
int hil_store_register(struct hil_cpu *cpu, uint32_t address, uint32_t size, uint32_t value, uint32_t cost) {
  const struct hil_region *region = hil_region_at(cpu, address);
  if (size < 4)
    value &= (1u << 8 * size) - 1;
  if (is_hit(cpu, address, size, HIT_WRITE, &value))
    return ACCESS_HIT;
  if (crosses(region, address, size)) {
    uint8_t *begun = region->data && region->writable ? region->data + (address - region->base) : NULL, before[4];
    uint32_t inside = region->size - (address - region->base);
    if (begun)
      memcpy(before, begun, inside);
    for (uint32_t n = 0; n < size; n++) {
      int how = hil_store_memory(cpu, address + n, 1, value >> 8 * n);
      if (how == ACCESS_REGISTERS)
        how = hil_store_register(cpu, address + n, 1, value >> 8 * n, cost);
      if (how == ACCESS_DONE)
        continue;
      if (begun)
        memcpy(begun, before, inside);
      return how;
    }
    return ACCESS_DONE;
  }
  if (!region)
    return failed(cpu, address, FAULT_WRITE);
  if (region->data && region->writable)
    return store(cpu, region, address, size, value);
  cpu->look.dirty = true;
  if (region->data) {
    cpu->state.polled = UINT32_MAX;
    begin_call(cpu);
    store_read_only(cpu, address, size, value, cost);
    return cpu->state.refused ? failed(cpu, address, FAULT_WRITE) : ACCESS_DONE;
  }
  int how = write_register(cpu, region, address, size, value);
  if (UNLIKELY(cpu->hooks.accesses) && cpu->state.running && how == ACCESS_DONE)
    hil_note_access(cpu, address, size, value, true);
  return how;
}

/* Write a word of an exception frame that is not in writable memory. */
int hil_store_beside(struct hil_cpu *cpu, uint32_t address, uint32_t value) {
  const struct hil_region *region = hil_region_at(cpu, address);
  if (!region)
    return failed(cpu, address, FAULT_WRITE);
  begin_call(cpu);
  cpu->write(region->data ? HIL_READ_ONLY : (uint32_t)(region - cpu->regions),
             region->data ? address : address - region->base, 4, value);
  return cpu->state.refused ? failed(cpu, address, FAULT_WRITE) : ACCESS_DONE;
}

/* The two halves at an address of code, the first below; `complete` is false if a wide instruction has but one. */
uint32_t hil_fetch(struct hil_cpu *cpu, const struct hil_region *region, uint32_t address, bool *complete) {
  uint32_t offset = address - region->base;
  uint16_t first = 0, second = 0;
  memcpy(&first, region->data + offset, 2);
  *complete = true;
  if (offset + 4 <= region->size) {
    memcpy(&second, region->data + offset + 2, 2);
  } else if (hil_is_wide(first)) {
    const struct hil_region *behind = hil_region_at(cpu, address + 2);
    *complete = behind && behind->data;
    if (*complete)
      memcpy(&second, behind->data + (address + 2 - behind->base), 2);
  }
  return first | (uint32_t)second << 16;
}
