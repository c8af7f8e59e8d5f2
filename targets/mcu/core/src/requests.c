/* The request lines of a chip whose DMA has streams. */
#include "requests.h"

#include "dma_stream.h"

#include <stdlib.h>

/* Tell the streams that listen. */
static void tell(const struct hil_request_lines *lines, const struct hil_request_line *line) {
  for (uint32_t n = 0; line->heard_by >> n; n++)
    if (line->heard_by >> n & 1)
      hil_stream_asked(lines->controllers[n / STREAMS], n % STREAMS);
}

/* Drive a line; low takes back what it has asked for once. */
static void drive(struct hil_requests *requests, uint32_t number, bool level) {
  struct hil_request_lines *lines = (struct hil_request_lines *)requests;
  struct hil_request_line *line = &lines->lines[number];
  line->level = level;
  line->once = line->once && level;
  tell(lines, line);
}

HIL_EXPORT void hil_lines_drive(struct hil_request_lines *lines, uint32_t number, bool level) {
  drive(&lines->requests, number, level);
}

/* Ask for one transfer; kept until one was made. */
HIL_EXPORT void hil_lines_pulse(struct hil_request_lines *lines, uint32_t number) {
  lines->lines[number].once = true;
  tell(lines, &lines->lines[number]);
}

/* Nothing more will come: the peripheral is the flow controller, and says so. */
HIL_EXPORT void hil_lines_end(struct hil_request_lines *lines, uint32_t number) {
  uint32_t heard_by = lines->lines[number].heard_by;
  for (uint32_t n = 0; heard_by >> n; n++)
    if (heard_by >> n & 1)
      hil_stream_ended(lines->controllers[n / STREAMS], n % STREAMS);
}

/* How many accesses the streams that listen have still to make; the one that is being made counts. */
HIL_EXPORT uint32_t hil_lines_left(const struct hil_request_lines *lines, uint32_t number) {
  uint32_t heard_by = lines->lines[number].heard_by, left = 0;
  for (uint32_t n = 0; heard_by >> n; n++)
    if (heard_by >> n & 1)
      left += hil_stream_left(lines->controllers[n / STREAMS], n % STREAMS);
  return left;
}

HIL_EXPORT bool hil_lines_level(const struct hil_request_lines *lines, uint32_t number) {
  return lines->lines[number].level;
}

HIL_EXPORT void hil_lines_tell_last(struct hil_request_lines *lines, uint32_t number) {
  lines->lines[number].tells_last = true;
}

/* Make lines that lead nowhere; NULL: there is no memory left. */
HIL_EXPORT struct hil_request_lines *hil_lines_new(void) {
  struct hil_request_lines *lines = calloc(1, sizeof *lines);
  if (lines)
    lines->requests.drive = drive;
  return lines;
}

/* How large they are: all of it is state (snapshot.c). */
HIL_EXPORT uint32_t hil_lines_size(void) { return sizeof(struct hil_request_lines); }

HIL_EXPORT void hil_lines_free(struct hil_request_lines *lines) { free(lines); }
