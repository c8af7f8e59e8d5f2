/* Request lines to DMA: who asks need not know which controllers there are. */
#ifndef HIL_REQUESTS_H
#define HIL_REQUESTS_H

#include "layout.h"

#include <stdbool.h>

struct hil_streams;

/* What takes requests, by the number of a line: a controller of the STM32F1 (dma_f1.c) or the lines of a chip. */
struct hil_requests {
  void (*drive)(struct hil_requests *requests, uint32_t number, bool level);
};

enum { MOST_LINES = 256, MOST_CONTROLLERS = 2 };

/* level: as last driven. once: one transfer was asked for, and not made yet. tells_last: Python wants to know of the
 * last transfer of the count that a stream was given. heard_by: the streams that listen, a bit each, eight of each
 * controller. */
struct hil_request_line {
  bool level, once, tells_last;
  uint16_t heard_by;
};

/* The request lines of a chip, each of which may lead to several streams. */
struct hil_request_lines {
  struct hil_requests requests; /* first: this is where requests go */
  struct hil_request_line lines[MOST_LINES];
  struct hil_streams *controllers[MOST_CONTROLLERS];
  uint32_t count; /* of the controllers */
};

#endif
