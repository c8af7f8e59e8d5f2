/* A word of an SPI master on its wires and on its bus, while nobody looks at SCK and MOSI: one event at its end.
 *
 * Where MOSI is wired to MISO, and nobody else looks, each half of a clock is an event, as it is in Python.
 *
 * What the wires do meanwhile, and all of it where somebody looks, is Python's (targets/mcu/stm32/spi_wire.py). So are
 * the slaves outside. They may promise what they answer next, whatever is sent: then they are told of what was sent
 * later, all at once (targets/mcu/spi_bus.py). */
#include "spi_f1.h"

#include <string.h>

enum { BYTE_BITS = 8, BYTE = 0xFF };

static uint64_t now(const struct hil_spi *spi) { return hil_time_of(spi->queue)->now; }

/* Wait for the next half of a clock, or for the end. */
static void await(struct hil_spi *spi) {
  hil_event_at(spi->queue, spi->end, spi->wires.begun + (uint64_t)spi->wires.halves * spi->wires.half_cycles, 0);
}

/* A half of a clock begins; what comes in is sampled at every other one. */
static void half(struct hil_spi *spi) {
  struct hil_spi_wires *wires = &spi->wires;
  uint32_t bit = wires->bits >> (wires->count - 1 - wires->halves / 2) & 1;
  if (!wires->late)
    bit = spi->ask(SPI_EDGE, 0);
  if (!wires->going) /* whoever has heard of the edge has broken the word off */
    return;
  if (wires->halves++ & 1)
    wires->sampled = wires->sampled << 1 | bit;
  await(spi);
}

/* Let the word of `wires` go over the wires; `hil_spi_ended` follows. */
void hil_spi_send(struct hil_spi *spi) {
  struct hil_spi_wires *wires = &spi->wires;
  bool here = wires->plain ? wires->drives || !wires->one_wire : wires->looped && wires->drives && !wires->one_wire;
  if (!here && !spi->ask(SPI_SENDS, 0))
    return;
  wires->going = 1;
  wires->begun = now(spi);
  wires->edges = !wires->plain;
  wires->halves = wires->edges ? 0 : 2 * wires->count;
  wires->sampled = 0;
  if (wires->edges)
    half(spi);
  else
    await(spi);
}

/* CPOL as it is, and CPHA of the word. */
static uint32_t mode(const struct hil_spi *spi) { return spi->cpol << 1 | spi->wires.cpha; }

/* What slaves have promised to answer, if they have; they will be told of what was sent. */
static bool promised(struct hil_spi *spi, uint32_t *answer) {
  struct hil_spi_wires *wires = &spi->wires;
  uint32_t bytes = wires->count / BYTE_BITS;
  if (wires->promised == PROMISED_NOTHING || mode(spi) != spi->promised_mode)
    return false;
  if (wires->promised == PROMISED_SILENCE)
    return true;
  if (spi->answered + bytes > spi->answer_count)
    return false;
  *answer = 0;
  while (bytes--) {
    *answer = *answer << BYTE_BITS | spi->answers[spi->answered++];
    spi->told[wires->heard++] = (uint8_t)(wires->drives ? wires->bits >> BYTE_BITS * bytes : BYTE);
  }
  wires->heard_at = now(spi);
  return true;
}

/* The bits of a slave, or what stands at the pin where none is selected. */
static uint32_t came_in(struct hil_spi *spi) {
  struct hil_spi_wires *wires = &spi->wires;
  uint32_t answer = SPI_SILENCE;
  uint32_t at_pin = wires->sampled;
  if (!wires->edges) {
    bool asks = wires->one_wire ? hil_spi_wants_what_comes_in(spi) : !wires->known;
    at_pin = (asks ? spi->ask(SPI_LEVEL, 0) : wires->miso) ? UINT32_MAX >> (32 - wires->count) : 0;
  }
  if (wires->asks && !promised(spi, &answer))
    answer = spi->ask(SPI_EXCHANGES, 0);
  return answer == SPI_SILENCE ? at_pin : answer;
}

void hil_spi_on_end(void *whose) {
  struct hil_spi *spi = whose;
  struct hil_spi_wires *wires = &spi->wires;
  if (wires->halves < 2 * wires->count) {
    half(spi);
    return;
  }
  if (!wires->late) {
    spi->ask(SPI_PUTS, 0);
  } else if (wires->drives) {
    wires->last = wires->bits & 1;
    wires->behind = 1;
  }
  wires->going = 0;
  hil_spi_ended(spi, came_in(spi));
}

/* --- for Python */

/* The word under way goes on in Python, or does not. */
HIL_EXPORT void hil_spi_let_go(struct hil_spi *spi) {
  hil_event_off(spi->queue, spi->end);
  spi->wires.going = 0;
}

/* A word that Python has let go over the wires has ended. */
HIL_EXPORT void hil_spi_over(struct hil_spi *spi, uint32_t received) { hil_spi_ended(spi, received); }

/* From now on slaves answer this in the present mode, whatever is sent; nothing: none of them is selected. */
HIL_EXPORT void hil_spi_promise(struct hil_spi *spi, const uint8_t *answers, uint32_t count) {
  spi->answer_count = count < MOST_PROMISED ? count : MOST_PROMISED;
  memcpy(spi->answers, answers, spi->answer_count);
  spi->answered = 0;
  spi->promised_mode = mode(spi);
  spi->wires.promised = count ? PROMISED_BYTES : PROMISED_SILENCE;
}

/* Copy what was sent since then; the promise has ended. */
HIL_EXPORT void hil_spi_take(struct hil_spi *spi, uint8_t *into) {
  memcpy(into, spi->told, spi->wires.heard);
  spi->wires.heard = 0;
  spi->wires.promised = PROMISED_NOTHING;
}
