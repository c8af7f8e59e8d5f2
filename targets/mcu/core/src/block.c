/* A block of registers as Python sees it. */
#include "block.h"

HIL_EXPORT struct hil_registers *hil_registers_of(struct hil_block *block) { return &block->registers; }

/* Write a word as a program does; false: nothing was done, it is for Python. */
HIL_EXPORT bool hil_block_store(struct hil_block *block, uint32_t word, uint32_t value) {
  return block->write && block->write(block, word, value);
}

/* Read one; UINT64_MAX: it is for Python. */
HIL_EXPORT uint64_t hil_block_load(struct hil_block *block, uint32_t word) {
  uint32_t value = 0;
  return block->read && block->read(block, word, &value) ? value : UINT64_MAX;
}
