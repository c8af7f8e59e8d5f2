/* An SPI interface of the STM32F1: see spi_f1.c. */
#ifndef HIL_SPI_F1_H
#define HIL_SPI_F1_H

#include "block.h"
#include "queue.h"
#include "requests.h"

struct hil_cpu;

/* What Python is asked and told. */
enum hil_spi_question {
  SPI_CLOCK,     /* HCLK cycles of a clock of the bus */
  SPI_LISTENS,   /* changes of NSS matter, or not */
  SPI_NSS,       /* its level */
  SPI_IDLES,     /* be a master that waits: CPOL, and NSS is driven (2) */
  SPI_RELEASES,  /* drive nothing */
  SPI_SENDS,     /* the word is to go over the wires edge by edge, and `hil_spi_over` at its end; 1: here, all the same */
  SPI_EDGE,      /* tell of an edge; what stands at MISO then */
  SPI_PUTS,      /* bring the wires to the end of the word */
  SPI_LEVEL,     /* what stands at MISO, or at MOSI of one wire */
  SPI_EXCHANGES, /* have the slaves take these bits; SPI_SILENCE: none is selected */
  SPI_LEFT,      /* how many words DMA has still to bring */
  SPI_REQUESTS_TX, SPI_REQUESTS_RX, /* the levels of the requests to DMA, and of the interrupt, */
  SPI_DRIVES,    /* where that is not driven here */
  SPI_NOTES,     /* `enum hil_spi_note` */
};

/* What a program has got wrong, or what is not modelled. */
enum hil_spi_note {
  NOTE_LOST,        /* a word was written while another waited */
  NOTE_LOCKED,      /* DFF or CRCEN was changed while SPE is set */
  NOTE_NO_CLOCK,    /* a slave was switched on */
  NOTE_LATE_CRCNEXT /* CRCNEXT was set while no word is under way */
};

typedef uint32_t (*hil_spi_ask)(uint32_t question, uint32_t value);

#define SPI_SILENCE UINT32_MAX

/* plain: nobody looks at SCK and MOSI, so that a word is one event at its end. looped: nobody does but MISO, to which
 *   MOSI is wired; each half of a clock is an event, as each that other chips or pins may see is. late: neither need they be told of it
 *   then; whoever looks brings them up. behind: MOSI was not told of the last one, which has ended
 *   with the level `last`.
 * going: a word is under way here, and what it is: its first cycle, the HCLK cycles of half a clock, its bits, the first
 *   one as the highest, their number, CPHA, whether MOSI is driven, and is where bits come in.
 * edges: each half of a clock of it is an event; halves: so many have begun. sampled: the bits that have come in by them.
 * known: whoever knows of another level than `miso` at MISO takes this back.
 * asks: there are slaves. promised: bits that stand on MISO next, whatever is sent, are known for this mode and more.
 * heard: how many bytes were sent meanwhile that slaves do not know of; heard_at: the end of the last one. */
#define HIL_SPI_WIRES_FIELDS(ONE, MANY) \
    ONE(uint32_t, plain) ONE(uint32_t, looped) ONE(uint32_t, late) ONE(uint32_t, behind) ONE(uint32_t, last) \
    ONE(uint32_t, going) ONE(uint64_t, begun) ONE(uint32_t, half_cycles) ONE(uint32_t, bits) ONE(uint32_t, count) \
    ONE(uint32_t, cpha) ONE(uint32_t, drives) ONE(uint32_t, one_wire) \
    ONE(uint32_t, edges) ONE(uint32_t, halves) ONE(uint32_t, sampled) \
    ONE(uint32_t, known) ONE(uint32_t, miso) \
    ONE(uint32_t, asks) ONE(uint32_t, promised) ONE(uint32_t, heard) ONE(uint64_t, heard_at) \
    ONE(uint32_t, clock_cycles)
HIL_STRUCT(hil_spi_wires, HIL_SPI_WIRES_FIELDS);

enum { MOST_PROMISED = 4096 };

/* What `promised` is: nothing; the bytes of `answers` from `answered` on; that nobody is selected. */
enum hil_spi_promise { PROMISED_NOTHING, PROMISED_BYTES, PROMISED_SILENCE };

/* waiting: the transmit buffer has a word. busy: one is under way, here or in Python; sent: which.
 * read_dr: DR was read since SR was; saw_modf: SR was accessed while MODF was set. crc_next, crc_word: the CRC comes
 * next, and is under way. */
struct hil_spi {
  struct hil_block block;    /* first: a block is the interface that it belongs to */
  struct hil_spi_wires wires;
  struct hil_queue *queue;
  struct hil_cpu *cpu;       /* whose interrupt `irq` is driven; NULL: Python is told */
  uint32_t irq;
  struct hil_requests *requests; /* where they go; NULL: Python is told */
  uint32_t lines[2];         /* their numbers, to send and of what was received */
  hil_spi_ask ask;
  int32_t end;               /* the event at the end of a word */
  bool has_word, busy, read_dr, saw_modf, crc_next, crc_word, interrupts;
  uint32_t waiting, sent, cpol, promised_mode;
  uint32_t answered, answer_count;
  uint8_t answers[MOST_PROMISED], told[MOST_PROMISED];
};

/* spi_words.c */
void hil_spi_send(struct hil_spi *spi);
void hil_spi_on_end(void *whose);

/* spi_f1.c */
void hil_spi_ended(struct hil_spi *spi, uint32_t received);
bool hil_spi_wants_what_comes_in(const struct hil_spi *spi);

#endif
