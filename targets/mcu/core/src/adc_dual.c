/* ADC1 and ADC2 of an STM32F103 together: what a start of ADC1 means in the dual modes (RM0008 section 11.9).
 *
 * ADC1 is the master: its triggers start both. What ADC2 has converted stands in the upper half of ADC1_DR.
 *
 * Choices where the manual is silent:
 *
 * - ADC2 takes part if it is on and triggers are enabled there (EXTTRIG, JEXTTRIG), as the manual demands; else ADC1 goes
 *   alone, which is noted. A trigger of its own starts ADC2 as ever; the manual calls it spurious.
 * - In simultaneous modes each converter goes through its group at its own pace: with the same sampling times, which the
 *   manual demands, they go together.
 * - Interleaved modes that an injected group has broken off go on as each converter does by itself, so that their
 *   distance is not what it was; the first time that this may happen is noted.
 * - In the fast one a trigger within the seven clocks before ADC1 follows moves its start no further.
 * - The turn of alternate triggers begins with ADC1 when the mode is chosen. */
#include "adc_f1.h"

enum { FAST_CLOCKS = 7, SLOW_CLOCKS = 14, LAST_MODE = 9, INJECTED_AND_ALTERNATE = 2 };

/* Sets of modes. */
enum { SIMULTANEOUS = 1 << 1 | 1 << 2 | 1 << 6, FAST = 1 << 3 | 1 << 7, SLOW = 1 << 4 | 1 << 8,
       INJECTED_TOO = 1 << 1 | 1 << 3 | 1 << 4 | 1 << 5, ALTERNATE = 1 << 2 | 1 << 9, BROKEN_OFF = 1 << 3 | 1 << 4 };

/* DUALMOD; 0 where both are independent. */
uint32_t hil_adc_dual_mode(const struct hil_adc *master) {
  return master->block.registers.values[ADC_CR1] >> ADC_DUALMOD & 0xF;
}

static bool in(uint32_t modes, const struct hil_adc *master) { return modes >> hil_adc_dual_mode(master) & 1; }

static bool takes_part(const struct hil_adc *master, uint32_t enable, enum hil_adc_note lacking) {
  if (hil_adc_is_on(master->slave) && master->slave->block.registers.values[ADC_CR2] & enable)
    return true;
  master->ask(ADC_NOTES, lacking);
  return false;
}

static void start_later(struct hil_adc *master, uint32_t clocks) {
  hil_event_at(master->queue, master->later, hil_time_of(master->queue)->now + clocks * master->clock_cycles, 0);
}

/* Let the one convert, and the other 14 clocks later, until one is switched off. */
static void interleave(struct hil_adc *master, bool slave) {
  if (!hil_adc_is_on(master) || !hil_adc_is_on(master->slave) || !master->clock_cycles)
    return;
  hil_adc_start_regular(slave ? master->slave : master);
  master->slave_next = !slave;
  start_later(master, SLOW_CLOCKS);
}

static void on_later(void *whose) {
  struct hil_adc *master = whose;
  if (in(SLOW, master))
    interleave(master, master->slave_next);
  else
    hil_adc_start_regular(master);
}

/* The regular group of ADC1 is to start. */
void hil_adc_dual_regular(struct hil_adc *master) {
  if (in(SLOW, master)) {
    if (!hil_event_on(master->queue, master->later))
      interleave(master, takes_part(master, ADC_EXTTRIG, NOTE_NO_EXTTRIG));
  } else if (in(FAST, master) && takes_part(master, ADC_EXTTRIG, NOTE_NO_EXTTRIG)) {
    hil_adc_start_regular(master->slave);
    if (!hil_event_on(master->queue, master->later))
      start_later(master, FAST_CLOCKS);
  } else {
    if (in(SIMULTANEOUS, master) && takes_part(master, ADC_EXTTRIG, NOTE_NO_EXTTRIG))
      hil_adc_start_regular(master->slave);
    hil_adc_begin_regular(master);
  }
}

static void alternate(struct hil_adc *master) {
  struct hil_adc *unit = master->turn ? master->slave : master, *other = master->turn ? master : master->slave;
  if (unit->injected.active)
    return;
  master->turn = !master->turn;
  if (hil_adc_dual_mode(master) == INJECTED_AND_ALTERNATE) /* the regular groups, which go together, stop together */
    hil_adc_hold(other, true);
  if (unit == master)
    hil_adc_begin_injected(master);
  else
    hil_adc_start_injected(unit);
}

/* Its injected group is. */
void hil_adc_dual_injected(struct hil_adc *master) {
  if (in(ALTERNATE, master) && takes_part(master, ADC_JEXTTRIG, NOTE_NO_JEXTTRIG)) {
    alternate(master);
    return;
  }
  if (in(INJECTED_TOO, master) && takes_part(master, ADC_JEXTTRIG, NOTE_NO_JEXTTRIG))
    hil_adc_start_injected(master->slave);
  hil_adc_begin_injected(master);
}

/* DUALMOD has another value. */
void hil_adc_dual_changed(struct hil_adc *master) {
  hil_event_off(master->queue, master->later);
  master->turn = false;
  hil_adc_hold(master, false);
  hil_adc_hold(master->slave, false);
  if (hil_adc_dual_mode(master) > LAST_MODE)
    master->ask(ADC_NOTES, NOTE_RESERVED);
  if (in(BROKEN_OFF, master))
    master->ask(ADC_NOTES, NOTE_BROKEN_OFF);
}

/* Tie two converters; false: there is no memory left. */
bool hil_adc_dual_new(struct hil_adc *master, struct hil_adc *slave) {
  master->later = hil_event_new(master->queue, on_later, master);
  if (master->later == NO_EVENT)
    return false;
  master->slave = slave;
  slave->master = master;
  slave->beside = master->beside;
  master->beside = slave;
  return true;
}
