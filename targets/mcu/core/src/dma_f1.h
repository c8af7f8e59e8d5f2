/* DMA1 and DMA2 of the STM32F1: see dma_f1.c. */
#ifndef HIL_DMA_F1_H
#define HIL_DMA_F1_H

#include "block.h"
#include "queue.h"
#include "requests.h"

struct hil_cpu;
struct hil_dma;

/* What Python is asked for. */
enum hil_dma_question {
  DMA_READS,  /* `size` bytes at `address`; DMA_FAILS: a bus error */
  DMA_WRITES, /* the same with a value */
  DMA_DRIVES, /* interrupt `address`, counted from the controller's first, to level `value` */
  DMA_NOTES,  /* `enum hil_dma_note` in `value`, of channel `address` and its register `size` */
};

/* What a program has got wrong: a register was written while its channel was enabled, an address is no multiple of its
 * width, MEM2MEM and CIRC are set together. */
enum hil_dma_note { NOTE_PROTECTED, NOTE_UNALIGNED, NOTE_ROUND };

#define DMA_FAILS UINT64_MAX

typedef uint64_t (*hil_dma_ask)(uint32_t question, uint32_t address, uint32_t size, uint32_t value);

/* A request line is a number: its channel in the upper bits, one of `1 << REQUEST_BITS` lines to it in the lower ones.
 * Nobody listens to those of channel 0. */
enum { REQUEST_BITS = 4 };

#endif
