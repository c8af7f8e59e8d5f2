/* Loops that change nothing: found by a look at what the program does, and passed over.
 *
 * If a program comes back to the same instruction with the same registers and the same memory, has written no register
 * and has read only such that stay as they are until something happens in the chip, then it does the same over and over
 * until the next event. This covers ``b .``, polling of a status flag and of a variable, and delay loops on a tick that
 * call functions and use the stack. Whole turns of it count as executed.
 *
 * While a look is on, every instruction is followed by a step here, and stores keep what was there before. That is
 * slow, so a look comes at most every `look_wait` instructions: few after one that found something, more after each
 * that did not. */
#include "limits.h"

#include <string.h>

enum { LONGEST = 128, MOST_LAPS = 3, SHORTEST_WAIT = HIL_FIRST_WAIT, LONGEST_WAIT = 16384, GROWTH = 4 };

/* A run begins: say when the first look comes. */
void hil_look_from(struct hil_state *state) {
  if (state->skip == LOOK_ONCE)
    state->look_at = state->retired;
  else if (state->look_at > state->retired + state->look_wait)
    state->look_at = state->retired + state->look_wait;
}

void hil_look_begin(struct hil_cpu *cpu) {
  struct hil_look *look = &cpu->look;
  cpu->near[0] = cpu->near[1] = &cpu->nowhere; /* so that every access is seen */
  cpu->state.looking = 1;
  cpu->state.live = 0;
  cpu->state.lap++;
  look->before = cpu->state;
  look->steps = look->laps = look->store_count = 0;
  look->dirty = look->told = false;
}

/* Begin a look if one is due; say whether. */
bool hil_look_begins(struct hil_cpu *cpu) {
  const struct hil_state *state = &cpu->state;
  if (!state->skip || state->look_at > state->retired || hil_is_over(state))
    return false;
  hil_look_begin(cpu);
  return true;
}

/* Something is about to be stored; what was there first is kept. */
void hil_look_store(struct hil_cpu *cpu, uint8_t *place, uint32_t size) {
  struct hil_look *look = &cpu->look;
  for (uint32_t n = 0; n < look->store_count; n++)
    if (look->stores[n].place == place && look->stores[n].size == size)
      return;
  if (look->store_count == MOST_STORES) {
    look->dirty = true;
    return;
  }
  look->stores[look->store_count].place = place;
  look->stores[look->store_count].size = size;
  look->stores[look->store_count].value = 0;
  memcpy(&look->stores[look->store_count++].value, place, size);
}

static bool same_memory(const struct hil_look *look) {
  for (uint32_t n = 0; n < look->store_count; n++)
    if (memcmp(look->stores[n].place, &look->stores[n].value, look->stores[n].size) != 0)
      return false;
  return true;
}

static bool same_registers(const struct hil_state *now, const struct hil_state *before) {
  return memcmp(now->reg, before->reg, sizeof now->reg) == 0 &&
         memcmp(now->floats, before->floats, sizeof now->floats) == 0 && now->exclusive == before->exclusive &&
         now->exclusive_address == before->exclusive_address;
}

/* After each instruction; `at_start` if it led back to where the look began, with the state as others see it. */
enum hil_lap hil_look_step(struct hil_cpu *cpu, bool at_start) {
  struct hil_look *look = &cpu->look;
  struct hil_state *state = &cpu->state;
  if (look->dirty || ++look->steps > LONGEST)
    return LAP_GIVEN_UP;
  if (!at_start || state->retired == look->before.retired) /* the end of a memory, where one looked, is none */
    return LAP_GOES_ON;
  if (state->live)
    return look->told ? LAP_GIVEN_UP : LAP_COUNTS;
  if (same_memory(look) && same_registers(state, &look->before)) {
    state->loop_pc = state->reg[R_PC];
    state->loop_lap = state->lap;
    state->loop_instructions = (uint32_t)(state->retired - look->before.retired);
    return LAP_SAME;
  }
  if (++look->laps == MOST_LAPS)
    return LAP_GIVEN_UP;
  state->lap++;
  look->before = *state;
  look->store_count = 0;
  look->told = false;
  return LAP_GOES_ON;
}

/* The look is over; say when the next one comes. One that the limit cut off was not vain. */
void hil_look_end(struct hil_cpu *cpu, enum hil_lap lap) {
  struct hil_state *state = &cpu->state;
  state->looking = 0;
  if (lap == LAP_SAME) {
    state->look_wait = SHORTEST_WAIT;
  } else if (lap != LAP_GOES_ON) {
    state->loop_instructions = 0;
    state->look_wait = state->look_wait < LONGEST_WAIT / GROWTH ? state->look_wait * GROWTH : LONGEST_WAIT;
  }
  state->look_at = state->retired + state->look_wait;
}

/* As many whole turns of the loop as end before the limits count as executed. */
static void pass_over(struct hil_state *state, uint64_t instructions, uint64_t cycles) {
  uint64_t turns = (state->limit_retired - state->retired - 1) / instructions, left = hil_cycles_left(state);
  if (state->table) {
    turns = hil_smaller(turns, (left - 1) / cycles);
    state->cycle += turns * cycles;
  } else {
    uint64_t done = state->retired - state->since;
    turns = hil_smaller(turns, (hil_reached_after(state, left) - done - 1) / instructions);
  }
  state->retired += turns * instructions;
  if (!state->table)
    state->cycle = hil_cycle_at(state, state->retired);
}

/* The look has come to a result: pass over the loop that it has found, if any. Returns whether the run goes on. */
bool hil_look_goes_on(struct hil_cpu *cpu, enum hil_lap lap) {
  struct hil_state *state = &cpu->state;
  hil_look_end(cpu, lap);
  state->counting = lap == LAP_COUNTS;
  if (state->counting || state->skip == LOOK_ONCE)
    return false;
  if (lap == LAP_SAME && !cpu->look.told && !hil_is_over(state)) {
    pass_over(state, state->loop_instructions, state->cycle - cpu->look.before.cycle);
    state->look_at = state->retired + state->look_wait; /* none at once, that the limit would cut off */
  }
  return true;
}
