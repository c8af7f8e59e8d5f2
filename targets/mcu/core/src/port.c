/* A port of pins: IDR, ODR, BSRR and BRR, which stand one behind the other (RM0008 section 9.2, RM0410 section 6.4).
 *
 * What a pin is, and what level comes about on it, is Python's (targets/mcu/pins.py). It says which pins are left alone:
 * push-pull outputs that nobody looks at, or whose edges are only written down. Of those C keeps the latch and the level
 * that is read, and the latches of the port with the cycle of each change that is to be written down, until Python
 * catches up. Of all other pins Python is told at once. */
#include "port.h"

#include "block.h"
#include "queue.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

enum { IDR, ODR, BSRR, BRR }; /* from the word of IDR on */

enum { LATCHES = 0xFFFF, MOST_CHANGES = 1 << 16 };

enum hil_port_question {
  PORT_READS, /* the level of each pin */
  PORT_SETS,  /* the latches to these */
};

typedef uint32_t (*hil_port_ask)(uint32_t question, uint32_t latches);

struct hil_port {
  struct hil_block block;    /* first: a block is the port that it belongs to */
  struct hil_port_pins pins;
  struct hil_queue *queue;
  hil_port_ask ask;
  uint32_t idr;              /* its word */
  bool has_brr;
  struct hil_change {
    uint64_t cycle, latches;
  } *changes;
  uint32_t room;
};

/* Write down the latches from now on; false: there is no room. */
static bool note(struct hil_port *port, uint32_t latches) {
  struct hil_port_pins *pins = &port->pins;
  if (pins->changes == port->room) {
    uint32_t room = port->room ? 2 * port->room : 64;
    struct hil_change *changes = room > MOST_CHANGES ? NULL : realloc(port->changes, room * sizeof *changes);
    if (!changes)
      return false;
    port->changes = changes;
    port->room = room;
  }
  port->changes[pins->changes++] = (struct hil_change){hil_time_of(port->queue)->now, latches};
  return true;
}

static void set(struct hil_port *port, uint32_t latches) {
  uint32_t *levels = &port->block.registers.values[port->idr], *now = levels + ODR, changed = *now ^ latches;
  const struct hil_port_pins *pins = &port->pins;
  if (changed & ~pins->alone || (changed & pins->noted && !note(port, latches))) {
    port->ask(PORT_SETS, latches);
    return;
  }
  *now = latches;
  *levels ^= changed & pins->shown;
  port->pins.behind = 1;
}

static bool read(struct hil_block *block, uint32_t word, uint32_t *value) {
  struct hil_port *port = (struct hil_port *)block;
  uint32_t what = word - port->idr, last = port->has_brr ? BRR : BSRR;
  if (what == last + 1 || (what != IDR && !block->registers.writable[word])) /* LCKR, or no register */
    return false;
  *value = what == IDR && port->pins.asked ? port->ask(PORT_READS, 0) : block->registers.values[word];
  return true;
}

static bool write(struct hil_block *block, uint32_t word, uint32_t value) {
  struct hil_port *port = (struct hil_port *)block;
  uint32_t what = word - port->idr, latches = block->registers.values[port->idr + ODR];
  if (what == ODR)
    set(port, value & LATCHES);
  else if (what == BSRR) /* set wins */
    set(port, (latches & ~(value >> 16)) | (value & LATCHES));
  else if (what == BRR && port->has_brr)
    set(port, latches & ~(value & LATCHES));
  else
    return false;
  return true;
}

/* Copy what was written down, and forget it: Python has caught up. */
HIL_EXPORT void hil_port_take(struct hil_port *port, struct hil_change *into) {
  if (port->pins.changes)
    memcpy(into, port->changes, port->pins.changes * sizeof *into);
  port->pins.changes = port->pins.behind = 0;
}

HIL_EXPORT struct hil_port_pins *hil_port_pins_of(struct hil_port *port) { return &port->pins; }

HIL_EXPORT void hil_port_free(struct hil_port *port) {
  free(port->changes);
  free(port);
}

static const struct hil_saved SAVED = {
    sizeof(struct hil_port),
    {{offsetof(struct hil_port, changes), offsetof(struct hil_port, room), sizeof(struct hil_change)}}};

/* Make a port, with the word of IDR. Returns NULL if there is no memory left. */
HIL_EXPORT struct hil_port *hil_port_new(struct hil_queue *queue, uint32_t idr, bool has_brr, bool on_ahb,
                                         hil_port_ask ask) {
  struct hil_port *port = calloc(1, sizeof *port);
  if (!port)
    return NULL;
  port->queue = queue;
  port->idr = idr;
  port->has_brr = has_brr;
  port->ask = ask;
  port->block.read = read;
  port->block.write = write;
  port->block.saved = &SAVED;
  port->block.on_ahb = on_ahb;
  return port;
}
