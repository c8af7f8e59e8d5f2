/* A USART: frames on its line one after the other, and where they come from and go to.
 *
 * What happens to a frame that nothing disturbs is here: usart.c. Levels of pins, and frames that have to be sampled,
 * are Python's (targets/mcu/stm32/usart_receiver.py, usart_transmitter.py). */
#ifndef HIL_USART_H
#define HIL_USART_H

#include "block.h"
#include "queue.h"
#include "requests.h"

struct hil_cpu;

/* Which registers: SR and DR of the STM32F1 (usart_f1.c), or ISR, ICR, RDR and TDR (usart_isr.c). */
enum hil_usart_kind { USART_F1, USART_ISR };

enum hil_sending { SENDING_NOTHING, SENDING_PREAMBLE, SENDING_BREAK, SENDING_BREAK_STOP, SENDING_DATA };

/* What Python is told; see `hil_usart_tell`. */
enum hil_usart_news {
  NEWS_FRAME,      /* a frame begins: `frame_bits` and what follows it in the struct */
  NEWS_END,        /* what was being sent has ended */
  NEWS_IDLE_LEVEL, /* nothing follows */
  NEWS_CUT,        /* a frame has ended after the transmitter was disabled */
  NEWS_DATA,       /* a word that is not muted: its data, and PE, FE, NE, ORE */
  NEWS_DMA_TX, NEWS_DMA_RX, NEWS_IRQ, /* the new level of a request or line */
  NEWS_RTS,        /* it may have changed: whether the next word would be lost */
  NEWS_ARRIVED,    /* a frame that was expected begins, and Python is to look at it; so many follow */
};

/* What Python is asked. */
enum hil_usart_question {
  ASK_SENT,        /* the cycle at which so many sixteenths of a bit of the present frame have been sent */
  ASK_READ,        /* the same of the frame that comes in; of that and of the wait that follows, from a cycle on */
  ASK_QUIET,
};

/* Of which news somebody wants to know at once; words of data may be kept instead, until somebody takes them. */
enum { TELL_FRAMES = 1, TELL_ENDS = 2, TELL_DATA = 4, KEEP_WORDS = 8 };

typedef void (*hil_usart_tell)(uint32_t news, uint32_t value, uint32_t more);
typedef uint64_t (*hil_usart_ask)(uint32_t question, uint32_t sixteenths);

/* bit_cycles, bit_parts: a bit lasts bit_cycles / bit_parts cycles. odd: these do not fit; Python is asked.
 * word_bits, data_bits, parity (0 none, 1 even, 2 odd), stop_half_bits: how words are framed.
 * tells: see above. levels: of interrupt, DMA_TX and DMA_RX, as driven last.
 *
 * break_bits, break_wanted, half_duplex, clear_to_send, enabled: what the transmitter is to do; a break follows the
 *   present frame, the next word is not held back.
 * holds, holding: the data register. sending, begun, end, end_cycle: what is being sent, since when, how many sixteenths
 *   of a bit it has, and when it ends. bent: the bit time has changed meanwhile.
 * preamble_due, data_sent: not yet sent, and not yet told.
 * quiet: clear from the start of a frame until the line has its idle level again.
 * frame_bits, frame_count, frame_stop, frame_is_break: the last frame; frame_is_new: Python has not taken it.
 *
 * listening: the receiver runs. read_at: sixteenths of a bit from the start of a frame until its word is complete.
 * hears, heard, heard_from: a frame comes in, its bits, the cycle at which it began.
 * quiet_from, quiet_until, quiet_length: the line is idle if it stays high between these two cycles, so many sixteenths
 *   of a bit apart.
 *
 * coming: how many frames are expected. plain: the next of them comes alone, and each sample lies in its bit, unless a
 *   frame is just being heard. expected: the frame that was heard last was one of them.
 * kept: how many words were sent that nobody has taken.
 *
 * idle_armed: a word has come in since the line was idle. received, seen: see usart_f1.c.
 * unread, unsent: how many words wait in the FIFOs of usart_isr.c; whoever sets one to 0 throws them away. */
#define HIL_LINE_FIELDS(ONE, MANY) \
    ONE(uint64_t, bit_cycles) ONE(uint64_t, bit_parts) ONE(uint32_t, odd) \
    ONE(uint32_t, word_bits) ONE(uint32_t, data_bits) ONE(uint32_t, parity) ONE(uint32_t, stop_half_bits) \
    ONE(uint32_t, tells) ONE(uint32_t, levels) \
    ONE(uint32_t, break_bits) ONE(uint32_t, break_wanted) ONE(uint32_t, half_duplex) ONE(uint32_t, clear_to_send) \
    ONE(uint32_t, enabled) ONE(uint32_t, holds) ONE(uint32_t, holding) \
    ONE(uint64_t, begun) ONE(uint64_t, end_cycle) ONE(uint32_t, sending) ONE(uint32_t, end) ONE(uint32_t, bent) \
    ONE(uint32_t, preamble_due) ONE(uint32_t, data_sent) ONE(uint32_t, quiet) \
    ONE(uint32_t, frame_bits) ONE(uint32_t, frame_count) ONE(uint32_t, frame_stop) ONE(uint32_t, frame_is_break) \
    ONE(uint32_t, frame_is_new) \
    ONE(uint32_t, listening) ONE(uint32_t, read_at) ONE(uint32_t, hears) ONE(uint32_t, heard) \
    ONE(uint64_t, heard_from) ONE(uint64_t, quiet_from) ONE(uint64_t, quiet_until) ONE(uint32_t, quiet_length) \
    ONE(uint32_t, coming) ONE(uint32_t, plain) ONE(uint32_t, expected) ONE(uint32_t, kept) \
    ONE(uint32_t, received) ONE(uint32_t, seen) ONE(uint32_t, idle_armed) \
    ONE(uint32_t, unread) ONE(uint32_t, unsent)
HIL_STRUCT(hil_line, HIL_LINE_FIELDS);

/* Words on a line, each with the cycle at which its start bit begins. */
struct hil_words {
  struct hil_word {
    uint64_t cycle, bits;
  } *words;
  uint32_t first, end, room;
};

enum { FIFO_PLACES = 32 };

/* Words that wait, the oldest first: of a power of two of places, so many from `first` on as the line says. */
struct hil_fifo {
  uint32_t words[FIFO_PLACES], errors[FIFO_PLACES], first;
};

struct hil_usart;

/* What the registers make of what happens on the line. */
struct hil_usart_model {
  hil_block_read read;
  hil_block_write write;
  void (*loaded)(struct hil_usart *usart);     /* the word has moved from the data register into the shift register */
  void (*complete)(struct hil_usart *usart);   /* the last frame of data has ended and nothing follows */
  void (*break_sent)(struct hil_usart *usart); /* the stop bit of a break begins */
  void (*word)(struct hil_usart *usart, uint32_t bits, bool noise, bool framing_error); /* those between start and stop */
  bool (*wants_idle)(const struct hil_usart *usart); /* whether to tell of an idle line after this word */
  void (*line_idle)(struct hil_usart *usart);  /* the line was high for a frame after a word */
  void (*update)(struct hil_usart *usart);     /* drive interrupt, DMA requests and RTS from flags and enables */
};

/* Beside the bits of a frame that is expected: Python is to look at it. */
#define LOOK_AT_WORD (1ull << 63)

struct hil_usart {
  struct hil_block block;    /* first: a block is the USART that it belongs to */
  struct hil_line line;
  const struct hil_usart_model *model;
  struct hil_queue *queue;
  struct hil_cpu *cpu;       /* whose interrupt `irq` is driven; NULL: Python is told */
  uint32_t irq;
  struct hil_requests *requests; /* where they go; NULL: Python is told */
  uint32_t lines[2];         /* their numbers, to send and of what was received */
  struct hil_words expected, kept;
  struct hil_fifo received, to_send; /* behind the data registers; see usart_isr.c */
  int32_t sent, read, idle, arrives; /* events */
  hil_usart_tell tell;
  hil_usart_ask ask;
};

/* usart.c */
void hil_usart_put(struct hil_usart *usart, uint32_t word);
void hil_usart_drive(struct hil_usart *usart, uint32_t levels);
uint32_t hil_usart_word(const struct hil_line *line, uint32_t value);
uint32_t hil_usart_data(const struct hil_line *line, uint32_t word);
bool hil_usart_parity_wrong(const struct hil_line *line, uint32_t word);
void hil_usart_tell_data(const struct hil_usart *usart, uint32_t word, uint32_t errors);

/* usart_f1.c, usart_isr.c */
extern const struct hil_usart_model hil_usart_f1, hil_usart_isr;

#endif
