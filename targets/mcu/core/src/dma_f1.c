/* DMA1 and DMA2: seven and five channels between registers and memory (RM0008 section 13).
 *
 * One transfer at a time. It begins when a channel asks and nothing is under way, and its read and its write happen at
 * its end. Among the channels that asked by the beginning, the highest priority wins, then the lowest number.
 *
 * Choices where the manual is silent:
 *
 * - A transfer takes five AHB cycles, whatever the widths: arbitration, address, read, write, acknowledge (section
 *   13.3.1 names these steps). The CPU is not slowed down by it.
 * - A channel that is enabled begins at CPAR and CMAR. If CNDTR was not written, it goes on with what is left of it, and
 *   circular mode reloads what was written last.
 * - HTIF is set when CNDTR reaches half of its initial value, rounded down.
 * - GIF is set while any other flag of the channel is.
 * - A transfer under way is dropped, without a trace, when its channel is disabled.
 * - CCR may be changed while the channel is enabled; CNDTR, CPAR and CMAR keep their value then, which is noted.
 * - PSIZE and MSIZE of 3 are reserved and taken for 32 bits. */
#include "dma_f1.h"

#include "cpu.h"

#include <stddef.h>
#include <stdlib.h>

enum { MOST_CHANNELS = 7, TRANSFER_CYCLES = 5 };

/* Words of the block: the flags, and from FIRST on those of each channel, of which the last is none. */
enum { ISR, IFCR, FIRST };
enum { CCR, CNDTR, CPAR, CMAR, CHANNEL_WORDS = 5 };

enum { GIF = 1 << 0, TCIF = 1 << 1, HTIF = 1 << 2, TEIF = 1 << 3, FLAGS = TCIF | HTIF | TEIF };
/* CCR; three enables stand at the bit of their flag. */
enum { EN = 1 << 0, DIR = 1 << 4, CIRC = 1 << 5, PINC = 1 << 6, MINC = 1 << 7, PSIZE = 8, MSIZE = 10, PL = 12,
       MEM2MEM = 1 << 14 };

/* levels, once: the request lines that are high, and that ask for one transfer. reload: CNDTR as it was written last.
 * ready: it wants a transfer, since a cycle. peripheral, memory: addresses of the next one. */
struct channel {
  uint32_t levels, once, reload, peripheral, memory;
  uint64_t ready_since;
  bool ready;
};

/* count: of the channels. first_irq, irqs: their interrupts; channels beyond the last one share it. */

struct hil_dma {
  struct hil_block block;    /* first: a block is the controller that it belongs to */
  struct hil_requests requests;
  struct hil_queue *queue;
  struct hil_cpu *cpu;       /* whose memory and interrupts these are; NULL: Python is asked */
  hil_dma_ask ask;
  struct channel channels[MOST_CHANNELS];
  uint32_t count, first_irq, irqs;
  bool irq[MOST_CHANNELS];
  int32_t done;              /* the event at the end of a transfer */
  uint64_t begun;
  bool serving;
};

static uint64_t now(const struct hil_dma *dma) { return hil_time_of(dma->queue)->now; }

static uint32_t *registers(struct hil_dma *dma, uint32_t n) {
  return &dma->block.registers.values[FIRST + CHANNEL_WORDS * n];
}

/* --- flags and interrupts */

static uint32_t flags(const struct hil_dma *dma, uint32_t n) { return dma->block.registers.values[ISR] >> 4 * n & FLAGS; }

/* The interrupt of a channel, counted from the first. */
static uint32_t irq_of(const struct hil_dma *dma, uint32_t n) { return n < dma->irqs ? n : dma->irqs - 1; }

static void set_irq(struct hil_dma *dma, uint32_t irq) {
  bool level = false;
  for (uint32_t other = irq; other < dma->count && irq_of(dma, other) == irq; other++)
    level |= (flags(dma, other) & registers(dma, other)[CCR]) != 0;
  if (level == dma->irq[irq])
    return;
  dma->irq[irq] = level;
  if (dma->cpu)
    hil_drive_line(dma->cpu, FIRST_IRQ + dma->first_irq + irq, level);
  else
    dma->ask(DMA_DRIVES, irq, 0, level);
}

static void drive_irq(struct hil_dma *dma, uint32_t n) { set_irq(dma, irq_of(dma, n)); }

static void flag(struct hil_dma *dma, uint32_t n, uint32_t set) {
  dma->block.registers.values[ISR] |= set << 4 * n;
  drive_irq(dma, n);
}

static uint32_t read_flags(const struct hil_dma *dma) {
  uint32_t word = 0;
  for (uint32_t n = 0; n < dma->count; n++)
    if (flags(dma, n))
      word |= (flags(dma, n) | GIF) << 4 * n;
  return word;
}

/* CGIF clears all flags of a channel. */
static void clear_flags(struct hil_dma *dma, uint32_t value) {
  for (uint32_t n = 0; n < dma->count; n++) {
    uint32_t bits = value >> 4 * n & (GIF | FLAGS);
    dma->block.registers.values[ISR] &= ~((bits & GIF ? FLAGS : bits) << 4 * n);
    drive_irq(dma, n);
  }
}

/* --- who wants a transfer */

static bool wants(struct hil_dma *dma, uint32_t n) {
  const struct channel *channel = &dma->channels[n];
  const uint32_t *r = registers(dma, n);
  return r[CCR] & EN && r[CNDTR] && (r[CCR] & MEM2MEM || channel->levels || channel->once);
}

static bool any_ready(const struct hil_dma *dma) {
  for (uint32_t n = 0; n < dma->count; n++)
    if (dma->channels[n].ready)
      return true;
  return false;
}

/* Begin a transfer, if none is under way and a channel wants one. */
static void proceed(struct hil_dma *dma) {
  if (hil_event_on(dma->queue, dma->done) || dma->serving || !dma->block.registers.clocked || !any_ready(dma))
    return;
  dma->begun = now(dma);
  hil_event_at(dma->queue, dma->done, dma->begun + TRANSFER_CYCLES, 0);
}

/* See whether a channel wants a transfer, after registers or requests have changed. */
static void update(struct hil_dma *dma, uint32_t n) {
  struct channel *channel = &dma->channels[n];
  bool ready = wants(dma, n);
  if (ready == channel->ready)
    return;
  channel->ready = ready;
  if (ready) {
    channel->ready_since = now(dma);
    proceed(dma);
  } else if (dma->begun == now(dma) && !any_ready(dma)) {
    hil_event_off(dma->queue, dma->done); /* a transfer that nobody wants any more at the cycle at which it begins */
  }
}

static struct channel *channel_of(struct hil_dma *dma, uint32_t request) {
  uint32_t number = request >> REQUEST_BITS;
  return number && number <= dma->count ? &dma->channels[number - 1] : NULL;
}

/* Drive a request line; low takes back what it has asked for once. */
HIL_EXPORT void hil_dma_request(struct hil_dma *dma, uint32_t number, bool level) {
  struct channel *channel = channel_of(dma, number);
  uint32_t line = 1u << (number & ((1 << REQUEST_BITS) - 1));
  if (!channel)
    return;
  channel->levels = level ? channel->levels | line : channel->levels & ~line;
  channel->once = level ? channel->once : channel->once & ~line;
  update(dma, (uint32_t)(channel - dma->channels));
}

static void drive_request(struct hil_requests *requests, uint32_t number, bool level) {
  hil_dma_request((struct hil_dma *)((char *)requests - offsetof(struct hil_dma, requests)), number, level);
}

/* Where requests to it go. */
HIL_EXPORT struct hil_requests *hil_dma_requests(struct hil_dma *dma) { return &dma->requests; }

/* Ask for one transfer; kept until one was made. */
HIL_EXPORT void hil_dma_pulse(struct hil_dma *dma, uint32_t number) {
  struct channel *channel = channel_of(dma, number);
  if (!channel)
    return;
  channel->once |= 1u << (number & ((1 << REQUEST_BITS) - 1));
  update(dma, (uint32_t)(channel - dma->channels));
}

/* --- transfers */

/* PSIZE or MSIZE in bytes. */
static uint32_t width(uint32_t control, uint32_t at) {
  static const uint32_t BYTES[] = {1, 2, 4, 4};
  return BYTES[control >> at & 3];
}

static bool fetch(struct hil_dma *dma, uint32_t address, uint32_t size, uint32_t *value) {
  if (dma->cpu && hil_master_load(dma->cpu, address, size, value))
    return true;
  uint64_t answer = dma->ask(DMA_READS, address, size, 0);
  *value = (uint32_t)answer;
  return answer != DMA_FAILS;
}

static bool store(struct hil_dma *dma, uint32_t address, uint32_t size, uint32_t value) {
  return (dma->cpu && hil_master_store(dma->cpu, address, size, value)) ||
         dma->ask(DMA_WRITES, address, size, value) != DMA_FAILS;
}

/* Copy one item: it is filled with zeros if the target is wider, cut if it is narrower (table 77). */
static bool move(struct hil_dma *dma, uint32_t source, uint32_t source_size, uint32_t target, uint32_t target_size) {
  uint32_t value;
  if (!fetch(dma, source & -source_size, source_size, &value))
    return false;
  if (target_size < 4)
    value &= (1u << 8 * target_size) - 1;
  return store(dma, target & -target_size, target_size, value);
}

static void start(struct hil_dma *dma, uint32_t n) {
  dma->channels[n].peripheral = registers(dma, n)[CPAR];
  dma->channels[n].memory = registers(dma, n)[CMAR];
}

static void count(struct hil_dma *dma, uint32_t n, uint32_t control) {
  uint32_t *r = registers(dma, n), reload = dma->channels[n].reload;
  uint32_t left = (r[CNDTR] - 1) & 0xFFFF, reached = left == reload >> 1 ? HTIF : 0;
  if (!left) {
    reached |= TCIF;
    if (control & CIRC && !(control & MEM2MEM)) {
      left = reload;
      start(dma, n);
    }
  }
  r[CNDTR] = left;
  if (reached)
    flag(dma, n, reached);
}

static void serve(struct hil_dma *dma, uint32_t n) {
  struct channel *channel = &dma->channels[n];
  uint32_t control = registers(dma, n)[CCR], peripheral_size = width(control, PSIZE), memory_size = width(control, MSIZE);
  channel->once = 0;
  bool done = control & DIR ? move(dma, channel->memory, memory_size, channel->peripheral, peripheral_size)
                            : move(dma, channel->peripheral, peripheral_size, channel->memory, memory_size);
  if (!done) {
    registers(dma, n)[CCR] = control & ~(uint32_t)EN;
    flag(dma, n, TEIF);
    return;
  }
  if (control & PINC)
    channel->peripheral += peripheral_size;
  if (control & MINC)
    channel->memory += memory_size;
  count(dma, n, control);
}

/* The channel whose turn it is, or as many as there are. */
static uint32_t chosen(struct hil_dma *dma) {
  uint32_t best = dma->count, priority = 0;
  for (uint32_t n = 0; n < dma->count; n++) {
    uint32_t own = registers(dma, n)[CCR] >> PL & 3;
    if (!dma->channels[n].ready || dma->channels[n].ready_since > dma->begun)
      continue;
    if (best == dma->count || own > priority) {
      best = n;
      priority = own;
    }
  }
  return best;
}

static void on_done(void *whose) {
  struct hil_dma *dma = whose;
  if (!dma->block.registers.clocked)
    return;
  uint32_t n = chosen(dma);
  if (n < dma->count) {
    dma->channels[n].ready = false;
    dma->serving = true;
    serve(dma, n);
    dma->serving = false;
    update(dma, n);
  }
  proceed(dma);
}

/* --- registers */

static void check(struct hil_dma *dma, uint32_t n, uint32_t control) {
  const uint32_t *r = registers(dma, n);
  if (r[CPAR] & (width(control, PSIZE) - 1))
    dma->ask(DMA_NOTES, n, CPAR, NOTE_UNALIGNED);
  if (r[CMAR] & (width(control, MSIZE) - 1))
    dma->ask(DMA_NOTES, n, CMAR, NOTE_UNALIGNED);
  if (control & MEM2MEM && control & CIRC)
    dma->ask(DMA_NOTES, n, CCR, NOTE_ROUND);
}

static void write_control(struct hil_dma *dma, uint32_t n, uint32_t value) {
  uint32_t before = registers(dma, n)[CCR];
  registers(dma, n)[CCR] = value;
  if (value & EN && !(before & EN)) {
    check(dma, n, value);
    start(dma, n);
  }
  drive_irq(dma, n);
  update(dma, n);
}

static bool read(struct hil_block *block, uint32_t word, uint32_t *value) {
  struct hil_dma *dma = (struct hil_dma *)block;
  if (word >= FIRST && (word >= FIRST + CHANNEL_WORDS * dma->count || (word - FIRST) % CHANNEL_WORDS > CMAR))
    return false;
  *value = word == ISR ? read_flags(dma) : word == IFCR ? 0 : block->registers.values[word];
  return true;
}

static bool write(struct hil_block *block, uint32_t word, uint32_t value) {
  struct hil_dma *dma = (struct hil_dma *)block;
  value &= block->registers.writable[word];
  if (word == ISR)
    return true;
  if (word == IFCR) {
    clear_flags(dma, value);
    return true;
  }
  uint32_t n = (word - FIRST) / CHANNEL_WORDS, what = (word - FIRST) % CHANNEL_WORDS;
  if (n >= dma->count || what > CMAR)
    return false;
  uint32_t *r = registers(dma, n);
  if (what == CCR) {
    write_control(dma, n, value);
  } else if (r[CCR] & EN) {
    dma->ask(DMA_NOTES, n, what, NOTE_PROTECTED);
  } else {
    r[what] = value;
    if (what == CNDTR)
      dma->channels[n].reload = value;
  }
  return true;
}

/* --- the controller */

/* Go to the state after reset; requests are not its own. */
HIL_EXPORT void hil_dma_reset(struct hil_dma *dma) {
  hil_event_off(dma->queue, dma->done);
  for (uint32_t word = 0; word < FIRST + CHANNEL_WORDS * dma->count; word++)
    dma->block.registers.values[word] = 0;
  for (uint32_t n = 0; n < dma->count; n++) {
    struct channel *channel = &dma->channels[n];
    channel->reload = channel->peripheral = channel->memory = 0;
    channel->ready = false;
    drive_irq(dma, n);
  }
}

/* Reach the memory and drive the interrupts of a core without asking Python. */
HIL_EXPORT void hil_dma_join(struct hil_dma *dma, struct hil_cpu *cpu) { dma->cpu = cpu; }

HIL_EXPORT void hil_dma_free(struct hil_dma *dma) { free(dma); }

static const struct hil_saved SAVED = {.size = sizeof(struct hil_dma)};

/* Give the first `irqs` channels an interrupt each from now on. */
HIL_EXPORT void hil_dma_share(struct hil_dma *dma, uint32_t irqs) {
  uint32_t most = irqs > dma->irqs ? irqs : dma->irqs;
  dma->irqs = irqs;
  for (uint32_t irq = 0; irq < most; irq++)
    set_irq(dma, irq);
}

/* Make a controller of `count` channels. The first `irqs` have an interrupt each, from `first_irq` on, and the others
 * share the last of these. Returns NULL if there is no memory left. */
HIL_EXPORT struct hil_dma *hil_dma_new(struct hil_queue *queue, hil_dma_ask ask, uint32_t count, uint32_t first_irq,
                                       uint32_t irqs) {
  struct hil_dma *dma = calloc(1, sizeof *dma);
  if (!dma)
    return NULL;
  dma->queue = queue;
  dma->ask = ask;
  dma->count = count;
  dma->first_irq = first_irq;
  dma->irqs = irqs;
  dma->requests.drive = drive_request;
  dma->block.read = read;
  dma->block.write = write;
  dma->block.saved = &SAVED;
  dma->block.on_ahb = true;
  dma->done = hil_event_new(queue, on_done, dma);
  if (dma->done == NO_EVENT) {
    free(dma);
    return NULL;
  }
  return dma;
}
