/* How far a run goes: up to its limits, the next alarm and the next event, whichever comes first. */
#ifndef HIL_LIMITS_H
#define HIL_LIMITS_H

#include "cpu.h"

/* A limit further away than these is looked at anew when they are over. */
#define MOST_AT_ONCE ((uint64_t)HIL_UNIT / 2)
#define MOST_CYCLES ((uint64_t)1 << 52)

/* The cycle at which the instruction after the first `retired` begins, in the timing model "flat". */
static inline uint64_t hil_cycle_at(const struct hil_state *state, uint64_t retired) {
  return state->base + (retired - state->since) * state->numerator / state->denominator;
}

static inline uint64_t hil_smaller(uint64_t a, uint64_t b) { return a < b ? a : b; }

static inline uint64_t hil_end_of(const struct hil_state *state) {
  return hil_smaller(state->limit_cycle, hil_smaller(state->alarm, state->due));
}

static inline bool hil_is_over(const struct hil_state *state) {
  return hil_end_of(state) <= state->cycle || state->limit_retired <= state->retired || state->attention;
}

/* How many cycles there are up to the end, from where the timing model counts. */
static inline uint64_t hil_cycles_left(const struct hil_state *state) {
  return hil_smaller(hil_end_of(state) - (state->table ? state->cycle : state->base), MOST_CYCLES);
}

/* After how many instructions since `since` so many cycles since `base` have passed; timing model "flat". */
static inline uint64_t hil_reached_after(const struct hil_state *state, uint64_t cycles) {
  return (cycles * state->denominator + state->numerator - 1) / state->numerator;
}

#endif
