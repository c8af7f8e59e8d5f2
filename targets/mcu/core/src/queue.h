/* What will happen in a chip at which cycle; kept apart from any core, so that a peripheral can be tried without one.
 *
 * An event is of C, with a function to be called, or of Python, which is told its number when it is due. Events of the
 * same cycle happen in the order of `order`, then of being entered. */
#ifndef HIL_QUEUE_H
#define HIL_QUEUE_H

#include "layout.h"

#include <stdbool.h>

struct hil_cpu;
struct hil_queue;
struct hil_state;

/* What Python reads and sets.
 *
 * now: the present cycle: while an event happens that of the event, within an access to a register the one at which its
 *   instruction began.
 * next: the cycle of the next event; UINT64_MAX if there is none. next_is_here: it is one of C.
 * halted: nothing more happens after the present cycle until somebody has looked; set by whoever wants that. Of it, the
 *   bit HALTED_BY_IRQ is for those who let time pass without the core: an interrupt may wake it.
 * happened: since this was last cleared, something has. */
#define HIL_TIME_FIELDS(ONE, MANY) \
    ONE(uint64_t, now) ONE(uint64_t, next) ONE(uint64_t, next_is_here) ONE(uint64_t, halted) ONE(uint64_t, happened)
HIL_STRUCT(hil_time, HIL_TIME_FIELDS);

enum { HALTED_BY_IRQ = 2 };

typedef void (*hil_happening)(void *whose);

enum { NO_EVENT = -1 };

struct hil_queue *hil_queue_new(void);
void hil_queue_free(struct hil_queue *queue);
struct hil_time *hil_time_of(struct hil_queue *queue);

/* Tell a core's state when the next event is due. */
void hil_queue_serve(struct hil_queue *queue, struct hil_state *state);

/* Events of Python. */
int32_t hil_queue_enter(struct hil_queue *queue, uint64_t cycle, int32_t order);
void hil_queue_move(struct hil_queue *queue, int32_t number, uint64_t cycle, int32_t order);
void hil_queue_leave(struct hil_queue *queue, int32_t number);
int32_t hil_queue_due(struct hil_queue *queue, uint64_t cycle);
void hil_queue_cut(struct hil_queue *queue);
int32_t hil_queue_before(struct hil_queue *queue, uint64_t limit);

/* Events of C: made once, entered as often as need be, each at most once at a time; there are as many for good. */
int32_t hil_event_new(struct hil_queue *queue, hil_happening happening, void *whose);
void hil_event_at(struct hil_queue *queue, int32_t number, uint64_t cycle, int32_t order);
void hil_event_off(struct hil_queue *queue, int32_t number);
bool hil_event_on(const struct hil_queue *queue, int32_t number);
void hil_queue_interrupt(struct hil_queue *queue, struct hil_cpu *cpu, uint32_t irq, bool level);
bool hil_queue_here(struct hil_queue *queue, uint64_t cycle);

#endif
