/* The state of a core, its queue and its blocks as one piece of memory, to be put back into the same ones.
 *
 * What it consists of does not move: pointers between these stay right. Arrays that grow are kept where they are, and
 * never shrink; so what was saved finds room. Memory that programs see is its owner's to save. Not while running. */
#include "block.h"
#include "cpu.h"

#include <string.h>

struct core {
  struct hil_state state;
  struct hil_exceptions exceptions;
  struct hil_systick systick;
  struct hil_hit hit;
  uint64_t passed_at;
  uint32_t passed_pc, passed, branch;
};

static void *field(struct hil_block *block, uint32_t offset) { return (uint8_t *)block + offset; }

static size_t size_of_block(struct hil_block *block) {
  size_t size = block->saved->size;
  for (uint32_t n = 0; n < MOST_GROWN && block->saved->grown[n].each; n++)
    size += (size_t)*(uint32_t *)field(block, block->saved->grown[n].room) * block->saved->grown[n].each;
  return size;
}

/* How many bytes the state has at present. */
HIL_EXPORT uint64_t hil_saved_size(const struct hil_cpu *cpu) {
  size_t size = sizeof(struct core) + (cpu->queue ? hil_queue_saved_size(cpu->queue) : 0);
  for (uint32_t n = 0; n < cpu->block_count; n++)
    size += size_of_block(cpu->blocks[n]);
  return size;
}

static uint8_t *save_block(struct hil_block *block, uint8_t *into) {
  const struct hil_saved *saved = block->saved;
  memcpy(into, block, saved->size);
  into += saved->size;
  for (uint32_t n = 0; n < MOST_GROWN && saved->grown[n].each; n++) {
    size_t size = (size_t)*(uint32_t *)field(block, saved->grown[n].room) * saved->grown[n].each;
    if (size)
      memcpy(into, *(void **)field(block, saved->grown[n].data), size);
    into += size;
  }
  return into;
}

static const uint8_t *load_block(struct hil_block *block, const uint8_t *from) {
  const struct hil_saved *saved = block->saved;
  void *data[MOST_GROWN];
  uint32_t room[MOST_GROWN];
  for (uint32_t n = 0; n < MOST_GROWN && saved->grown[n].each; n++) {
    data[n] = *(void **)field(block, saved->grown[n].data);
    room[n] = *(uint32_t *)field(block, saved->grown[n].room);
  }
  memcpy(block, from, saved->size);
  from += saved->size;
  for (uint32_t n = 0; n < MOST_GROWN && saved->grown[n].each; n++) {
    size_t size = (size_t)*(uint32_t *)field(block, saved->grown[n].room) * saved->grown[n].each;
    if (size)
      memcpy(data[n], from, size);
    from += size;
    *(void **)field(block, saved->grown[n].data) = data[n];
    *(uint32_t *)field(block, saved->grown[n].room) = room[n];
  }
  return from;
}

HIL_EXPORT void hil_save(const struct hil_cpu *cpu, uint8_t *into) {
  struct core core;
  memset(&core, 0, sizeof core);
  core.state = cpu->state;
  core.exceptions = cpu->exceptions;
  core.systick = cpu->systick;
  core.hit = cpu->hooks.hit;
  core.passed_at = cpu->hooks.passed_at;
  core.passed_pc = cpu->hooks.passed_pc;
  core.passed = cpu->hooks.passed;
  core.branch = cpu->hooks.branch;
  memcpy(into, &core, sizeof core);
  into += sizeof core;
  if (cpu->queue)
    into = hil_queue_save(cpu->queue, into);
  for (uint32_t n = 0; n < cpu->block_count; n++)
    into = save_block(cpu->blocks[n], into);
}

/* Put a state back that was saved of this core. */
HIL_EXPORT void hil_restore(struct hil_cpu *cpu, const uint8_t *from) {
  struct core core;
  memcpy(&core, from, sizeof core);
  cpu->state = core.state;
  cpu->exceptions = core.exceptions;
  cpu->systick = core.systick;
  cpu->hooks.hit = core.hit;
  cpu->hooks.passed_at = core.passed_at;
  cpu->hooks.passed_pc = core.passed_pc;
  cpu->hooks.passed = core.passed;
  cpu->hooks.branch = core.branch;
  cpu->near[0] = cpu->near[1] = &cpu->nowhere;
  from += sizeof core;
  if (cpu->queue)
    from = hil_queue_restore(cpu->queue, from);
  for (uint32_t n = 0; n < cpu->block_count; n++)
    from = load_block(cpu->blocks[n], from);
}
