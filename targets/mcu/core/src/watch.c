/* Loops that change nothing: found by a look at what the program does, and passed over by `hil_run`.
 *
 * If a program comes back to the same instruction with the same registers and the same memory, has written no register
 * and has read only such that stay as they are until something happens in the chip, then it does the same over and over
 * until the next event. This covers ``b .``, polling of a status flag and of a variable, and delay loops on a tick that
 * call functions and use the stack. Whole turns of it count as executed.
 *
 * While a look is on, every instruction is followed by a step here, and stores keep what was there before. That is
 * slow, so a look comes at most every `look_wait` instructions: few after one that found something, more after each
 * that did not. */
#include "cpu.h"

#include <string.h>

enum { LONGEST = 128, MOST_LAPS = 3, SHORTEST_WAIT = HIL_FIRST_WAIT, LONGEST_WAIT = 16384, GROWTH = 4 };

void hil_watch_begin(struct hil_cpu *cpu) {
  struct hil_watch *watch = &cpu->watch;
  cpu->near[0] = cpu->near[1] = &cpu->nowhere; /* so that every access is seen */
  cpu->state.watching = 1;
  cpu->state.live = 0;
  cpu->state.lap++;
  watch->before = cpu->state;
  watch->steps = watch->laps = watch->store_count = 0;
  watch->dirty = false;
}

/* Something is about to be stored; what was there first is kept. */
void hil_watch_store(struct hil_cpu *cpu, uint8_t *place, uint32_t size) {
  struct hil_watch *watch = &cpu->watch;
  for (uint32_t n = 0; n < watch->store_count; n++)
    if (watch->stores[n].place == place && watch->stores[n].size == size)
      return;
  if (watch->store_count == MOST_STORES) {
    watch->dirty = true;
    return;
  }
  watch->stores[watch->store_count].place = place;
  watch->stores[watch->store_count].size = size;
  watch->stores[watch->store_count].value = 0;
  memcpy(&watch->stores[watch->store_count++].value, place, size);
}

static bool same_memory(const struct hil_watch *watch) {
  for (uint32_t n = 0; n < watch->store_count; n++)
    if (memcmp(watch->stores[n].place, &watch->stores[n].value, watch->stores[n].size) != 0)
      return false;
  return true;
}

static bool same_registers(const struct hil_state *now, const struct hil_state *before) {
  return memcmp(now->reg, before->reg, sizeof now->reg) == 0 &&
         memcmp(now->floats, before->floats, sizeof now->floats) == 0 && now->exclusive == before->exclusive &&
         now->exclusive_address == before->exclusive_address;
}

/* After each instruction; `at_start` if it led back to where the look began, with the state as others see it. */
enum hil_lap hil_watch_step(struct hil_cpu *cpu, bool at_start) {
  struct hil_watch *watch = &cpu->watch;
  struct hil_state *state = &cpu->state;
  if (watch->dirty || ++watch->steps > LONGEST)
    return LAP_GIVEN_UP;
  if (!at_start || state->retired == watch->before.retired) /* the end of a memory, where one looked, is none */
    return LAP_GOES_ON;
  if (state->live)
    return LAP_COUNTS;
  if (same_memory(watch) && same_registers(state, &watch->before)) {
    state->loop_pc = state->reg[R_PC];
    state->loop_lap = state->lap;
    state->loop_instructions = (uint32_t)(state->retired - watch->before.retired);
    return LAP_SAME;
  }
  if (++watch->laps == MOST_LAPS)
    return LAP_GIVEN_UP;
  state->lap++;
  watch->before = *state;
  watch->store_count = 0;
  return LAP_GOES_ON;
}

/* The look is over; say when the next one comes. One that the limit cut off was not vain. */
void hil_watch_end(struct hil_cpu *cpu, enum hil_lap lap) {
  struct hil_state *state = &cpu->state;
  state->watching = 0;
  if (lap == LAP_SAME) {
    state->look_wait = SHORTEST_WAIT;
  } else if (lap != LAP_GOES_ON) {
    state->loop_instructions = 0;
    state->look_wait = state->look_wait < LONGEST_WAIT / GROWTH ? state->look_wait * GROWTH : LONGEST_WAIT;
  }
  state->look_at = state->retired + state->look_wait;
}
