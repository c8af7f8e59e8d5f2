/* The transmitter of a USART, and its receiver for frames that nothing disturbs (RM0008 sections 27.3.2, 27.3.3).
 *
 * A frame begins at the cycle at which its word enters the shift register; the next one begins at the cycle at which the
 * last stop bit ends. So frames follow each other without a gap, and one event a frame is enough. A frame that comes in
 * costs one event too: where every sample lies within the bit that it is meant for, its word is that which was sent.
 *
 * Choices where the manual is silent or contradicts itself:
 *
 * - A word written while nothing is being sent begins at the cycle of the write; on silicon the bit clock may run free.
 * - The preamble after TE is one bit (RM0008: "a 1 bit-time delay before the transmission starts") and one frame of
 *   ones.
 * - TE or UE cleared in mid-frame lets the frame end. (TE: "a 0 pulse sends a preamble after the current word"; but also
 *   "the current data will be lost". UE: "at the end of the current byte transfer".) What waits in the data register
 *   stays there.
 * - A change of the bit clock in mid-frame times the rest of the frame anew in the chip, while the frame on the wire
 *   stays as it was announced at its start.
 * - The line is idle one frame after the end of the last stop bit. */
#include "usart.h"

#include "cpu.h"

#include <stdlib.h>
#include <string.h>

static uint64_t now(const struct hil_usart *usart) { return hil_time_of(usart->queue)->now; }

static uint64_t later(uint64_t a, uint64_t b) { return a > b ? a : b; }

/* cycles * sixteenths / whole, rounded up, where the product does not fit: a bit of the factor at a time. `whole` is less
 * than 2^63. There is no wider division: compilers have it in a library that need not be there. */
static uint64_t divided(uint64_t cycles, uint32_t sixteenths, uint64_t whole) {
  uint64_t quotient = 0, rest = 0;
  for (uint32_t bit = 1u << 31; bit; bit >>= 1) {
    quotient = 2 * quotient + (2 * rest >= whole);
    rest = 2 * rest - (2 * rest >= whole ? whole : 0);
    if (!(sixteenths & bit))
      continue;
    rest += cycles % whole;
    quotient += cycles / whole + (rest >= whole);
    rest -= rest >= whole ? whole : 0;
  }
  return quotient + (rest != 0);
}

/* The first cycle at or after so many sixteenths of a bit from a cycle on; there are fewer than 2^16. */
static uint64_t after(const struct hil_line *line, uint64_t from, uint32_t sixteenths) {
  uint64_t whole = 16 * line->bit_parts;
  if (line->bit_cycles >> 48)
    return from + divided(line->bit_cycles, sixteenths, whole);
  return from + (line->bit_cycles * sixteenths + whole - 1) / whole;
}

static uint32_t frame_sixteenths(const struct hil_line *line) {
  return 16 * (1 + line->word_bits) + 8 * line->stop_half_bits;
}

static void tell(const struct hil_usart *usart, enum hil_usart_news news) { usart->tell(news, 0, 0); }

/* Add a word; false: there is no memory left. */
static bool add_word(struct hil_words *all, uint64_t cycle, uint64_t bits) {
  if (all->end == all->room) {
    uint32_t room = all->room ? 2 * all->room : 256;
    struct hil_word *words = realloc(all->words, room * sizeof *words);
    if (!words)
      return false;
    all->words = words;
    all->room = room;
  }
  all->words[all->end++] = (struct hil_word){cycle, bits};
  return true;
}

/* --- words */

static uint32_t data_mask(const struct hil_line *line) { return (1u << line->data_bits) - 1; }

/* The word's bits between start and stop: cut to the data bits, with its parity bit as the most significant one. */
uint32_t hil_usart_word(const struct hil_line *line, uint32_t value) {
  value &= data_mask(line);
  if (!line->parity)
    return value;
  uint32_t is_odd = (uint32_t)__builtin_popcount(value) & 1;
  return value | (is_odd ^ (line->parity == 2)) << line->data_bits;
}

/* The data of a word, without its parity. */
uint32_t hil_usart_data(const struct hil_line *line, uint32_t word) { return word & data_mask(line); }

bool hil_usart_parity_wrong(const struct hil_line *line, uint32_t word) {
  return line->parity && ((uint32_t)__builtin_popcount(word) & 1) != (line->parity == 2);
}

void hil_usart_tell_data(const struct hil_usart *usart, uint32_t word, uint32_t errors) {
  if (usart->line.tells & TELL_DATA)
    usart->tell(NEWS_DATA, hil_usart_data(&usart->line, word), errors);
}

/* --- what the registers make of it, for Python */

HIL_EXPORT void hil_usart_update(struct hil_usart *usart) { usart->model->update(usart); }

HIL_EXPORT void hil_usart_take_word(struct hil_usart *usart, uint32_t bits, uint32_t noise, uint32_t framing_error) {
  usart->model->word(usart, bits, noise, framing_error);
}

HIL_EXPORT bool hil_usart_wants_idle(const struct hil_usart *usart) { return usart->model->wants_idle(usart); }

/* --- lines */

/* Drive interrupt and DMA requests; Python may do so again before this returns. */
void hil_usart_drive(struct hil_usart *usart, uint32_t levels) {
  static const uint32_t NEWS[] = {NEWS_IRQ, NEWS_DMA_TX, NEWS_DMA_RX};
  uint32_t changed = levels ^ usart->line.levels;
  usart->line.levels = levels;
  for (uint32_t n = 0; changed >> n; n++) {
    if (!(changed >> n & 1))
      continue;
    if (n == 0 && usart->cpu)
      hil_drive_line(usart->cpu, FIRST_IRQ + usart->irq, levels & 1);
    else if (n && usart->requests)
      usart->requests->drive(usart->requests, usart->lines[n - 1], levels >> n & 1);
    else
      usart->tell(NEWS[n], levels >> n & 1, 0);
  }
}

/* --- sending: one frame after the other */

static uint32_t break_stop(const struct hil_line *line) { return line->stop_half_bits > 2 ? line->stop_half_bits : 2; }

static void enter_end(struct hil_usart *usart) {
  struct hil_line *line = &usart->line;
  line->end_cycle = line->bent ? usart->ask(ASK_SENT, line->end) : after(line, line->begun, line->end);
  hil_event_at(usart->queue, usart->sent, line->end_cycle, 0);
}

static void begin(struct hil_usart *usart, enum hil_sending what, uint32_t sixteenths) {
  struct hil_line *line = &usart->line;
  line->sending = what;
  line->begun = now(usart);
  line->end = sixteenths;
  line->bent = line->odd;
  enter_end(usart);
}

static void announce(struct hil_usart *usart, uint32_t bits, uint32_t count, uint32_t stop_half_bits, bool is_break) {
  struct hil_line *line = &usart->line;
  line->quiet = 0;
  line->frame_bits = bits;
  line->frame_count = count;
  line->frame_stop = stop_half_bits;
  line->frame_is_break = is_break;
  line->frame_is_new = 1;
  bool is_kept = line->tells & KEEP_WORDS && !is_break && add_word(&usart->kept, now(usart), bits);
  line->kept = usart->kept.end;
  if (line->tells & TELL_FRAMES || (line->tells & KEEP_WORDS && !is_kept))
    tell(usart, NEWS_FRAME);
}

/* Copy the words that were kept, as pairs of cycle and bits, and forget them. */
HIL_EXPORT void hil_usart_take_kept(struct hil_usart *usart, struct hil_word *into) {
  if (usart->kept.end)
    memcpy(into, usart->kept.words, usart->kept.end * sizeof *into);
  usart->kept.end = usart->line.kept = 0;
}

/* Begin with what is due, if nothing is under way. */
HIL_EXPORT void hil_usart_proceed(struct hil_usart *usart) {
  struct hil_line *line = &usart->line;
  if (line->sending != SENDING_NOTHING || !line->enabled)
    return;
  if (line->preamble_due) {
    line->preamble_due = 0;
    begin(usart, SENDING_PREAMBLE, 16 * (2 + line->word_bits) + 8 * line->stop_half_bits);
  } else if (line->break_wanted) {
    begin(usart, SENDING_BREAK, 16 * line->break_bits);
    announce(usart, 0, line->break_bits - 1, break_stop(line), true);
  } else if (line->holds && line->clear_to_send) {
    uint32_t word = line->holding;
    line->holds = 0;
    begin(usart, SENDING_DATA, frame_sixteenths(line));
    usart->model->loaded(usart);
    announce(usart, word, line->word_bits, line->stop_half_bits, false);
  }
}

/* Put a word into the data register; it goes on into the shift register at once if that is free. */
HIL_EXPORT void hil_usart_put(struct hil_usart *usart, uint32_t word) {
  usart->line.holding = word;
  usart->line.holds = 1;
  hil_usart_proceed(usart);
}

static void fell_quiet(struct hil_usart *usart) {
  struct hil_line *line = &usart->line;
  if (line->tells & TELL_ENDS || !line->enabled)
    tell(usart, NEWS_IDLE_LEVEL);
  line->quiet = 1;
  if (line->data_sent && !line->holds) {
    line->data_sent = 0;
    usart->model->complete(usart);
  }
}

static void on_sent(void *whose) {
  struct hil_usart *usart = whose;
  struct hil_line *line = &usart->line;
  uint32_t ended = line->sending;
  if (ended == SENDING_BREAK) {
    line->sending = SENDING_BREAK_STOP;
    line->end += 8 * break_stop(line);
    enter_end(usart);
    line->break_wanted = 0;
    usart->model->break_sent(usart);
    return;
  }
  if (line->tells & TELL_ENDS)
    tell(usart, NEWS_END);
  else
    line->frame_is_new = 0;
  line->sending = SENDING_NOTHING;
  line->data_sent |= ended == SENDING_DATA;
  if (!line->enabled && ended == SENDING_DATA)
    tell(usart, NEWS_CUT);
  hil_usart_proceed(usart);
  if (line->sending == SENDING_NOTHING)
    fell_quiet(usart);
}

/* Let the transmitter run: it begins with a preamble. `hil_usart_proceed` follows. */
HIL_EXPORT void hil_usart_enable(struct hil_usart *usart, uint32_t on) {
  struct hil_line *line = &usart->line;
  line->enabled = line->preamble_due = on;
  if (!on && line->sending == SENDING_PREAMBLE) {
    hil_event_off(usart->queue, usart->sent);
    line->sending = SENDING_NOTHING;
  }
}

/* The rest of what is being sent takes another time: Python knows until when. */
HIL_EXPORT void hil_usart_bend(struct hil_usart *usart) {
  usart->line.bent = 1;
  enter_end(usart);
}

/* Stop in mid-frame and forget everything. */
HIL_EXPORT void hil_usart_stop(struct hil_usart *usart) {
  struct hil_line *line = &usart->line;
  hil_event_off(usart->queue, usart->sent);
  line->sending = SENDING_NOTHING;
  line->holds = line->preamble_due = line->break_wanted = line->data_sent = line->enabled = line->frame_is_new = 0;
  line->quiet = 1;
}

/* --- receiving */

/* A start bit begins at a cycle: if the wait for an idle line is not over by then, it is in vain. */
HIL_EXPORT void hil_usart_break_quiet(struct hil_usart *usart, uint64_t cycle) {
  if (hil_event_on(usart->queue, usart->idle) && cycle <= usart->line.quiet_until)
    hil_event_off(usart->queue, usart->idle);
}

static void enter_quiet(struct hil_usart *usart, bool bent) {
  struct hil_line *line = &usart->line;
  line->quiet_until = bent ? usart->ask(ASK_QUIET, line->quiet_length) : after(line, line->quiet_from, line->quiet_length);
  hil_event_at(usart->queue, usart->idle, line->quiet_until, 0);
}

/* The line is high from a cycle on, and idle a frame later. */
HIL_EXPORT void hil_usart_await_quiet(struct hil_usart *usart, uint64_t cycle) {
  usart->line.quiet_from = cycle;
  usart->line.quiet_length = frame_sixteenths(&usart->line);
  enter_quiet(usart, usart->line.odd);
}

/* The bit time has changed: Python knows how long to wait. */
HIL_EXPORT void hil_usart_bend_quiet(struct hil_usart *usart) {
  if (hil_event_on(usart->queue, usart->idle))
    enter_quiet(usart, true);
}

HIL_EXPORT void hil_usart_forget_quiet(struct hil_usart *usart) { hil_event_off(usart->queue, usart->idle); }

/* A frame comes in whose start bit began at a cycle; each sample lies in its bit. */
HIL_EXPORT void hil_usart_hear(struct hil_usart *usart, uint64_t cycle, uint32_t bits) {
  struct hil_line *line = &usart->line;
  line->hears = 1;
  line->expected = 0;
  line->heard = bits;
  line->heard_from = cycle;
  hil_usart_break_quiet(usart, cycle);
  uint64_t end = line->odd ? usart->ask(ASK_READ, line->read_at) : after(line, cycle, line->read_at);
  hil_event_at(usart->queue, usart->read, end, 0);
}

/* It is for Python to read. */
HIL_EXPORT void hil_usart_unhear(struct hil_usart *usart) {
  usart->line.hears = 0;
  hil_event_off(usart->queue, usart->read);
}

static void on_read(void *whose) {
  struct hil_usart *usart = whose;
  struct hil_line *line = &usart->line;
  line->hears = 0;
  usart->model->word(usart, line->heard, false, false);
  if (!line->listening || !usart->model->wants_idle(usart))
    return;
  uint32_t length = frame_sixteenths(line);
  uint64_t end = line->odd ? usart->ask(ASK_READ, length) : after(line, line->heard_from, length);
  hil_usart_await_quiet(usart, later(now(usart), end));
}

/* --- frames that are known beforehand */

enum { OUTSIDE = 1 }; /* the order of what comes from outside: after what the chip does at the same cycle */

static void await_next(struct hil_usart *usart) {
  struct hil_words *expected = &usart->expected;
  usart->line.coming = expected->end - expected->first;
  if (usart->line.coming)
    hil_event_at(usart->queue, usart->arrives, expected->words[expected->first].cycle, OUTSIDE);
  else
    expected->first = expected->end = 0;
}

static void on_arrives(void *whose) {
  struct hil_usart *usart = whose;
  struct hil_line *line = &usart->line;
  struct hil_word word = usart->expected.words[usart->expected.first++];
  await_next(usart);
  if (word.bits & LOOK_AT_WORD || !line->plain || line->hears) {
    usart->tell(NEWS_ARRIVED, line->coming, 0);
  } else if (usart->block.registers.clocked) {
    hil_usart_hear(usart, word.cycle, (uint32_t)word.bits);
    line->expected = 1;
  }
}

/* Have frames come in, behind those that are expected already; false: there is no memory for all of them. */
HIL_EXPORT bool hil_usart_expect(struct hil_usart *usart, const uint64_t *cycles, const uint64_t *bits, uint32_t count) {
  struct hil_words *expected = &usart->expected;
  bool is_done = true;
  if (expected->first) {
    memmove(expected->words, expected->words + expected->first, usart->line.coming * sizeof *expected->words);
    expected->end = usart->line.coming;
    expected->first = 0;
  }
  for (uint32_t n = 0; n < count && is_done; n++)
    is_done = add_word(expected, cycles[n], bits[n]);
  if (usart->line.coming)
    usart->line.coming = expected->end;
  else
    await_next(usart);
  return is_done;
}

/* Of the frames that are expected keep the first ones alone. */
HIL_EXPORT void hil_usart_expect_only(struct hil_usart *usart, uint32_t count) {
  if (usart->line.coming <= count)
    return;
  usart->expected.end = usart->expected.first + count;
  hil_event_off(usart->queue, usart->arrives);
  await_next(usart);
}

static void on_idle(void *whose) {
  struct hil_usart *usart = whose;
  usart->model->line_idle(usart);
}

/* --- the USART */

HIL_EXPORT void hil_usart_free(struct hil_usart *usart) {
  free(usart->expected.words);
  free(usart->kept.words);
  free(usart);
}

#define GROWN(words_of)                                                                                               \
  {offsetof(struct hil_usart, words_of.words), offsetof(struct hil_usart, words_of.room), sizeof(struct hil_word)}

static const struct hil_saved SAVED = {sizeof(struct hil_usart), {GROWN(expected), GROWN(kept)}};

/* Make a USART. Returns NULL if there is no memory left. */
HIL_EXPORT struct hil_usart *hil_usart_new(struct hil_queue *queue, uint32_t kind, hil_usart_tell tell_python,
                                           hil_usart_ask ask_python) {
  struct hil_usart *usart = calloc(1, sizeof *usart);
  if (!usart)
    return NULL;
  usart->queue = queue;
  usart->model = kind == USART_F1 ? &hil_usart_f1 : &hil_usart_isr;
  usart->block.read = usart->model->read;
  usart->block.write = usart->model->write;
  usart->block.saved = &SAVED;
  usart->tell = tell_python;
  usart->ask = ask_python;
  usart->line.quiet = usart->line.clear_to_send = 1;
  usart->line.bit_cycles = 16;
  usart->line.bit_parts = 1;
  usart->sent = hil_event_new(queue, on_sent, usart);
  usart->read = hil_event_new(queue, on_read, usart);
  usart->idle = hil_event_new(queue, on_idle, usart);
  usart->arrives = hil_event_new(queue, on_arrives, usart);
  if (usart->sent == NO_EVENT || usart->read == NO_EVENT || usart->idle == NO_EVENT || usart->arrives == NO_EVENT) {
    free(usart);
    return NULL;
  }
  return usart;
}

HIL_EXPORT struct hil_line *hil_line_of(struct hil_usart *usart) { return &usart->line; }

/* Drive that interrupt of a core without telling Python. */
HIL_EXPORT void hil_usart_interrupts(struct hil_usart *usart, struct hil_cpu *cpu, uint32_t irq) {
  usart->cpu = cpu;
  usart->irq = irq;
}

/* Ask for transfers without telling Python: by lines of these numbers. */
HIL_EXPORT void hil_usart_transfers(struct hil_usart *usart, struct hil_requests *requests, uint32_t to_send,
                                    uint32_t received) {
  usart->requests = requests;
  usart->lines[0] = to_send;
  usart->lines[1] = received;
}
