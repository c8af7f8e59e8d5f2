/* ISR, ICR, RDR and TDR of a USART, what the control registers make of them, and the FIFOs behind RDR and TDR
 * (RM0410 section 34.8 on the STM32F7; RM0433 section 48.7 with FIFOs, on the STM32H7).
 *
 * Choices where the manuals are silent:
 *
 * - While ORE is set, words go on coming in as soon as RXNE is clear; of a word that is lost, ORE is the only flag.
 * - IDLE needs a word that has set RXNE before it, also the first time.
 * - The end of the preamble does not set TC.
 * - With MSBFIRST the data bits are turned round and the parity bit stays the last one.
 * - TXFT is clear while UE is, as the value after reset has it.
 * - TXFE that was cleared by TXFECF is set again when the FIFO becomes empty the next time.
 *
 * The model has no FIFO where CR1.FIFOEN cannot be set. */
#include "usart.h"

enum { CR1, CR2, CR3, BRR, GTPR, RTOR, RQR, ISR, ICR, RDR, TDR };

/* ISR. */
enum {
  PE = 1 << 0, FE = 1 << 1, NF = 1 << 2, ORE = 1 << 3, IDLE = 1 << 4, RXNE = 1 << 5, TC = 1 << 6, TXE = 1 << 7,
  LBDF = 1 << 8, CTSIF = 1 << 9, RTOF = 1 << 11, CMF = 1 << 17, SBKF = 1 << 18, RWU = 1 << 19,
  TXFE = 1 << 23, RXFF = 1 << 24, TCBGT = 1 << 25, RXFT = 1 << 26, TXFT = 1 << 27,
};
enum { FIFO_LEVELS = RXNE | TXE | RXFF | RXFT | TXFT };
/* CR1; four enables stand at the bit of their flag in ISR. */
enum {
  UE = 1 << 0, SAME_BIT = IDLE | RXNE | TC | TXE, RXNEIE = RXNE, PEIE = 1 << 8, WAKE = 1 << 11,
  MME = 1 << 13, CMIE = 1 << 14, RTOIE = 1 << 26, FIFOEN = 1 << 29, TXFEIE = 1 << 30,
};
#define RXFFIE (1u << 31)
enum { ADDM7 = 1 << 4, LBDIE = 1 << 6, DATAINV = 1 << 18, MSBFIRST = 1 << 19 };                  /* CR2 */
enum {                                                                                         /* CR3 */
  EIE = 1 << 0, DMAR = 1 << 6, DMAT = 1 << 7, RTSE = 1 << 8, CTSIE = 1 << 10, OVRDIS = 1 << 12, DDRE = 1 << 13,
  TXFTIE = 1 << 23, RXFTCFG = 25, RXFTIE = 1 << 28, TXFTCFG = 29,
};
enum { TXFECF = 1 << 5, TCBGTCF = 1 << 7 };                                                    /* ICR */
enum { CLEARED_BY_ICR = 0x00121B5F }; /* the bits of ICR that stand at those of their flags */

enum { RX_WORDS = 17, TX_WORDS = 16 }; /* RDR and TDR are places as well */

/* Bits that change nothing but the lines to interrupt and DMA, and the thresholds of the FIFOs. */
static const uint32_t ENABLES[] = {
    [CR1] = SAME_BIT | PEIE | CMIE | RTOIE | TXFEIE | RXFFIE,
    [CR2] = LBDIE,
    [CR3] = EIE | DMAR | DMAT | CTSIE | TXFTIE | RXFTIE | 7u << RXFTCFG | 7u << TXFTCFG,
};

static uint32_t *values(struct hil_usart *usart) { return usart->block.registers.values; }

/* --- FIFOs */

static bool has_fifos(const struct hil_usart *usart) { return usart->block.registers.values[CR1] & FIFOEN; }

static void push(struct hil_fifo *fifo, uint32_t *count, uint32_t word, uint32_t errors) {
  uint32_t place = (fifo->first + (*count)++) % FIFO_PLACES;
  fifo->words[place] = word;
  fifo->errors[place] = errors;
}

static uint32_t pop(struct hil_fifo *fifo, uint32_t *count) {
  (*count)--;
  return fifo->words[fifo->first++ % FIFO_PLACES];
}

/* Words received, or places that are empty, by RXFTCFG and TXFTCFG. */
static uint32_t threshold(uint32_t field) {
  static const uint32_t THRESHOLDS[] = {2, 4, 8, 12, 14, 16, 16, 16};
  return THRESHOLDS[field & 7];
}

static uint32_t fifo_levels(const struct hil_usart *usart) {
  const struct hil_line *line = &usart->line;
  const uint32_t *r = usart->block.registers.values;
  /* With OVRDIS the FIFO is passed by: RXNE tells of RDR alone (RM0433, USART_CR3). */
  uint32_t received = line->unread ? line->unread : !!(r[ISR] & RXNE);
  uint32_t empty = TX_WORDS - line->unsent - line->holds;
  return (received ? RXNE : 0) | (received == RX_WORDS ? RXFF : 0) |
         (received >= threshold(r[CR3] >> RXFTCFG) ? RXFT : 0) | (empty ? TXE : 0) |
         (r[CR1] & UE && empty >= threshold(r[CR3] >> TXFTCFG) ? TXFT : 0);
}

/* Whether the next word would be lost. */
static bool is_full(struct hil_usart *usart) {
  const uint32_t *r = values(usart);
  return has_fifos(usart) && !(r[CR3] & OVRDIS) ? usart->line.unread == RX_WORDS : r[ISR] & RXNE;
}

/* --- lines */

/* The flags that ask for an interrupt. */
static uint32_t interrupting(const uint32_t *r) {
  uint32_t cr1 = r[CR1], cr3 = r[CR3];
  return (cr1 & SAME_BIT) | (cr1 & RXNEIE ? ORE : 0) | (cr1 & PEIE ? PE : 0) | (cr3 & EIE ? FE | NF | ORE : 0) |
         (cr3 & CTSIE ? CTSIF : 0) | (r[CR2] & LBDIE ? LBDF : 0) | (cr1 & RTOIE ? RTOF : 0) | (cr1 & CMIE ? CMF : 0) |
         (cr1 & TXFEIE ? TXFE : 0) | (cr1 & RXFFIE ? RXFF : 0) | (cr3 & RXFTIE ? RXFT : 0) | (cr3 & TXFTIE ? TXFT : 0);
}

static void update(struct hil_usart *usart) {
  uint32_t *r = values(usart);
  if (has_fifos(usart))
    r[ISR] = (r[ISR] & ~(uint32_t)FIFO_LEVELS) | fifo_levels(usart);
  uint32_t isr = r[ISR], cr3 = r[CR3];
  bool irq = isr & interrupting(r), refused = cr3 & DDRE && isr & (PE | FE | NF | ORE);
  if (cr3 & RTSE)
    usart->tell(NEWS_RTS, is_full(usart), 0);
  hil_usart_drive(usart, irq | (cr3 & DMAT && isr & TXE) << 1 | (cr3 & DMAR && isr & RXNE && !refused) << 2);
}

static void flag(struct hil_usart *usart, uint32_t flags) {
  values(usart)[ISR] |= flags;
  update(usart);
}

/* --- sending */

static void loaded(struct hil_usart *usart) {
  struct hil_line *line = &usart->line;
  if (line->unsent) {
    line->holding = pop(&usart->to_send, &line->unsent);
    line->holds = 1;
  } else if (has_fifos(usart)) {
    values(usart)[ISR] |= TXFE;
  }
  flag(usart, TXE);
}

static void complete(struct hil_usart *usart) { flag(usart, TC); }

static void break_sent(struct hil_usart *usart) { values(usart)[ISR] &= ~(uint32_t)SBKF; }

/* The data bits the other way round, if they are sent so. */
static uint32_t turned(struct hil_usart *usart, uint32_t data) {
  uint32_t bits = usart->line.data_bits, result = 0;
  if (!(values(usart)[CR2] & MSBFIRST))
    return data;
  for (uint32_t n = 0; n < bits; n++)
    result |= (data >> n & 1) << (bits - 1 - n);
  return result;
}

static uint32_t inverted(struct hil_usart *usart, uint32_t word) {
  return values(usart)[CR2] & DATAINV ? ~word & ((1u << usart->line.word_bits) - 1) : word;
}

/* Put a word at the end of what is to be sent; false: it is lost, and Python says so. */
static bool write_data(struct hil_usart *usart, uint32_t value) {
  struct hil_line *line = &usart->line;
  uint32_t *r = values(usart), word = inverted(usart, hil_usart_word(line, turned(usart, value)));
  if (!(r[CR1] & UE))
    return false;
  if (has_fifos(usart) && line->holds) {
    if (line->unsent + 1 == TX_WORDS)
      return false;
    push(&usart->to_send, &line->unsent, word, 0);
  } else {
    r[TDR] = value;
    r[ISR] &= ~(uint32_t)(TXE | TC | TXFE);
    hil_usart_put(usart, word);
  }
  update(usart);
  return true;
}

/* --- receiving */

/* Data, and parity as the most significant bit, from the bits on the line. */
static uint32_t decoded(struct hil_usart *usart, uint32_t bits) {
  uint32_t word = inverted(usart, bits), data = hil_usart_data(&usart->line, word);
  return (word ^ data) | turned(usart, data);
}

static void show_first(struct hil_usart *usart) {
  const struct hil_fifo *fifo = &usart->received;
  uint32_t place = fifo->first % FIFO_PLACES;
  values(usart)[RDR] = fifo->words[place];
  values(usart)[ISR] |= RXNE | fifo->errors[place];
}

/* Put a word where RDR finds it, with the flags that tell of it; false: there is no room. */
static bool keep(struct hil_usart *usart, uint32_t word, uint32_t errors) {
  uint32_t *r = values(usart);
  if (is_full(usart) && !(r[CR3] & OVRDIS))
    return false;
  if (has_fifos(usart) && !(r[CR3] & OVRDIS)) {
    push(&usart->received, &usart->line.unread, word, errors);
    if (usart->line.unread == 1)
      show_first(usart);
  } else {
    r[RDR] = word;
    r[ISR] |= RXNE | errors;
  }
  return true;
}

/* Whether mute mode hides a word; if the word is an address, the mode is entered or left. */
static bool is_muted_for(struct hil_usart *usart, uint32_t word) {
  uint32_t *r = values(usart), top = usart->line.data_bits - 1;
  if (!(r[CR1] & MME))
    return false;
  if (!(r[CR1] & WAKE) || !(word >> top & 1))
    return r[ISR] & RWU;
  uint32_t compared = r[CR2] & ADDM7 ? (1u << top) - 1 : 0xF;
  bool is_mine = !((word ^ r[CR2] >> 24) & compared);
  r[ISR] = is_mine ? r[ISR] & ~(uint32_t)RWU : r[ISR] | RWU;
  return !is_mine;
}

static void read_word(struct hil_usart *usart, uint32_t bits, bool noise, bool framing_error) {
  struct hil_line *line = &usart->line;
  uint32_t *r = values(usart), word = decoded(usart, bits);
  if (is_muted_for(usart, word))
    return;
  uint32_t errors = (noise ? NF : 0) | (framing_error ? FE : 0) | (hil_usart_parity_wrong(line, word) ? PE : 0);
  if (keep(usart, word, errors)) {
    line->idle_armed = 1;
  } else {
    errors = ORE;
    r[ISR] |= ORE;
  }
  if (hil_usart_data(line, word) == r[CR2] >> 24)
    r[ISR] |= CMF;
  hil_usart_tell_data(usart, word, errors);
  update(usart);
}

/* The oldest word; the next one follows. */
static uint32_t read_data(struct hil_usart *usart) {
  struct hil_line *line = &usart->line;
  uint32_t *r = values(usart), word = r[RDR];
  r[ISR] &= ~(uint32_t)RXNE;
  if (line->unread) {
    pop(&usart->received, &line->unread);
    if (line->unread) {
      show_first(usart);
      hil_queue_cut(usart->queue); /* the next read gives another word: this is no loop to pass over */
    }
  }
  update(usart);
  return word;
}

static bool wants_idle(const struct hil_usart *usart) {
  const uint32_t *r = usart->block.registers.values;
  return usart->line.idle_armed || (r[ISR] & RWU && !(r[CR1] & WAKE));
}

static void line_idle(struct hil_usart *usart) {
  uint32_t *r = values(usart);
  if (r[ISR] & RWU) {
    if (!(r[CR1] & WAKE))
      r[ISR] &= ~(uint32_t)RWU;
  } else if (usart->line.idle_armed) {
    usart->line.idle_armed = 0;
    flag(usart, IDLE);
  }
}

/* --- registers; those that change more than flags and enables are Python's */

static bool read(struct hil_block *block, uint32_t word, uint32_t *value) {
  struct hil_usart *usart = (struct hil_usart *)block;
  if (word == RDR)
    *value = read_data(usart);
  else if ((word <= RTOR && block->registers.writable[word]) || word == TDR) /* which a UART may lack */
    *value = values(usart)[word];
  else
    return false;
  return true;
}

static bool write_control(struct hil_usart *usart, uint32_t word, uint32_t value) {
  uint32_t *r = values(usart), changed = value ^ r[word];
  if (changed & ~ENABLES[word])
    return false;
  r[word] = value;
  if (changed)
    update(usart);
  return true;
}

static bool write(struct hil_block *block, uint32_t word, uint32_t value) {
  struct hil_usart *usart = (struct hil_usart *)block;
  struct hil_registers *registers = &block->registers;
  if (word > TDR || value & registers->ignored[word] & ~registers->values[word])
    return false;
  uint32_t writable = registers->writable[word], *r = registers->values;
  if (word == TDR)
    return write_data(usart, value & writable);
  if (word <= CR3)
    return write_control(usart, word, (value & writable) | (r[word] & ~writable));
  if (word != ICR)
    return false;
  value &= writable;
  r[ISR] &= ~((value & CLEARED_BY_ICR) | (value & TXFECF ? TXFE : 0) | (value & TCBGTCF ? TCBGT : 0));
  update(usart);
  return true;
}

const struct hil_usart_model hil_usart_isr = {read, write, loaded, complete, break_sent, read_word, wants_idle, line_idle,
                                              update};
