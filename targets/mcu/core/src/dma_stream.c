/* A DMA controller with eight streams, as in the STM32F2, F4, F7 and H7 (RM0410 section 8).
 *
 * Data comes in at one of two ports and goes out at the other, through a FIFO of four words; which is which depends on
 * the direction, and NDTR counts items at the peripheral port. Each port serves one stream at a time: an access begins
 * when a stream wants one and nothing is under way, and happens at its end. Among the streams that asked by the
 * beginning, the highest priority wins, then the lowest number (section 8.3.5).
 *
 * Choices where the manual is silent:
 *
 * - An access takes five AHB cycles at the peripheral port and four at the memory port, whatever is accessed, and one
 *   more for each further beat of a burst (AN4031 names the steps: arbitration, address, bus matrix, data). The CPU is
 *   not slowed down by it.
 * - At the end of a round in circular or double-buffer mode, the next one begins when the FIFO is empty.
 * - HTIF is set when what has arrived at the destination is at least half of NDTR items, rounded up.
 * - Bytes that are left over because NDTR times PSIZE is no multiple of MSIZE are written with zeros after them, and
 *   read with what follows them in memory, which is dropped.
 * - A request that finds no room in the FIFO, or nothing in it, waits: no overrun or underrun is ever flagged (FEIF).
 * - A stream that is enabled while flags of it are set runs all the same; it is noted.
 * - A write of the protected bits of an enabled stream leaves them as they are, which is noted unless it clears EN too.
 * - A stream that is disabled ends an access under way without a trace, and then stores what is in its FIFO. One that
 *   stops itself, by what it writes, makes no further beat of the burst.
 * - While the gate of its clock is shut, streams stand still; an access under way is made anew when it opens.
 * - Memory to memory in a controller that cannot is a transfer error. PSIZE and MSIZE of 3 are taken for 32 bits. */
#include "dma_stream.h"

#include "cpu.h"

#include <stdlib.h>
#include <string.h>

enum { PERIPHERAL_CYCLES = 5, MEMORY_CYCLES = 4, FIFO_BYTES = 16, MOST_SELECTED = 8, MOST_BARRED = 2 };

/* Words of the block: flags and how they are cleared, and from FIRST on those of each stream. */
enum { LISR, HISR, LIFCR, HIFCR, FIRST };
enum { CR, NDTR, PAR, M0AR, M1AR, FCR, STREAM_WORDS };

enum { FEIF = 1 << 0, DMEIF = 1 << 2, TEIF = 1 << 3, HTIF = 1 << 4, TCIF = 1 << 5 };
enum {                                                                                          /* CR */
  EN = 1 << 0, ENABLES = 0x1E, PFCTRL = 1 << 5, DIR = 6, CIRC = 1 << 8, PINC = 1 << 9, MINC = 1 << 10, PSIZE = 11,
  MSIZE = 13, PINCOS = 1 << 15, PL = 16, DBM = 1 << 18, CT = 1 << 19, PBURST = 21, MBURST = 23, BURSTS = 0xF << 21,
  CHSEL = 25,
};
enum { FTH = 3, DMDIS = 1 << 2, FEIE = 1 << 7, FS = 3 };                                         /* FCR */
enum direction { TO_MEMORY, TO_PERIPHERAL, BETWEEN };
enum { DATA_CACHE = 1 << 16 };                                                                   /* CCR.DC of the core */

/* What CR and FCR say while the stream is enabled, with what hardware forces: bytes of an item, how many of them a
 * request moves at either port, and how far the address goes on for each; bytes in the FIFO at which the memory port
 * goes on. */
struct setting {
  enum direction direction;
  uint32_t threshold, peripheral_size, peripheral_beats, peripheral_step, memory_size, memory_beats, memory_step;
  bool fifo, circular, twice, by_peripheral;
};

/* runs: it is enabled and has something to do. closing: it was disabled, and only empties its FIFO. in_access: an access
 * of it is being made that has not stopped it; what it wants then is asked after that. moves: the memory port has begun
 * to empty or to fill the FIFO. left: items still to pass the peripheral port. arrived, half, to_fetch: bytes. happened:
 * flags to be set. */
struct stream {
  struct setting setting;
  bool runs, closing, in_access, moves, irq;
  uint32_t flags, happened, reload, count, left, peripheral, memory, arrived, half, to_fetch;
  uint32_t selected[MOST_SELECTED], selected_count;
  uint32_t level;
  uint8_t fifo[FIFO_BYTES];
};

/* frees: its event ends the further beats of a burst, and not an access. */
struct port {
  struct hil_streams *dma;
  uint32_t cycles;
  bool (*access)(struct hil_streams *dma, struct stream *stream, uint32_t *beats);
  uint32_t asking;           /* a bit for each stream */
  uint64_t since[STREAMS], begun;
  int32_t event;
  bool serving, frees;
};

struct hil_streams {
  struct hil_block block;    /* first: a block is the controller that it belongs to */
  struct hil_queue *queue;
  struct hil_cpu *cpu;       /* whose memory and interrupts these are; NULL: Python is asked */
  hil_streams_ask ask;
  struct hil_request_lines *lines;
  uint32_t number;           /* among the controllers of the lines */
  bool between_memories;
  uint32_t bus_cycle;        /* cycles of the core in one of the bus */
  uint32_t irqs[STREAMS];
  struct { uint32_t base, size; } barred[MOST_BARRED];
  uint32_t barred_count;     /* memory that is not within reach; if there is any, Python looks at the data cache, too */
  struct stream streams[STREAMS];
  struct port peripheral_port, memory_port;
};

static uint64_t now(const struct hil_streams *dma) { return hil_time_of(dma->queue)->now; }

static uint32_t *registers(struct hil_streams *dma, uint32_t n) {
  return &dma->block.registers.values[FIRST + STREAM_WORDS * n];
}

/* --- flags and interrupts */

static void drive_irq(struct hil_streams *dma, uint32_t n) {
  struct stream *stream = &dma->streams[n];
  const uint32_t *r = registers(dma, n);
  bool level = stream->flags & (r[CR] & ENABLES) << 1 || (stream->flags & FEIF && r[FCR] & FEIE);
  if (level == stream->irq)
    return;
  stream->irq = level;
  if (dma->cpu)
    hil_drive_line(dma->cpu, FIRST_IRQ + dma->irqs[n], level);
  else
    dma->ask(STREAM_DRIVES, n, 0, level);
}

static void flag(struct hil_streams *dma, uint32_t n, uint32_t flags) {
  dma->streams[n].flags |= flags;
  drive_irq(dma, n);
}

static const uint32_t SHIFTS[] = {0, 6, 16, 22};

static uint32_t read_flags(const struct hil_streams *dma, uint32_t first) {
  uint32_t word = 0;
  for (uint32_t n = 0; n < 4; n++)
    word |= dma->streams[first + n].flags << SHIFTS[n];
  return word;
}

static void clear_flags(struct hil_streams *dma, uint32_t first, uint32_t value) {
  for (uint32_t n = 0; n < 4; n++) {
    dma->streams[first + n].flags &= ~(value >> SHIFTS[n]);
    drive_irq(dma, first + n);
  }
}

/* --- what a stream wants and does at its ports */

static bool is_incoming(const struct stream *stream) { return stream->setting.direction != TO_PERIPHERAL; }

static uint32_t peripheral_beats(const struct stream *stream) {
  return stream->left >= stream->setting.peripheral_beats ? stream->setting.peripheral_beats : 1;
}

/* Whether an access of the peripheral port can be made, if a peripheral asks; memory need not. */
static bool wants_peripheral(const struct stream *stream, bool asked) {
  if (!(asked || stream->setting.direction == BETWEEN) || !stream->left || stream->closing)
    return false;
  uint32_t needed = peripheral_beats(stream) * stream->setting.peripheral_size;
  return is_incoming(stream) ? stream->level + needed <= FIFO_BYTES : stream->level >= needed;
}

static bool wants_memory(const struct stream *stream) {
  const struct setting *setting = &stream->setting;
  uint32_t burst = setting->memory_size * setting->memory_beats;
  if (is_incoming(stream)) {
    if (stream->closing || !stream->left || !setting->fifo)
      return stream->level;
    return stream->moves && stream->level >= burst;
  }
  if (stream->closing || !stream->to_fetch)
    return false;
  return setting->fifo ? stream->moves && stream->level + burst <= FIFO_BYTES : !stream->level;
}

/* Whether a round is over, or the stream was disabled and has nothing left to store. */
static bool is_done(const struct stream *stream) {
  return (stream->closing || !stream->left) && (!is_incoming(stream) || !stream->level);
}

/* Begin to empty the FIFO at the threshold, or to fill it, and go on until no more access fits. */
static void watch_threshold(struct stream *stream) {
  const struct setting *setting = &stream->setting;
  uint32_t burst = setting->memory_size * setting->memory_beats, level = stream->level;
  if (!setting->fifo)
    return;
  if (is_incoming(stream))
    stream->moves = level >= setting->threshold || (stream->moves && level >= burst);
  else
    stream->moves = level <= setting->threshold || (stream->moves && level + burst <= FIFO_BYTES);
}

static void arrive(struct stream *stream, uint32_t size) {
  uint32_t before = stream->arrived;
  stream->arrived += size;
  if (before < stream->half && stream->half <= stream->arrived)
    stream->happened |= HTIF;
}

static void put(struct stream *stream, uint32_t value, uint32_t size) {
  for (uint32_t n = 0; n < size; n++)
    stream->fifo[stream->level++] = (uint8_t)(value >> 8 * n);
}

static uint32_t take(struct stream *stream, uint32_t size) {
  uint32_t value = 0;
  for (uint32_t n = 0; n < size; n++)
    value |= (uint32_t)stream->fifo[n] << 8 * n;
  stream->level -= size;
  memmove(stream->fifo, stream->fifo + size, stream->level);
  return value;
}

/* --- memory and registers */

/* Whether Python has to look at an access first. */
static bool is_for_python(const struct hil_streams *dma, uint32_t address) {
  if (!dma->cpu || (dma->barred_count && dma->cpu->exceptions.ccr & DATA_CACHE))
    return true;
  for (uint32_t n = 0; n < dma->barred_count; n++)
    if (address - dma->barred[n].base < dma->barred[n].size)
      return true;
  return false;
}

static bool fetch(struct hil_streams *dma, uint32_t address, uint32_t size, uint32_t *value) {
  if (!is_for_python(dma, address) && hil_master_load(dma->cpu, address, size, value))
    return true;
  uint64_t answer = dma->ask(STREAM_READS, address, size, 0);
  *value = (uint32_t)answer;
  return answer != STREAM_FAILS;
}

static bool store(struct hil_streams *dma, uint32_t address, uint32_t size, uint32_t value) {
  return (!is_for_python(dma, address) && hil_master_store(dma->cpu, address, size, value)) ||
         dma->ask(STREAM_WRITES, address, size, value) != STREAM_FAILS;
}

/* Make an access of the peripheral port, and say how many beats it had; false: a bus error. */
static bool access_peripheral(struct hil_streams *dma, struct stream *stream, uint32_t *beats) {
  const struct setting *setting = &stream->setting;
  uint32_t size = setting->peripheral_size, value;
  if (is_incoming(stream) && !setting->fifo && stream->level && !setting->memory_step)
    stream->happened |= DMEIF;
  *beats = peripheral_beats(stream);
  for (uint32_t n = 0; n < *beats; n++) {
    if (is_incoming(stream)) {
      if (!fetch(dma, stream->peripheral, size, &value))
        return false;
      put(stream, value, size);
    } else {
      if (!store(dma, stream->peripheral, size, take(stream, size)))
        return false;
      if (!stream->in_access)
        return true;
      arrive(stream, size);
    }
    stream->peripheral += setting->peripheral_step;
    stream->left--;
  }
  watch_threshold(stream);
  return true;
}

static uint32_t least(uint32_t a, uint32_t b) { return a < b ? a : b; }

/* The same of the memory port. */
static bool access_memory(struct hil_streams *dma, struct stream *stream, uint32_t *beats) {
  const struct setting *setting = &stream->setting;
  uint32_t size = setting->memory_size, value, available = is_incoming(stream) ? stream->level : stream->to_fetch;
  *beats = available >= size * setting->memory_beats ? setting->memory_beats : 1;
  for (uint32_t n = 0; n < *beats; n++) {
    if (is_incoming(stream)) {
      uint32_t bytes = least(size, stream->level);
      if (!store(dma, stream->memory, size, take(stream, bytes)))
        return false;
      if (!stream->in_access)
        return true;
      arrive(stream, bytes);
    } else {
      if (!fetch(dma, stream->memory, size, &value))
        return false;
      uint32_t bytes = least(size, stream->to_fetch);
      put(stream, value, bytes);
      stream->to_fetch -= bytes;
    }
    stream->memory += setting->memory_step;
  }
  watch_threshold(stream);
  return true;
}

/* --- from EN to the end */

static void look(struct hil_streams *dma, uint32_t n);

static uint32_t memory_of(struct hil_streams *dma, uint32_t n) {
  const uint32_t *r = registers(dma, n);
  return r[r[CR] & DBM && r[CR] & CT ? M1AR : M0AR];
}

/* Begin a round. */
static void restart(struct hil_streams *dma, uint32_t n) {
  struct stream *stream = &dma->streams[n];
  const struct setting *setting = &stream->setting;
  stream->left = stream->count;
  stream->peripheral = registers(dma, n)[PAR] & -setting->peripheral_size;
  stream->memory = memory_of(dma, n) & -setting->memory_size;
  stream->arrived = stream->level = 0;
  stream->to_fetch = stream->count * setting->peripheral_size;
  stream->moves = setting->direction == TO_PERIPHERAL;
}

static void stop(struct hil_streams *dma, uint32_t n) {
  struct stream *stream = &dma->streams[n];
  if (stream->runs)
    registers(dma, n)[NDTR] = stream->left;
  stream->runs = stream->in_access = false;
  registers(dma, n)[CR] &= ~(uint32_t)EN;
  look(dma, n);
}

static void fail(struct hil_streams *dma, uint32_t n, uint32_t why) {
  stop(dma, n);
  flag(dma, n, why);
}

/* Take over what the stream has done, and begin or end a round. */
static void advance(struct hil_streams *dma, uint32_t n) {
  struct stream *stream = &dma->streams[n];
  uint32_t happened = stream->happened;
  stream->happened = 0;
  if (is_done(stream)) {
    happened |= TCIF;
    if (stream->setting.circular && !stream->closing) {
      registers(dma, n)[CR] ^= stream->setting.twice ? CT : 0;
      restart(dma, n);
    } else {
      stop(dma, n);
    }
  }
  look(dma, n);
  if (happened)
    flag(dma, n, happened);
}

/* End a stream that is enabled: what is in its FIFO is stored first, if it comes from the peripheral. */
static void close_stream(struct hil_streams *dma, uint32_t n) {
  struct stream *stream = &dma->streams[n];
  if (!stream->runs) {
    registers(dma, n)[CR] &= ~(uint32_t)EN;
    return;
  }
  stream->closing = true;
  advance(dma, n);
}

/* CR as hardware sets it when EN is set (section 8.5.5). */
static uint32_t forced(uint32_t control, uint32_t fcr) {
  bool between = (control >> DIR & 3) >= BETWEEN;
  if (!(fcr & DMDIS) && !between)
    control = (control & ~(uint32_t)(BURSTS | 3 << MSIZE)) | (control >> PSIZE & 3) << MSIZE;
  if (between)
    return control & ~(uint32_t)(PFCTRL | CIRC);
  if (control & PFCTRL)
    return control & ~(uint32_t)CIRC;
  return control & DBM ? control | CIRC : control;
}

static struct setting setting_of(uint32_t control, uint32_t fcr) {
  static const uint32_t SIZES[] = {1, 2, 4, 4}, BEATS[] = {1, 4, 8, 16};
  struct setting it = {.direction = least(control >> DIR & 3, BETWEEN)};
  bool between = it.direction == BETWEEN;
  it.fifo = fcr & DMDIS || between;
  it.threshold = 4 * ((fcr & FTH) + 1);
  it.peripheral_size = SIZES[control >> PSIZE & 3];
  it.memory_size = it.fifo ? SIZES[control >> MSIZE & 3] : it.peripheral_size;
  it.peripheral_beats = it.fifo ? BEATS[control >> PBURST & 3] : 1;
  it.memory_beats = it.fifo ? BEATS[control >> MBURST & 3] : 1;
  uint32_t step = control & PINCOS && it.peripheral_beats == 1 ? 4 : it.peripheral_size;
  it.peripheral_step = control & PINC ? step : 0;
  it.memory_step = control & MINC ? it.memory_size : 0;
  it.twice = control & DBM && !between;
  it.circular = (control & CIRC || it.twice) && !between;
  it.by_peripheral = control & PFCTRL && !between;
  return it;
}

/* Whether the memory bursts fit the threshold and the FIFO (table 30). */
static bool bursts_fit(const struct setting *setting) {
  uint32_t burst = setting->memory_size * setting->memory_beats;
  if (setting->peripheral_size * setting->peripheral_beats > FIFO_BYTES)
    return false;
  return setting->memory_beats == 1 || (burst <= setting->threshold && setting->threshold % burst == 0);
}

static void check(struct hil_streams *dma, uint32_t n, const struct setting *setting) {
  const uint32_t *r = registers(dma, n);
  if (dma->streams[n].flags)
    dma->ask(STREAM_NOTES, n, CR, STREAM_FLAGGED);
  if (r[PAR] & (setting->peripheral_size - 1))
    dma->ask(STREAM_NOTES, n, PAR, STREAM_UNALIGNED);
  if (r[M0AR] & (setting->memory_size - 1))
    dma->ask(STREAM_NOTES, n, M0AR, STREAM_UNALIGNED);
}

static void run(struct hil_streams *dma, uint32_t n) {
  struct stream *stream = &dma->streams[n];
  uint32_t count = registers(dma, n)[NDTR] ? registers(dma, n)[NDTR] : stream->reload;
  if (!count && !stream->setting.by_peripheral)
    return;
  dma->ask(STREAM_SELECTS, n, 0, registers(dma, n)[CR] >> CHSEL & 0xF);
  stream->count = stream->setting.by_peripheral ? 0xFFFF : count;
  stream->half = (stream->count + 1) / 2 * stream->setting.peripheral_size;
  stream->closing = false;
  stream->happened = 0;
  restart(dma, n);
  stream->runs = true;
  look(dma, n);
}

static void start(struct hil_streams *dma, uint32_t n) {
  uint32_t *r = registers(dma, n);
  struct setting *setting = &dma->streams[n].setting;
  r[CR] = forced(r[CR], r[FCR]);
  *setting = setting_of(r[CR], r[FCR]);
  if (setting->direction == BETWEEN)
    r[FCR] |= DMDIS;
  check(dma, n, setting);
  if (!bursts_fit(setting)) {
    fail(dma, n, FEIF);
  } else if (setting->direction == BETWEEN && !dma->between_memories) {
    dma->ask(STREAM_NOTES, n, CR, STREAM_NO_WAY);
    fail(dma, n, TEIF);
  } else {
    run(dma, n);
  }
}

/* --- ports */

static void proceed(struct port *port) {
  struct hil_streams *dma = port->dma;
  if (hil_event_on(dma->queue, port->event) || port->serving || !port->asking)
    return;
  port->begun = now(dma);
  hil_event_at(dma->queue, port->event, port->begun + port->cycles * dma->bus_cycle, 0);
}

/* A stream wants an access, or does not any more. */
static void ask(struct port *port, uint32_t n, bool wants) {
  if (!wants) {
    port->asking &= ~(1u << n);
  } else if (!(port->asking >> n & 1)) {
    port->asking |= 1u << n;
    port->since[n] = now(port->dma);
    proceed(port);
  }
}

/* The stream whose turn it is, or as many as there are. */
static uint32_t chosen(const struct port *port) {
  uint32_t best = STREAMS, priority = 0;
  for (uint32_t n = 0; n < STREAMS; n++) {
    uint32_t own = registers(port->dma, n)[CR] >> PL & 3;
    if (!(port->asking >> n & 1) || port->since[n] > port->begun)
      continue;
    if (best == STREAMS || own > priority) {
      best = n;
      priority = own;
    }
  }
  return best;
}

/* Make the access of a stream, and return how many beats it had. */
static uint32_t serve(const struct port *port, uint32_t n) {
  struct hil_streams *dma = port->dma;
  struct stream *stream = &dma->streams[n];
  uint32_t beats = 1;
  if (!stream->runs)
    return beats;
  stream->in_access = true;
  bool done = port->access(dma, stream, &beats);
  stream->in_access = false;
  if (!done) {
    fail(dma, n, TEIF);
    return 1;
  }
  if (stream->runs)
    advance(dma, n);
  return beats;
}

/* The same at the peripheral port: whoever asked is answered, and may hear that it was the last time. */
static uint32_t serve_peripheral(const struct port *port, uint32_t n) {
  struct hil_streams *dma = port->dma;
  struct stream *stream = &dma->streams[n];
  uint32_t selected[MOST_SELECTED], count = stream->selected_count;
  memcpy(selected, stream->selected, sizeof selected);
  for (uint32_t each = 0; each < count; each++)
    dma->lines->lines[selected[each]].once = false;
  bool last = stream->runs && stream->left <= peripheral_beats(stream);
  uint32_t beats = serve(port, n);
  for (uint32_t each = 0; last && each < count; each++)
    if (dma->lines->lines[selected[each]].tells_last)
      dma->ask(STREAM_LAST, selected[each], 0, 0);
  return beats;
}

static void on_port(void *whose) {
  struct port *port = whose;
  struct hil_streams *dma = port->dma;
  uint32_t beats = 1, n = port->frees ? STREAMS : chosen(port);
  port->frees = false;
  if (n < STREAMS) {
    port->asking &= ~(1u << n);
    port->serving = true;
    beats = port == &dma->peripheral_port ? serve_peripheral(port, n) : serve(port, n);
    port->serving = false;
  }
  if (beats > 1) {
    port->frees = true;
    hil_event_at(dma->queue, port->event, now(dma) + (beats - 1) * dma->bus_cycle, 0);
  } else {
    proceed(port);
  }
}

static void reset_port(struct port *port) {
  hil_event_off(port->dma->queue, port->event);
  port->asking = 0;
  port->frees = false;
}

/* See what a stream wants, after anything has changed. */
static void look(struct hil_streams *dma, uint32_t n) {
  const struct stream *stream = &dma->streams[n];
  bool runs = stream->runs && dma->block.registers.clocked, asked = false;
  for (uint32_t each = 0; each < stream->selected_count; each++) {
    const struct hil_request_line *line = &dma->lines->lines[stream->selected[each]];
    asked |= line->level || line->once;
  }
  ask(&dma->peripheral_port, n, runs && wants_peripheral(stream, asked));
  ask(&dma->memory_port, n, runs && wants_memory(stream));
}

/* --- requests */

/* A request has changed. Most do so because of the access that serves them. */
void hil_stream_asked(struct hil_streams *dma, uint32_t n) {
  if (dma->streams[n].runs && !dma->streams[n].in_access)
    look(dma, n);
}

/* The peripheral, as the flow controller, says that nothing more will come. */
void hil_stream_ended(struct hil_streams *dma, uint32_t n) {
  if (dma->streams[n].runs && dma->streams[n].setting.by_peripheral)
    close_stream(dma, n);
}

/* How many items have still to pass the peripheral port; 0 if the stream does not run. */
uint32_t hil_stream_left(const struct hil_streams *dma, uint32_t n) {
  return dma->streams[n].runs ? dma->streams[n].left : 0;
}

/* Have a stream listen to these lines, and to no others. */
HIL_EXPORT void hil_streams_select(struct hil_streams *dma, uint32_t n, const uint32_t *lines, uint32_t count) {
  struct stream *stream = &dma->streams[n];
  uint16_t bit = (uint16_t)(1u << (STREAMS * dma->number + n));
  for (uint32_t each = 0; each < stream->selected_count; each++)
    dma->lines->lines[stream->selected[each]].heard_by &= (uint16_t)~bit;
  stream->selected_count = least(count, MOST_SELECTED);
  for (uint32_t each = 0; each < stream->selected_count; each++) {
    stream->selected[each] = lines[each];
    dma->lines->lines[lines[each]].heard_by |= bit;
  }
  hil_stream_asked(dma, n);
}

/* --- registers */

static void note_protected(struct hil_streams *dma, uint32_t n, uint32_t what) {
  dma->ask(STREAM_NOTES, n, what, STREAM_PROTECTED);
}

static void write_control(struct hil_streams *dma, uint32_t n, uint32_t value) {
  uint32_t *r = registers(dma, n), before = r[CR];
  if (!(before & EN)) {
    r[CR] = value;
    if (value & EN)
      start(dma, n);
  } else {
    if ((before ^ value) & ~(uint32_t)(ENABLES | EN | CT) && value & EN)
      note_protected(dma, n, CR);
    r[CR] = (before & ~(uint32_t)ENABLES) | (value & ENABLES);
    if (!(value & EN))
      close_stream(dma, n);
  }
  drive_irq(dma, n);
}

/* PAR, M0AR and M1AR; in double-buffer mode that of the buffer that is not in use may change at any time. */
static void write_address(struct hil_streams *dma, uint32_t n, uint32_t what, uint32_t value) {
  uint32_t *r = registers(dma, n);
  if (r[CR] & EN && (what == PAR || !(r[CR] & DBM)))
    note_protected(dma, n, what);
  else if (r[CR] & EN && what == (r[CR] & CT ? M1AR : M0AR))
    fail(dma, n, TEIF);
  else
    r[what] = value;
}

static void write_fifo(struct hil_streams *dma, uint32_t n, uint32_t value) {
  uint32_t *r = registers(dma, n), before = r[FCR];
  if (r[CR] & EN && (before ^ value) & (DMDIS | FTH)) {
    note_protected(dma, n, FCR);
    value = (before & ~(uint32_t)FEIE) | (value & FEIE);
  }
  r[FCR] = value;
  drive_irq(dma, n);
}

static uint32_t read_fifo(struct hil_streams *dma, uint32_t n) {
  uint32_t level = dma->streams[n].runs ? dma->streams[n].level : 0;
  uint32_t status = level == 0 ? 4 : level == FIFO_BYTES ? 5 : level / 4;
  return (registers(dma, n)[FCR] & ~(7u << FS)) | status << FS;
}

static bool read(struct hil_block *block, uint32_t word, uint32_t *value) {
  struct hil_streams *dma = (struct hil_streams *)block;
  if (word < FIRST) {
    *value = word < LIFCR ? read_flags(dma, word == LISR ? 0 : 4) : 0;
    return true;
  }
  uint32_t n = (word - FIRST) / STREAM_WORDS, what = (word - FIRST) % STREAM_WORDS;
  if (n >= STREAMS)
    return false;
  if (what == NDTR && dma->streams[n].runs)
    *value = dma->streams[n].left;
  else
    *value = what == FCR ? read_fifo(dma, n) : block->registers.values[word];
  return true;
}

static bool write(struct hil_block *block, uint32_t word, uint32_t value) {
  struct hil_streams *dma = (struct hil_streams *)block;
  uint32_t n = (word - FIRST) / STREAM_WORDS, what = (word - FIRST) % STREAM_WORDS;
  if (word >= FIRST && n >= STREAMS)
    return false;
  uint32_t writable = block->registers.writable[word];
  value = (value & writable) | (block->registers.values[word] & ~writable);
  if (word < FIRST) {
    if (word >= LIFCR)
      clear_flags(dma, word == LIFCR ? 0 : 4, value);
  } else if (what == CR) {
    write_control(dma, n, value);
  } else if (what == FCR) {
    write_fifo(dma, n, value);
  } else if (what != NDTR) {
    write_address(dma, n, what, value);
  } else if (registers(dma, n)[CR] & EN) {
    note_protected(dma, n, NDTR);
  } else {
    registers(dma, n)[NDTR] = dma->streams[n].reload = value;
  }
  return true;
}

/* --- the controller */

/* Go to the state after reset; requests, and who listens to them, are not its own. */
HIL_EXPORT void hil_streams_reset(struct hil_streams *dma) {
  memset(dma->block.registers.values, 0, sizeof dma->block.registers.values);
  reset_port(&dma->peripheral_port);
  reset_port(&dma->memory_port);
  for (uint32_t n = 0; n < STREAMS; n++) {
    registers(dma, n)[FCR] = 0x21;
    dma->streams[n].flags = dma->streams[n].reload = 0;
    dma->streams[n].runs = dma->streams[n].in_access = false;
    drive_irq(dma, n);
  }
}

/* Its clock has changed, or its gate: so many cycles of the core are one of the bus. */
HIL_EXPORT void hil_streams_clock(struct hil_streams *dma, uint32_t bus_cycle) {
  dma->bus_cycle = bus_cycle;
  for (uint32_t n = 0; n < STREAMS; n++)
    hil_stream_asked(dma, n);
}

/* Reach the memory of a core, but for what is barred, and drive its interrupts without asking Python. */
HIL_EXPORT void hil_streams_join(struct hil_streams *dma, struct hil_cpu *cpu, const uint32_t *irqs) {
  dma->cpu = cpu;
  memcpy(dma->irqs, irqs, sizeof dma->irqs);
}

HIL_EXPORT bool hil_streams_bar(struct hil_streams *dma, uint32_t base, uint32_t size) {
  if (dma->barred_count == MOST_BARRED)
    return false;
  dma->barred[dma->barred_count].base = base;
  dma->barred[dma->barred_count++].size = size;
  return true;
}

HIL_EXPORT void hil_streams_free(struct hil_streams *dma) { free(dma); }

static bool make_port(struct port *port, struct hil_streams *dma, uint32_t cycles,
                      bool (*access)(struct hil_streams *, struct stream *, uint32_t *)) {
  port->dma = dma;
  port->cycles = cycles;
  port->access = access;
  port->event = hil_event_new(dma->queue, on_port, port);
  return port->event != NO_EVENT;
}

static const struct hil_saved SAVED = {.size = sizeof(struct hil_streams)};

/* Make a controller whose streams listen to lines of a chip. Returns NULL if there is no memory, or no place, left. */
HIL_EXPORT struct hil_streams *hil_streams_new(struct hil_queue *queue, hil_streams_ask ask_python,
                                               struct hil_request_lines *lines, bool between_memories) {
  struct hil_streams *dma = lines->count < MOST_CONTROLLERS ? calloc(1, sizeof *dma) : NULL;
  if (!dma)
    return NULL;
  dma->queue = queue;
  dma->ask = ask_python;
  dma->lines = lines;
  dma->between_memories = between_memories;
  dma->bus_cycle = 1;
  dma->block.read = read;
  dma->block.write = write;
  dma->block.saved = &SAVED;
  dma->block.on_ahb = true;
  if (!make_port(&dma->peripheral_port, dma, PERIPHERAL_CYCLES, access_peripheral) ||
      !make_port(&dma->memory_port, dma, MEMORY_CYCLES, access_memory)) {
    free(dma);
    return NULL;
  }
  dma->number = lines->count;
  lines->controllers[lines->count++] = dma;
  return dma;
}
