/* DMA controllers with eight streams: see dma_stream.c. */
#ifndef HIL_DMA_STREAM_H
#define HIL_DMA_STREAM_H

#include "block.h"
#include "queue.h"
#include "requests.h"

enum { STREAMS = 8 };

/* What Python is asked for; of memory and registers, only what is not reached from here. */
enum hil_streams_question {
  STREAM_READS,   /* `size` bytes at `address`; STREAM_FAILS: a bus error */
  STREAM_WRITES,  /* the same with a value */
  STREAM_DRIVES,  /* the interrupt of stream `address` to level `value` */
  STREAM_NOTES,   /* `enum hil_streams_note` in `value`, of stream `address` and its register `size` */
  STREAM_SELECTS, /* the requests that stream `address` listens to, which is enabled with `value` in CHSEL */
  STREAM_LAST,    /* the last transfer of a count was made, by request `address` */
};

/* What a program has got wrong: a register was written while its stream was enabled, flags were still set then, an
 * address is no multiple of its width, the controller cannot go from memory to memory. */
enum hil_streams_note { STREAM_PROTECTED, STREAM_FLAGGED, STREAM_UNALIGNED, STREAM_NO_WAY };

#define STREAM_FAILS UINT64_MAX

typedef uint64_t (*hil_streams_ask)(uint32_t question, uint32_t address, uint32_t size, uint32_t value);

void hil_stream_asked(struct hil_streams *dma, uint32_t n);
void hil_stream_ended(struct hil_streams *dma, uint32_t n);
uint32_t hil_stream_left(const struct hil_streams *dma, uint32_t n);

#endif
