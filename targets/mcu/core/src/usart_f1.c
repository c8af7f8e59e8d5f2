/* SR and DR of a USART of the STM32F1, and what the control registers make of them (RM0008 section 27.6).
 *
 * Choices where the manual is silent:
 *
 * - A flag that is cleared by "a read of SR followed by an access to DR" is cleared only if that read has seen it.
 * - While ORE is set, words that come in are lost without any further flag. The manual does not say so; silicon does it
 *   (libopencm3 issue 918, on an STM32F103).
 * - Of a word that is lost by an overrun, ORE is the only flag (the manual says so of FE).
 * - IDLE needs a word that has set RXNE before it, also the first time.
 * - The end of the preamble does not set TC: TC is "the transmission of a frame containing data". */
#include "usart.h"

enum { SR, DR, BRR, CR1, CR2, CR3, GTPR };

enum {
  PE = 1 << 0, FE = 1 << 1, NE = 1 << 2, ORE = 1 << 3, IDLE = 1 << 4, RXNE = 1 << 5, TC = 1 << 6, TXE = 1 << 7,
  LBD = 1 << 8, CTS = 1 << 9,
};
/* CR1; four enables stand at the bit of their flag in SR. */
enum { SBK = 1 << 0, RWU = 1 << 1, SAME_BIT = IDLE | RXNE | TC | TXE, RXNEIE = RXNE, PEIE = 1 << 8, WAKE = 1 << 11 };
enum { ADD = 0xF, LBDIE = 1 << 6 };                                                              /* CR2 */
enum { EIE = 1 << 0, DMAR = 1 << 6, DMAT = 1 << 7, RTSE = 1 << 8, CTSIE = 1 << 10 };             /* CR3 */

enum { CLEARED_BY_DR_READ = PE | FE | NE | ORE | IDLE, CLEARED_BY_DR_WRITE = PE | TC };

/* Bits that change nothing but the lines to interrupts and DMA. */
static const uint32_t ENABLES[] = {[CR1] = SAME_BIT | PEIE, [CR2] = LBDIE, [CR3] = EIE | DMAR | DMAT | CTSIE, [GTPR] = 0};

static uint32_t *values(struct hil_usart *usart) { return usart->block.registers.values; }

/* Drive interrupt, DMA requests and RTS from flags and enables. */
static void update(struct hil_usart *usart) {
  const uint32_t *r = values(usart);
  uint32_t sr = r[SR], cr1 = r[CR1], cr3 = r[CR3];
  bool irq = sr & cr1 & SAME_BIT || (sr & ORE && cr1 & RXNEIE) || (sr & PE && cr1 & PEIE) ||
             (sr & (FE | NE | ORE) && cr3 & EIE && cr3 & DMAR) || (sr & CTS && cr3 & CTSIE) ||
             (sr & LBD && r[CR2] & LBDIE);
  if (cr3 & RTSE)
    usart->tell(NEWS_RTS, sr & RXNE, 0);
  hil_usart_drive(usart, irq | (cr3 & DMAT && sr & TXE) << 1 | (cr3 & DMAR && sr & RXNE) << 2);
}

static void flag(struct hil_usart *usart, uint32_t flags) {
  values(usart)[SR] |= flags;
  update(usart);
}

static void loaded(struct hil_usart *usart) { flag(usart, TXE); }

static void complete(struct hil_usart *usart) { flag(usart, TC); }

static void break_sent(struct hil_usart *usart) { values(usart)[CR1] &= ~(uint32_t)SBK; }

/* --- registers */

static bool read(struct hil_block *block, uint32_t word, uint32_t *value) {
  struct hil_usart *usart = (struct hil_usart *)block;
  struct hil_line *line = &usart->line;
  uint32_t *r = values(usart);
  if (word == SR) {
    *value = line->seen = r[SR]; /* those that are set are armed to be cleared by the next access to DR */
    return true;
  }
  if (word == DR) {
    r[SR] &= ~(RXNE | (line->seen & CLEARED_BY_DR_READ));
    line->seen &= ~(uint32_t)CLEARED_BY_DR_READ;
    update(usart);
    *value = line->received;
    return true;
  }
  if (word > GTPR)
    return false;
  *value = r[word];
  return true;
}

static void write_data(struct hil_usart *usart, uint32_t value) {
  struct hil_line *line = &usart->line;
  values(usart)[SR] &= ~(TXE | (line->seen & CLEARED_BY_DR_WRITE));
  line->seen &= ~(uint32_t)CLEARED_BY_DR_WRITE;
  hil_usart_put(usart, hil_usart_word(line, value));
  update(usart);
}

static bool write(struct hil_block *block, uint32_t word, uint32_t value) {
  struct hil_usart *usart = (struct hil_usart *)block;
  uint32_t *r = values(usart), writable = block->registers.writable[word];
  if (word > GTPR || value & block->registers.ignored[word])
    return false;
  value = (value & writable) | (r[word] & ~writable);
  if (word == SR) { /* cleared where a 0 was written */
    r[SR] &= value;
  } else if (word == DR) {
    write_data(usart, value);
    return true;
  } else if (word == BRR) {
    return false;
  } else {
    /* "The RWU bit cannot be modified by software while the RXNE bit is set", with address mark detection. */
    if (word == CR1 && value & WAKE && r[SR] & RXNE)
      value = (value & ~(uint32_t)RWU) | (r[CR1] & RWU);
    if (word != GTPR && (value ^ r[word]) & ~ENABLES[word])
      return false;
    r[word] = value;
  }
  update(usart);
  return true;
}

/* --- receiving */

/* Whether mute mode hides a word; if the word is an address, the mode is entered or left. */
static bool is_muted_for(struct hil_usart *usart, uint32_t word) {
  uint32_t *r = values(usart);
  if (!(r[CR1] & WAKE) || !(word >> (usart->line.data_bits - 1) & 1))
    return r[CR1] & RWU;
  bool is_mine = (word & ADD) == (r[CR2] & ADD);
  r[CR1] = is_mine ? r[CR1] & ~(uint32_t)RWU : r[CR1] | RWU;
  return !is_mine;
}

/* A word was read. */
static void read_word(struct hil_usart *usart, uint32_t word, bool noise, bool framing_error) {
  struct hil_line *line = &usart->line;
  uint32_t *sr = &values(usart)[SR], errors = ORE;
  if (*sr & ORE) {
    hil_usart_tell_data(usart, word, ORE);
    return;
  }
  if (is_muted_for(usart, word))
    return;
  if (!(*sr & RXNE)) {
    line->received = word;
    line->idle_armed = 1;
    errors = (noise ? NE : 0) | (framing_error ? FE : 0) | (hil_usart_parity_wrong(line, word) ? PE : 0);
    *sr |= RXNE;
  }
  *sr |= errors;
  hil_usart_tell_data(usart, word, errors);
  update(usart);
}

static bool wants_idle(const struct hil_usart *usart) {
  return usart->line.idle_armed || (usart->block.registers.values[CR1] & (RWU | WAKE)) == RWU;
}

static void line_idle(struct hil_usart *usart) {
  uint32_t *cr1 = &values(usart)[CR1];
  if (*cr1 & RWU) {
    if (!(*cr1 & WAKE))
      *cr1 &= ~(uint32_t)RWU;
  } else if (usart->line.idle_armed) {
    usart->line.idle_armed = 0;
    flag(usart, IDLE);
  }
}

const struct hil_usart_model hil_usart_f1 = {read, write, loaded, complete, break_sent, read_word, wants_idle, line_idle,
                                             update};
