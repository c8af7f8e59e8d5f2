/* What will happen in a chip at which cycle; kept apart from any core, so that a peripheral can be tried without one.
 *
 * An event is of C, with a function to be called, or of Python, which is called with its number when it is due. Events
 * of the same cycle happen in the order of `order`, then of being entered. */
#ifndef HIL_QUEUE_H
#define HIL_QUEUE_H

#include "layout.h"

#include <stdbool.h>
#include <stddef.h>

struct hil_cpu;
struct hil_queue;
struct hil_state;

/* What Python reads and sets.
 *
 * now: the present cycle: while an event happens that of the event, within an access to a register the one at which its
 *   instruction began.
 * next: the cycle of the next event; UINT64_MAX if there is none.
 * halted: a run of the core ends before the next event of Python, and after the present one of any kind, until somebody
 *   has looked; set by whoever wants that. */
#define HIL_TIME_FIELDS(ONE, MANY) \
    ONE(uint64_t, now) ONE(uint64_t, next) ONE(uint64_t, halted)
HIL_STRUCT(hil_time, HIL_TIME_FIELDS);

typedef void (*hil_happening)(void *whose);
typedef bool (*hil_happening_of_python)(int32_t number); /* false: it went wrong, and nothing more is to happen */

enum { NO_EVENT = -1 };

struct hil_queue *hil_queue_new(hil_happening_of_python happening);
void hil_queue_free(struct hil_queue *queue);
struct hil_time *hil_time_of(struct hil_queue *queue);

/* Tell a core's state when the next event is due. */
void hil_queue_serve(struct hil_queue *queue, struct hil_state *state);

/* Events of Python. */
int32_t hil_queue_enter(struct hil_queue *queue, uint64_t cycle, int32_t order);
void hil_queue_move(struct hil_queue *queue, int32_t number, uint64_t cycle, int32_t order);
void hil_queue_leave(struct hil_queue *queue, int32_t number);
void hil_queue_due(struct hil_queue *queue, uint64_t cycle);
void hil_queue_cut(struct hil_queue *queue);

/* Events of C: made once, entered as often as need be, each at most once at a time; there are as many for good. */
int32_t hil_event_new(struct hil_queue *queue, hil_happening happening, void *whose);
void hil_event_at(struct hil_queue *queue, int32_t number, uint64_t cycle, int32_t order);
void hil_event_off(struct hil_queue *queue, int32_t number);
bool hil_event_on(const struct hil_queue *queue, int32_t number);
bool hil_queue_pass(struct hil_queue *queue, uint64_t cycle);

/* The state as bytes, to be put back into the same queue; they return what is behind it. See snapshot.c. */
size_t hil_queue_saved_size(const struct hil_queue *queue);
uint8_t *hil_queue_save(const struct hil_queue *queue, uint8_t *into);
const uint8_t *hil_queue_restore(struct hil_queue *queue, const uint8_t *from);

#endif
