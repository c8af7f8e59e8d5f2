/* A block of registers in C, as a core sees it: words at an address, of which those that are not for C are Python's. */
#ifndef HIL_BLOCK_H
#define HIL_BLOCK_H

#include "layout.h"

#include <stdbool.h>

enum { BLOCK_SIZE = 0x400, BLOCK_WORDS = 52 };

struct hil_block;

/* Read or write the word of that number; false: nothing was done, Python is to be asked. */
typedef bool (*hil_block_read)(struct hil_block *block, uint32_t word, uint32_t *value);
typedef bool (*hil_block_write)(struct hil_block *block, uint32_t word, uint32_t value);

/* base: its address. clocked: its clock runs.
 * values: what is kept for each register. writable: bits of it that a write changes.
 * ignored: bits of these that the model only remembers: Python notes the first write of 1. */
#define HIL_REGISTERS_FIELDS(ONE, MANY) \
    ONE(uint32_t, base) ONE(uint32_t, clocked) \
    MANY(uint32_t, values, 52) MANY(uint32_t, writable, 52) MANY(uint32_t, ignored, 52)
HIL_STRUCT(hil_registers, HIL_REGISTERS_FIELDS);

/* What is to be saved of a block (snapshot.c): all of it, and what stands in its arrays that grow: the places of their
 * pointer and of how many elements there is room for, and the size of one. */
enum { MOST_GROWN = 2 };

struct hil_saved {
  uint32_t size;
  struct {
    uint32_t data, room, each;
  } grown[MOST_GROWN];
};

struct hil_block {
  struct hil_registers registers;
  hil_block_read read;
  hil_block_write write;
  const struct hil_saved *saved;
  bool on_ahb;               /* a byte or half-word leaves the rest of its word alone */
};

#endif
