/* A binary heap of event numbers, in which each event knows its place: leaving it costs no more than entering. */
#include "queue.h"

#include "cpu.h"

#include <stdlib.h>
#include <string.h>

struct event {
  uint64_t cycle, rank;      /* rank: the order, and below it how many were entered before */
  hil_happening happening;   /* NULL: of Python, or free */
  void *whose;
  int32_t place;             /* in the heap; NO_EVENT if it is not entered */
  int32_t next_free;
};

struct hil_queue {
  struct hil_time time;
  struct hil_state *state;
  hil_happening_of_python python;
  uint64_t entered;
  struct event *events;
  int32_t *heap;
  int32_t count, made, room, free;
};

enum { FIRST_ROOM = 64, LOWEST_ORDER = -8, ORDER_AT = 56 };

HIL_EXPORT struct hil_queue *hil_queue_new(hil_happening_of_python happening) {
  struct hil_queue *queue = calloc(1, sizeof *queue);
  if (!queue)
    return NULL;
  queue->python = happening;
  queue->free = NO_EVENT;
  queue->time.next = UINT64_MAX;
  return queue;
}

HIL_EXPORT void hil_queue_free(struct hil_queue *queue) {
  if (!queue)
    return;
  free(queue->events);
  free(queue->heap);
  free(queue);
}

HIL_EXPORT struct hil_time *hil_time_of(struct hil_queue *queue) { return &queue->time; }

/* --- the heap */

static bool is_before(const struct hil_queue *queue, int32_t one, int32_t other) {
  const struct event *a = &queue->events[one], *b = &queue->events[other];
  return a->cycle < b->cycle || (a->cycle == b->cycle && a->rank < b->rank);
}

static void put(struct hil_queue *queue, int32_t place, int32_t number) {
  queue->heap[place] = number;
  queue->events[number].place = place;
}

/* Put an event where it belongs, from a place on that is free. */
static void settle(struct hil_queue *queue, int32_t place, int32_t number) {
  while (place && is_before(queue, number, queue->heap[(place - 1) / 2])) {
    put(queue, place, queue->heap[(place - 1) / 2]);
    place = (place - 1) / 2;
  }
  for (;;) {
    int32_t child = 2 * place + 1;
    if (child + 1 < queue->count && is_before(queue, queue->heap[child + 1], queue->heap[child]))
      child++;
    if (child >= queue->count || is_before(queue, number, queue->heap[child]))
      break;
    put(queue, place, queue->heap[child]);
    place = child;
  }
  put(queue, place, number);
}

/* After a change: tell everybody who looks what comes next. */
static void tell(struct hil_queue *queue) {
  struct hil_time *time = &queue->time;
  const struct event *first = queue->count ? &queue->events[queue->heap[0]] : NULL;
  time->next = first ? first->cycle : UINT64_MAX;
  if (queue->state && queue->state->due != time->next) {
    queue->state->due = time->next;
    queue->state->changed = 1;
  }
}

static void take_out(struct hil_queue *queue, int32_t number) {
  int32_t place = queue->events[number].place, last = queue->heap[--queue->count];
  queue->events[number].place = NO_EVENT;
  if (last != number)
    settle(queue, place, last);
  tell(queue);
}

static void put_in(struct hil_queue *queue, int32_t number, uint64_t cycle, int32_t order) {
  struct event *event = &queue->events[number];
  event->cycle = cycle < queue->time.now ? queue->time.now : cycle;
  event->rank = (uint64_t)(order - LOWEST_ORDER) << ORDER_AT | queue->entered++;
  if (event->place == NO_EVENT)
    event->place = queue->count++;
  settle(queue, event->place, number);
  tell(queue);
}

/* --- making events */

static bool has_room(struct hil_queue *queue) {
  if (queue->made < queue->room)
    return true;
  int32_t room = queue->room ? 2 * queue->room : FIRST_ROOM;
  struct event *events = realloc(queue->events, (size_t)room * sizeof *events);
  if (!events)
    return false;
  queue->events = events;
  int32_t *heap = realloc(queue->heap, (size_t)room * sizeof *heap);
  if (!heap)
    return false;
  queue->heap = heap;
  queue->room = room;
  return true;
}

/* Make an event that is not entered; NO_EVENT if there is no memory. */
int32_t hil_event_new(struct hil_queue *queue, hil_happening happening, void *whose) {
  int32_t number = queue->free;
  if (number != NO_EVENT)
    queue->free = queue->events[number].next_free;
  else if (has_room(queue))
    number = queue->made++;
  else
    return NO_EVENT;
  queue->events[number] = (struct event){.happening = happening, .whose = whose, .place = NO_EVENT};
  return number;
}

static void dispose(struct hil_queue *queue, int32_t number) {
  queue->events[number].next_free = queue->free;
  queue->free = number;
}

/* --- events of C */

/* Enter an event, or move it; the past is now. */
void hil_event_at(struct hil_queue *queue, int32_t number, uint64_t cycle, int32_t order) {
  put_in(queue, number, cycle, order);
}

bool hil_event_on(const struct hil_queue *queue, int32_t number) { return queue->events[number].place != NO_EVENT; }

void hil_event_off(struct hil_queue *queue, int32_t number) {
  if (hil_event_on(queue, number))
    take_out(queue, number);
}

/* --- events of Python */

/* Enter an event and return its number, which is free again once it was due or has left; NO_EVENT: no memory. */
HIL_EXPORT int32_t hil_queue_enter(struct hil_queue *queue, uint64_t cycle, int32_t order) {
  int32_t number = hil_event_new(queue, NULL, NULL);
  if (number != NO_EVENT)
    put_in(queue, number, cycle, order);
  return number;
}

/* As if it were entered anew. */
HIL_EXPORT void hil_queue_move(struct hil_queue *queue, int32_t number, uint64_t cycle, int32_t order) {
  put_in(queue, number, cycle, order);
}

HIL_EXPORT void hil_queue_leave(struct hil_queue *queue, int32_t number) {
  take_out(queue, number);
  dispose(queue, number);
}

/* --- letting them happen */

static bool first_is_of_python(const struct hil_queue *queue) { return !queue->events[queue->heap[0]].happening; }

/* Let the first event happen; false if it went wrong. The number of one of Python is free by then. */
static bool let_first_happen(struct hil_queue *queue) {
  int32_t number = queue->heap[0];
  struct event event = queue->events[number];
  take_out(queue, number);
  queue->time.now = event.cycle;
  if (queue->state)
    queue->state->loop_instructions = 0; /* the program may go elsewhere */
  if (event.happening) {
    event.happening(event.whose);
    return true;
  }
  dispose(queue, number);
  return queue->python(number);
}

/* Let everything happen that is due by a cycle, each at its own. */
HIL_EXPORT void hil_queue_due(struct hil_queue *queue, uint64_t cycle) {
  while (queue->time.next <= cycle)
    if (!let_first_happen(queue))
      return;
  queue->time.now = cycle;
}

/* The same, until `halted` is set; false if it is. */
bool hil_queue_pass(struct hil_queue *queue, uint64_t cycle) {
  while (queue->time.next <= cycle) {
    if (queue->time.halted && first_is_of_python(queue))
      return false;
    if (!let_first_happen(queue) || queue->time.halted)
      return false;
  }
  queue->time.now = cycle;
  return true;
}

/* --- the core whose time it is */

/* End the run of the core after the instruction in flight. */
HIL_EXPORT void hil_queue_cut(struct hil_queue *queue) {
  if (queue->state && queue->state->running) {
    queue->state->limit_cycle = 0;
    queue->state->changed = 1;
  }
}

void hil_queue_serve(struct hil_queue *queue, struct hil_state *state) {
  queue->state = state;
  tell(queue);
}

/* --- its state as bytes */

static size_t bytes_of_events(const struct hil_queue *queue) { return (size_t)queue->made * sizeof *queue->events; }

static size_t bytes_of_heap(const struct hil_queue *queue) { return (size_t)queue->count * sizeof *queue->heap; }

size_t hil_queue_saved_size(const struct hil_queue *queue) {
  return sizeof *queue + bytes_of_events(queue) + bytes_of_heap(queue);
}

uint8_t *hil_queue_save(const struct hil_queue *queue, uint8_t *into) {
  memcpy(into, queue, sizeof *queue);
  into += sizeof *queue;
  if (queue->made) {
    memcpy(into, queue->events, bytes_of_events(queue));
    memcpy(into + bytes_of_events(queue), queue->heap, bytes_of_heap(queue));
  }
  return into + bytes_of_events(queue) + bytes_of_heap(queue);
}

const uint8_t *hil_queue_restore(struct hil_queue *queue, const uint8_t *from) {
  struct event *events = queue->events;
  int32_t *heap = queue->heap, room = queue->room;
  memcpy(queue, from, sizeof *queue);
  from += sizeof *queue;
  queue->events = events;
  queue->heap = heap;
  queue->room = room;
  if (queue->made) {
    memcpy(events, from, bytes_of_events(queue));
    memcpy(heap, from + bytes_of_events(queue), bytes_of_heap(queue));
  }
  return from + bytes_of_events(queue) + bytes_of_heap(queue);
}
