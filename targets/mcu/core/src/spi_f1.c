/* SPI1 to SPI3 of the STM32F1: registers and flags, master and slave (RM0008 section 25).
 *
 * A word that is written while nothing is under way begins at once, so TXE stays set. RXNE rises at the end of its last
 * clock, where the next word begins if there is one. How a word goes over the wires: spi_words.c.
 *
 * Choices where the manual is silent:
 *
 * - SPE that is cleared in the middle of a word lets it end, as the manual's procedure for receive-only mode needs it;
 *   the pins are let go then. MSTR that is cleared, by a mode fault too, breaks the word off.
 * - NSS that is no pin's is low, as a floating pin reads.
 * - CRC in a receive-only mode: the word after CRCNEXT was set is taken as the CRC. */
#include "spi_f1.h"

#include "cpu.h"

#include <stdlib.h>

enum { CR1, CR2, SR, DR, CRCPR, RXCRCR, TXCRCR, I2SCFGR };

enum { CPHA = 1 << 0, CPOL = 1 << 1, MSTR = 1 << 2, BR = 3, SPE = 1 << 6, LSBFIRST = 1 << 7, SSI = 1 << 8, SSM = 1 << 9,
       RXONLY = 1 << 10, DFF = 1 << 11, CRCNEXT = 1 << 12, CRCEN = 1 << 13, BIDIOE = 1 << 14, BIDIMODE = 1 << 15 }; /* CR1 */
enum { RXDMAEN = 1 << 0, TXDMAEN = 1 << 1, SSOE = 1 << 2, ERRIE = 1 << 5, RXNEIE = 1 << 6, TXEIE = 1 << 7 }; /* CR2 */
enum { RXNE = 1 << 0, TXE = 1 << 1, CRCERR = 1 << 4, MODF = 1 << 5, OVR = 1 << 6, BSY = 1 << 7 };             /* SR */
enum { I2SMOD = 1 << 11 };

static uint32_t *values(struct hil_spi *spi) { return spi->block.registers.values; }

static void note(const struct hil_spi *spi, enum hil_spi_note note) { spi->ask(SPI_NOTES, note); }

/* --- what it is */

static bool is_i2s(const struct hil_spi *spi) { return spi->block.registers.values[I2SCFGR] & I2SMOD; }

static bool is_master(const struct hil_spi *spi) {
  return (spi->block.registers.values[CR1] & (SPE | MSTR)) == (SPE | MSTR) && !is_i2s(spi);
}

static bool receives_only(uint32_t control) { return control & BIDIMODE ? !(control & BIDIOE) : control & RXONLY; }

static bool transmits_only(uint32_t control) { return (control & (BIDIMODE | BIDIOE)) == (BIDIMODE | BIDIOE); }

bool hil_spi_wants_what_comes_in(const struct hil_spi *spi) {
  uint32_t control = spi->block.registers.values[CR1];
  return !transmits_only(control) || control & CRCEN;
}

static uint32_t bits_of(uint32_t control) { return control & DFF ? 16 : 8; }

static uint32_t mask_of(uint32_t control) { return (1u << bits_of(control)) - 1; }

/* BSY stays low while one wire receives (section 25.3.7). */
static bool shows_busy(const struct hil_spi *spi) {
  return spi->busy && (spi->block.registers.values[CR1] & (BIDIMODE | BIDIOE)) != BIDIMODE;
}

/* --- lines */

/* Drive interrupt and requests from flags and enables; Python may do so again before this returns. */
static void update(struct hil_spi *spi) {
  const uint32_t *r = values(spi);
  uint32_t sr = r[SR], cr2 = r[CR2];
  bool irq = (sr & TXE && cr2 & TXEIE) || (sr & RXNE && cr2 & RXNEIE) || (sr & (OVR | MODF | CRCERR) && cr2 & ERRIE);
  bool asks[] = {sr & TXE && cr2 & TXDMAEN, sr & RXNE && cr2 & RXDMAEN};
  if (irq != spi->interrupts) {
    spi->interrupts = irq;
    if (spi->cpu)
      hil_drive_line(spi->cpu, FIRST_IRQ + spi->irq, irq);
    else
      spi->ask(SPI_DRIVES, irq);
  }
  for (int n = 1; n >= 0; n--) {
    if (spi->requests)
      spi->requests->drive(spi->requests, spi->lines[n], asks[n]);
    else
      spi->ask(SPI_REQUESTS_TX + n, asks[n]);
  }
}

/* --- CRC (section 25.3.6) */

static uint32_t crc_of(uint32_t crc, uint32_t word, uint32_t polynomial, uint32_t control) {
  uint32_t bits = bits_of(control), mask = mask_of(control);
  for (uint32_t bit = bits; bit--;) {
    uint32_t flips = (crc >> (bits - 1) ^ word >> bit) & 1;
    crc = (crc << 1 ^ (flips ? polynomial : 0)) & mask;
  }
  return crc;
}

/* DMA has nothing more to send: then the CRC follows by itself (section 25.3.7). */
static bool last_of_dma(struct hil_spi *spi) { return values(spi)[CR2] & TXDMAEN && !spi->ask(SPI_LEFT, 0); }

/* --- words */

/* The lowest bits the other way round. */
static uint32_t reversed(uint32_t word, uint32_t bits) {
  uint32_t found = 0;
  for (uint32_t bit = 0; bit < bits; bit++)
    found |= (word >> bit & 1) << (bits - 1 - bit);
  return found;
}

static uint32_t in_order(uint32_t control, uint32_t word) {
  return control & LSBFIRST ? reversed(word, bits_of(control)) : word & mask_of(control);
}

static bool take_next(struct hil_spi *spi, uint32_t *word) {
  if (!spi->has_word)
    return false;
  spi->has_word = false;
  *word = spi->waiting;
  values(spi)[SR] |= TXE;
  return true;
}

static void begin(struct hil_spi *spi, uint32_t word, bool drives) {
  struct hil_spi_wires *wires = &spi->wires;
  uint32_t control = values(spi)[CR1];
  if (!wires->clock_cycles)
    wires->clock_cycles = spi->ask(SPI_CLOCK, 0);
  spi->busy = true;
  spi->sent = word;
  wires->bits = in_order(control, word);
  wires->count = bits_of(control);
  wires->half_cycles = wires->clock_cycles << (control >> BR & 7);
  wires->cpha = control & CPHA ? 1 : 0;
  wires->drives = drives;
  wires->one_wire = control & BIDIMODE ? 1 : 0;
  hil_spi_send(spi);
}

/* Begin the next word, if there is one and none is under way. */
static void proceed(struct hil_spi *spi) {
  uint32_t word;
  if (spi->busy || !is_master(spi))
    return;
  if (receives_only(values(spi)[CR1]))
    begin(spi, 0, false);
  else if (take_next(spi, &word))
    begin(spi, word, true);
}

static void keep(struct hil_spi *spi, uint32_t word) {
  uint32_t *r = values(spi);
  if (r[SR] & RXNE) {
    r[SR] |= OVR;
    spi->read_dr = false;
  } else {
    r[DR] = word;
    r[SR] |= RXNE;
  }
}

/* A word was sent, and another received meanwhile. */
static void word_over(struct hil_spi *spi, uint32_t word, uint32_t received) {
  uint32_t *r = values(spi), control = r[CR1];
  if (control & CRCEN && spi->crc_word) {
    spi->crc_word = false;
    if (!transmits_only(control) && received != r[RXCRCR])
      r[SR] |= CRCERR;
  } else if (control & CRCEN) {
    r[TXCRCR] = crc_of(r[TXCRCR], word, r[CRCPR], control);
    r[RXCRCR] = crc_of(r[RXCRCR], received, r[CRCPR], control);
    if (!spi->has_word && (spi->crc_next || last_of_dma(spi))) {
      spi->crc_next = false;
      spi->crc_word = true;
      r[CR1] &= ~(uint32_t)CRCNEXT;
      if (!receives_only(control)) {
        spi->waiting = r[TXCRCR];
        spi->has_word = true;
      }
    }
  }
  if (!transmits_only(control))
    keep(spi, received);
}

/* --- what the pins are for */

/* NSS is low, by the pin or by software. */
static bool is_selected(struct hil_spi *spi) {
  uint32_t control = values(spi)[CR1];
  if (control & SSM)
    return !(control & SSI);
  return !(values(spi)[CR2] & SSOE) && !spi->ask(SPI_NSS, 0);
}

/* Have the pins follow; and look whether another master has taken the bus. */
static void configure(struct hil_spi *spi) {
  uint32_t *r = values(spi), control = r[CR1];
  bool drives_nss = r[CR2] & SSOE && !(control & SSM);
  spi->ask(SPI_LISTENS, control & SPE && !(control & SSM) && !drives_nss);
  if (is_master(spi) && is_selected(spi)) {
    r[SR] |= MODF;
    r[CR1] &= ~(uint32_t)(SPE | MSTR);
  }
  if (is_master(spi)) {
    spi->cpol = control & CPOL ? 1 : 0;
    spi->ask(SPI_IDLES, spi->cpol | (drives_nss ? 2 : 0));
  } else if (!(spi->busy && r[CR1] & MSTR)) {
    spi->busy = false;
    spi->ask(SPI_RELEASES, 0);
  }
}

/* NSS has fallen. */
HIL_EXPORT void hil_spi_deselected(struct hil_spi *spi) {
  uint32_t *r = values(spi);
  if (!is_master(spi))
    return;
  r[SR] |= MODF;
  r[CR1] &= ~(uint32_t)(SPE | MSTR);
  configure(spi);
  update(spi);
}

/* The word under way has ended; DFF may have changed meanwhile. */
void hil_spi_ended(struct hil_spi *spi, uint32_t received) {
  uint32_t control = values(spi)[CR1];
  spi->busy = false;
  word_over(spi, spi->sent, in_order(control, received));
  if (!is_master(spi))
    configure(spi);
  proceed(spi);
  update(spi);
}

/* A slave is clocked through a word, now; what stood on MISO, or UINT64_MAX: it is none that is switched on and selected,
 * or one that does not send. */
HIL_EXPORT uint64_t hil_spi_exchange(struct hil_spi *spi, uint32_t bits) {
  uint32_t *r = values(spi), control = r[CR1], sent;
  if ((control & (SPE | MSTR)) != SPE || is_i2s(spi) || !is_selected(spi))
    return UINT64_MAX;
  if (!take_next(spi, &sent))
    sent = r[DR];
  word_over(spi, sent, in_order(control, bits));
  update(spi);
  if (!transmits_only(control) && control & (RXONLY | BIDIMODE))
    return UINT64_MAX;
  return control & LSBFIRST ? reversed(sent, bits_of(control)) : sent;
}

/* --- registers */

static uint32_t read_status(struct hil_spi *spi) {
  uint32_t *sr = &values(spi)[SR], value = *sr | (shows_busy(spi) ? BSY : 0);
  if (*sr & OVR && spi->read_dr) {
    *sr &= ~(uint32_t)OVR;
    update(spi);
  }
  spi->read_dr = false;
  spi->saw_modf |= (value & MODF) != 0;
  return value;
}

static uint32_t read_data(struct hil_spi *spi) {
  values(spi)[SR] &= ~(uint32_t)RXNE;
  spi->read_dr = true;
  update(spi);
  return values(spi)[DR];
}

static bool read(struct hil_block *block, uint32_t word, uint32_t *value) {
  struct hil_spi *spi = (struct hil_spi *)block;
  if (word > TXCRCR)
    return false;
  *value = word == SR ? read_status(spi) : word == DR ? read_data(spi) : values(spi)[word];
  return true;
}

static void write_data(struct hil_spi *spi, uint32_t value) {
  if (spi->has_word)
    note(spi, NOTE_LOST);
  spi->waiting = value & mask_of(values(spi)[CR1]);
  spi->has_word = true;
  values(spi)[SR] &= ~(uint32_t)TXE;
  proceed(spi);
  update(spi);
}

/* Switch on and off, be master or slave, begin a CRC anew. */
static void write_control(struct hil_spi *spi, uint32_t value) {
  uint32_t *r = values(spi), before = r[CR1], rising = value & ~before;
  if (r[SR] & MODF) {
    if (spi->saw_modf)
      r[SR] &= ~(uint32_t)MODF;
    else
      value &= ~(uint32_t)(SPE | MSTR);
    rising = value & ~before;
  }
  spi->saw_modf = false;
  if ((value ^ before) & (DFF | CRCEN) && before & value & SPE)
    note(spi, NOTE_LOCKED);
  if (rising & SPE && !(value & MSTR))
    note(spi, NOTE_NO_CLOCK);
  if (rising & CRCNEXT && value & CRCEN && is_master(spi) && !spi->busy)
    note(spi, NOTE_LATE_CRCNEXT);
  r[CR1] = value;
  if (!(value & before & CRCEN))
    r[RXCRCR] = r[TXCRCR] = 0;
  spi->crc_next = value & CRCNEXT && (spi->crc_next || !(before & CRCNEXT));
  configure(spi);
  proceed(spi);
  update(spi);
}

static bool write(struct hil_block *block, uint32_t word, uint32_t value) {
  struct hil_spi *spi = (struct hil_spi *)block;
  uint32_t *r = values(spi), writable = block->registers.writable[word];
  if (word > TXCRCR)
    return false;
  value = (value & writable) | (r[word] & ~writable);
  if (word == CR1) {
    write_control(spi, value);
  } else if (word == DR) {
    write_data(spi, value);
  } else if (word == CR2) {
    r[CR2] = value;
    configure(spi);
    update(spi);
  } else if (word == SR) { /* CRCERR is cleared where a 0 was written; a write counts as an access for MODF, too */
    r[SR] &= value | ~(uint32_t)CRCERR;
    spi->saw_modf |= (r[SR] & MODF) != 0;
    update(spi);
  } else {
    r[word] = value;
  }
  return true;
}

/* --- the interface */

/* Go to the state after reset, once the registers have their values; a word under way is lost. */
HIL_EXPORT void hil_spi_reset(struct hil_spi *spi) {
  spi->busy = spi->read_dr = spi->saw_modf = spi->crc_next = spi->has_word = spi->crc_word = false;
  spi->ask(SPI_RELEASES, 0);
  spi->ask(SPI_LISTENS, 0);
  update(spi);
}

HIL_EXPORT struct hil_spi_wires *hil_spi_wires_of(struct hil_spi *spi) { return &spi->wires; }

/* Drive an interrupt of a core without asking Python, */
HIL_EXPORT void hil_spi_interrupts(struct hil_spi *spi, struct hil_cpu *cpu, uint32_t irq) {
  spi->cpu = cpu;
  spi->irq = irq;
}

/* and requests to DMA, to send and of what was received. */
HIL_EXPORT void hil_spi_transfers(struct hil_spi *spi, struct hil_requests *requests, uint32_t to_send,
                                  uint32_t received) {
  spi->requests = requests;
  spi->lines[0] = to_send;
  spi->lines[1] = received;
}

HIL_EXPORT void hil_spi_free(struct hil_spi *spi) { free(spi); }

static const struct hil_saved SAVED = {.size = sizeof(struct hil_spi)};

/* Make an interface. Returns NULL if there is no memory left. */
HIL_EXPORT struct hil_spi *hil_spi_new(struct hil_queue *queue, hil_spi_ask ask) {
  struct hil_spi *spi = calloc(1, sizeof *spi);
  if (!spi)
    return NULL;
  spi->block.saved = &SAVED;
  spi->block.read = read;
  spi->block.write = write;
  spi->queue = queue;
  spi->ask = ask;
  spi->end = hil_event_new(queue, hil_spi_on_end, spi);
  if (spi->end == NO_EVENT) {
    free(spi);
    return NULL;
  }
  return spi;
}
