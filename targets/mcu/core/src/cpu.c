/* A core as its user has it: made, given memory, told what others have changed. */
#include "cpu.h"
#include "operations.h"

#include <stdlib.h>

HIL_EXPORT void hil_free(struct hil_cpu *cpu) {
  if (!cpu)
    return;
  for (uint32_t n = 0; n < cpu->region_count; n++) {
    free(cpu->regions[n].ops);
    free(cpu->regions[n].executed);
  }
  hil_decoder_free(cpu->decoder);
  free(cpu);
}

/* Make a core.
 *
 * is_m7: with the DSP extension and floating point, and with the cycles of a Cortex-M7; otherwise a Cortex-M3.
 * by_table: the timing model.
 * basepri_bits: those of BASEPRI that can be set.
 * read, write: called for what is not memory.
 *
 * Returns NULL if there is no memory left. */
HIL_EXPORT struct hil_cpu *hil_new(uint32_t is_m7, uint32_t by_table, uint32_t basepri_bits, hil_read read,
                                   hil_write write) {
  struct hil_cpu *cpu = calloc(1, sizeof *cpu);
  if (!cpu)
    return NULL;
  cpu->decoder = hil_decoder_new(is_m7, is_m7, is_m7);
  cpu->near[0] = cpu->near[1] = &cpu->nowhere;
  cpu->has_dsp = cpu->has_float = cpu->is_m7 = is_m7;
  cpu->basepri_bits = basepri_bits;
  cpu->read = read;
  cpu->write = write;
  cpu->state.table = by_table;
  cpu->state.refill = is_m7 ? 1 : 2;
  cpu->state.numerator = cpu->state.denominator = 1;
  cpu->state.float_access = 3;
  cpu->exceptions.fpccr = (uint32_t)0xC0000000; /* floating-point contexts begin by themselves, as after reset */
  cpu->state.alarm = cpu->state.due = cpu->systick.cleared = UINT64_MAX;
  cpu->state.look_at = cpu->state.look_wait = HIL_FIRST_WAIT;
  cpu->state.polls_wanted = UINT32_MAX;
  cpu->state.fault = NO_FAULT;
  if (!cpu->decoder) {
    hil_free(cpu);
    return NULL;
  }
  return cpu;
}

/* Let this core live in the time of a queue, which must last as long. */
HIL_EXPORT void hil_join(struct hil_cpu *cpu, struct hil_queue *queue) {
  cpu->queue = queue;
  hil_queue_serve(queue, &cpu->state);
}

HIL_EXPORT struct hil_state *hil_state_of(struct hil_cpu *cpu) { return &cpu->state; }

HIL_EXPORT struct hil_exceptions *hil_exceptions_of(struct hil_cpu *cpu) { return &cpu->exceptions; }

HIL_EXPORT struct hil_systick *hil_systick_of(struct hil_cpu *cpu) { return &cpu->systick; }

static int32_t add_region(struct hil_cpu *cpu, struct hil_region region) {
  if (cpu->region_count == MOST_REGIONS || region.size & 3 || region.base & 3)
    return -1;
  cpu->regions[cpu->region_count] = region;
  return (int32_t)cpu->region_count++;
}

/* Put memory at an address; it stays the caller's, and must last as long as the core. Returns its number, or -1. */
HIL_EXPORT int32_t hil_map_memory(struct hil_cpu *cpu, uint32_t base, uint8_t *data, uint32_t size, uint32_t writable) {
  return add_region(cpu, (struct hil_region){.base = base, .size = size, .data = data, .writable = writable});
}

/* Put registers at an address. Returns the number of the window, or -1. */
HIL_EXPORT int32_t hil_map_registers(struct hil_cpu *cpu, uint32_t base, uint32_t size) {
  return add_region(cpu, (struct hil_region){.base = base, .size = size});
}

/* Places in the host's memory are compared as numbers: they may be of different objects. */
static void forget_in(struct hil_cpu *cpu, struct hil_region *region, uintptr_t from, uintptr_t to) {
  uintptr_t start = (uintptr_t)region->data, end = start + region->size;
  if (!region->ops || to <= start || from >= end)
    return;
  size_t first = from > start ? (from - start) / 2 : 0;
  size_t last = to < end ? (to - start + 1) / 2 : region->size / 2;
  if (last - first > region->size / 8 && !cpu->executing) {
    hil_remember(region, 0, region->size / 2);
    free(region->ops);
    region->ops = NULL;
    return;
  }
  first = first ? first - 1 : 0; /* the half before may begin a wide instruction */
  hil_remember(region, first, last);
  for (size_t at = first; at < last; at++) {
    region->ops[at].code = OP_UNDECODED;
    region->ops[at].jump = 0;
  }
}

/* Put a block of registers into a window, to be asked before Python is. It must last as long as the core. */
HIL_EXPORT bool hil_attach(struct hil_cpu *cpu, struct hil_block *block) {
  if (cpu->block_count == MOST_BLOCKS)
    return false;
  cpu->blocks[cpu->block_count++] = block;
  return true;
}

/* Code that somebody else may have changed is decoded anew, wherever the same memory is mapped. */
HIL_EXPORT void hil_forget(struct hil_cpu *cpu, uint32_t base, uint32_t size) {
  const struct hil_region *changed = hil_region_at(cpu, base);
  if (!changed || !changed->data)
    return;
  uintptr_t from = (uintptr_t)changed->data + (base - changed->base);
  for (uint32_t n = 0; n < cpu->region_count; n++)
    if (cpu->regions[n].data)
      forget_in(cpu, &cpu->regions[n], from, from + size);
}
