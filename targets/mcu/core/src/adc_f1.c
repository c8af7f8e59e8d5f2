/* ADC1 to ADC3 of the STM32F1: regular and injected conversions one after the other (RM0008 section 11).
 *
 * A conversion takes the sampling time of its channel and 12.5 clocks. The voltage counts as it is at the end of the
 * sampling time. Nothing remembers an overrun, the new value stands in DR. ADON that is written as 1 again starts the
 * regular group; software starts a group by SWSTART or JSWSTART, one of the eight sources of EXTSEL and JEXTSEL, of whose
 * edges the rising one counts.
 *
 * Choices where the manual is silent:
 *
 * - A conversion begins at the cycle of its trigger; the prescaler has no phase of its own.
 * - A source charges the sampling capacitor at once, whatever its resistance. The first step of the converter is half an
 *   LSB above 0 V.
 * - A trigger of a group that is active already is ignored.
 * - An injected group that is triggered breaks off the regular conversion under way, which begins anew afterwards.
 * - In discontinuous mode EOC is set after each conversion. Without SCAN the first channel of a group is converted alone.
 * - The converter is ideal, calibrated or not: a calibration takes the 83 clocks of DS5319 and finds the code 0. RSTCAL
 *   takes 2 clocks. A calibration of a converter that is off takes as long, and is noted. A group that is to be started
 *   while one is under way is not, which is noted.
 * - A request is made at the end of a conversion alone: DMA that is set later asks for none of those before.
 * - EOC rises at the end of an injected group as well: its description in ADC_SR says "regular or injected".
 * - Without ADON a start has no effect; a start within 1 us of ADON (t_STAB) is noted. */
#include "adc_f1.h"

#include "cpu.h"

#include <stdlib.h>

enum { AWD = 1 << 0, EOC = 1 << 1, JEOC = 1 << 2, JSTRT = 1 << 3, STRT = 1 << 4 }; /* SR */
/* CR1 */
enum { AWDCH = 0x1F, EOCIE = 1 << 5, AWDIE = 1 << 6, JEOCIE = 1 << 7, SCAN = 1 << 8, AWDSGL = 1 << 9, JAUTO = 1 << 10,
       DISCEN = 1 << 11, JDISCEN = 1 << 12, DISCNUM = 13, JAWDEN = 1 << 22, AWDEN = 1 << 23 };
/* CR2 */
enum { CONT = 1 << 1, CAL = 1 << 2, RSTCAL = 1 << 3, DMA = 1 << 8, ALIGN = 1 << 11, JEXTSEL = 12, EXTSEL = 17,
       JSWSTART = 1 << 21, SWSTART = 1 << 22,
       TRIGGERS = ADC_ADON | 7 << JEXTSEL | ADC_JEXTTRIG | 7 << EXTSEL | ADC_EXTTRIG };
enum { BY_SOFTWARE = 7 }; /* of EXTSEL and JEXTSEL */

enum { CALIBRATION_CLOCKS = 83, RESET_CLOCKS = 2, CONVERSION_HALVES = 25, CODES = 1 << 12, ALIGNED_LEFT = 4 };

/* Sampling times in halves of a clock, by SMPx. */
static const uint16_t SAMPLING_HALVES[] = {3, 15, 27, 57, 83, 111, 143, 479};

static uint64_t now(const struct hil_adc *adc) { return hil_time_of(adc->queue)->now; }

static uint32_t *values(struct hil_adc *adc) { return adc->block.registers.values; }

static void note(const struct hil_adc *adc, enum hil_adc_note note) { adc->ask(ADC_NOTES, note); }

bool hil_adc_is_on(const struct hil_adc *adc) { return adc->block.registers.values[ADC_CR2] & ADC_ADON; }

/* --- lines */

static void drive_irq(struct hil_adc *adc) {
  for (struct hil_adc *other = adc->beside; other != adc; other = other->beside)
    if (other->interrupts)
      return;
  if (adc->cpu)
    hil_drive_line(adc->cpu, FIRST_IRQ + adc->irq, adc->interrupts);
  else
    adc->ask(ADC_DRIVES, adc->interrupts);
}

/* Drive the request to DMA and the interrupt from flags and enables; Python may do so again before this returns. */
static void update(struct hil_adc *adc) {
  const uint32_t *r = values(adc);
  bool wanted = adc->unread && r[ADC_CR2] & DMA;
  if (wanted != adc->requests_high) {
    adc->requests_high = wanted;
    if (adc->requests)
      adc->requests->drive(adc->requests, adc->line, wanted);
    else
      adc->ask(ADC_REQUESTS, wanted);
  }
  uint32_t sr = r[ADC_SR], cr1 = r[ADC_CR1];
  bool irq = (sr & EOC && cr1 & EOCIE) || (sr & AWD && cr1 & AWDIE) || (sr & JEOC && cr1 & JEOCIE);
  if (irq != adc->interrupts) {
    adc->interrupts = irq;
    drive_irq(adc);
  }
}

/* --- groups: where a trigger begins, what comes next, where it ends */

static void forget(struct hil_adc_group *group) { *group = (struct hil_adc_group){.count = 1}; }

/* Begin, in discontinuous mode with so many steps, else with 0: all. */
static void begin(struct hil_adc_group *group, uint32_t count, uint32_t steps) {
  group->count = (uint8_t)count;
  if (!steps || group->rank >= count)
    group->rank = 0;
  group->end = (uint8_t)(steps && group->rank + steps < count ? group->rank + steps : count);
  group->active = true;
}

static uint32_t channel(const struct hil_adc_group *group) { return group->sequence[group->rank]; }

/* Whether the whole sequence was converted, once the group is not active any more. */
static bool over(const struct hil_adc_group *group) { return group->rank == 0; }

static void advance(struct hil_adc_group *group) {
  if (++group->rank < group->end)
    return;
  group->active = false;
  if (group->rank >= group->count)
    group->rank = 0;
}

/* --- conversions */

static void go_on_after(struct hil_adc *adc, uint32_t halves) {
  adc->halves = halves;
  adc->parts = 1;
  if (!adc->clock_cycles)
    return;
  adc->due = now(adc) + (uint64_t)halves * adc->clock_cycles / 2;
  hil_event_at(adc->queue, adc->step, adc->due, 0);
}

static uint32_t sampling_halves(struct hil_adc *adc, uint32_t channel) {
  const uint32_t *r = values(adc);
  if (channel < 10)
    return SAMPLING_HALVES[r[ADC_SMPR2] >> 3 * channel & 7];
  return SAMPLING_HALVES[channel < 19 ? r[ADC_SMPR1] >> 3 * (channel - 10) & 7 : 0];
}

/* Begin the next conversion, if none is under way; the injected group first. */
static void proceed(struct hil_adc *adc) {
  if (adc->held || adc->converting)
    return;
  struct hil_adc_group *group = adc->injected.active ? &adc->injected : &adc->regular;
  if (!group->active)
    return;
  adc->converting = group;
  adc->sampling = true;
  go_on_after(adc, sampling_halves(adc, channel(group)));
}

static void break_off(struct hil_adc *adc) {
  hil_event_off(adc->queue, adc->step);
  adc->converting = NULL;
}

static void check_start(struct hil_adc *adc) {
  if (adc->stable)
    return;
  adc->stable = adc->ask(ADC_STABLE, 0);
  if (!adc->stable)
    note(adc, NOTE_TOO_SOON);
}

static void start_regular(struct hil_adc *adc) {
  uint32_t *r = values(adc), cr1 = r[ADC_CR1], count = cr1 & SCAN ? (r[ADC_SQR1] >> 20 & 0xF) + 1 : 1;
  if (adc->regular.active)
    return;
  for (uint32_t rank = 0; rank < count; rank++)
    adc->regular.sequence[rank] = r[ADC_SQR3 - rank / 6] >> 5 * (rank % 6) & 0x1F;
  begin(&adc->regular, count, cr1 & DISCEN ? (cr1 >> DISCNUM & 7) + 1 : 0);
  r[ADC_SR] |= STRT;
  check_start(adc);
  proceed(adc);
}

/* JSQ4 is the last of the sequence, however many there are. */
static void start_injected(struct hil_adc *adc) {
  uint32_t *r = values(adc), cr1 = r[ADC_CR1], all = (r[ADC_JSQR] >> 20 & 3) + 1, count = cr1 & SCAN ? all : 1;
  if (adc->injected.active)
    return;
  for (uint32_t rank = 0; rank < count; rank++)
    adc->injected.sequence[rank] = r[ADC_JSQR] >> 5 * (4 - all + rank) & 0x1F;
  begin(&adc->injected, count, cr1 & JDISCEN ? 1 : 0);
  r[ADC_SR] |= JSTRT;
  check_start(adc);
  if (adc->converting == &adc->regular)
    break_off(adc);
  proceed(adc);
}

static void sample(struct hil_adc *adc) {
  uint32_t at = channel(adc->converting);
  if (now(adc) >= adc->inputs.until[at])
    adc->ask(ADC_VOLTS, at);
  double steps = adc->inputs.volts[at] / adc->inputs.reference_volts * CODES + 0.5;
  adc->sampled = steps <= 0 ? 0 : steps >= CODES - 1 ? CODES - 1 : (uint32_t)steps;
  adc->sampling = false;
  go_on_after(adc, CONVERSION_HALVES);
}

static void watch(struct hil_adc *adc, const struct hil_adc_group *group) {
  uint32_t *r = values(adc), cr1 = r[ADC_CR1];
  if (!(cr1 & (group == &adc->injected ? JAWDEN : AWDEN)) || (cr1 & AWDSGL && channel(group) != (cr1 & AWDCH)))
    return;
  if (adc->sampled < r[ADC_LTR] || adc->sampled > r[ADC_HTR])
    r[ADC_SR] |= AWD;
}

static void keep_injected(struct hil_adc *adc) {
  uint32_t *r = values(adc), rank = adc->injected.rank, shift = r[ADC_CR2] & ALIGN ? ALIGNED_LEFT - 1 : 0;
  r[ADC_JDR1 + rank] = (adc->sampled - r[ADC_JOFR1 + rank]) << shift & 0xFFFF;
  advance(&adc->injected);
  if (adc->injected.active)
    return;
  if (over(&adc->injected))
    r[ADC_SR] |= JEOC | EOC;
  struct hil_adc *other = adc->slave ? adc->slave : adc->master;
  if (other)
    hil_adc_hold(other, false);
}

static void keep_regular(struct hil_adc *adc) {
  uint32_t *r = values(adc), cr1 = r[ADC_CR1], cr2 = r[ADC_CR2];
  r[ADC_DR] = adc->sampled << (cr2 & ALIGN ? ALIGNED_LEFT : 0);
  adc->unread = cr2 & DMA;
  advance(&adc->regular);
  bool ended = !adc->regular.active;
  if (ended || cr1 & DISCEN)
    r[ADC_SR] |= EOC;
  if (!ended || !over(&adc->regular))
    return;
  if (cr1 & JAUTO)
    start_injected(adc);
  if (cr2 & CONT && !(cr1 & DISCEN))
    start_regular(adc);
}

static void on_step(void *whose) {
  struct hil_adc *adc = whose;
  if (adc->sampling) {
    sample(adc);
    return;
  }
  const struct hil_adc_group *group = adc->converting;
  adc->converting = NULL;
  watch(adc, group);
  if (group == &adc->injected)
    keep_injected(adc);
  else
    keep_regular(adc);
  proceed(adc);
  update(adc);
}

/* --- starts */

static bool may_start(struct hil_adc *adc) {
  bool calibrates = hil_event_on(adc->queue, adc->calibrated) || hil_event_on(adc->queue, adc->calibration_reset);
  if (calibrates)
    note(adc, NOTE_CALIBRATING);
  return hil_adc_is_on(adc) && !calibrates;
}

/* Start a group, if it is not under way; lines follow later. */
void hil_adc_begin_regular(struct hil_adc *adc) {
  if (may_start(adc))
    start_regular(adc);
}

void hil_adc_begin_injected(struct hil_adc *adc) {
  if (may_start(adc))
    start_injected(adc);
}

void hil_adc_start_regular(struct hil_adc *adc) {
  hil_adc_begin_regular(adc);
  update(adc);
}

void hil_adc_start_injected(struct hil_adc *adc) {
  hil_adc_begin_injected(adc);
  update(adc);
}

/* Break off a regular conversion and begin nothing, or go on. */
void hil_adc_hold(struct hil_adc *adc, bool held) {
  if (held == adc->held)
    return;
  adc->held = held;
  if (!held)
    proceed(adc);
  else if (adc->converting == &adc->regular)
    break_off(adc);
}

/* What starts a group here may start another's as well. */
static void regular_wanted(struct hil_adc *adc) {
  if (adc->slave)
    hil_adc_dual_regular(adc);
  else
    hil_adc_begin_regular(adc);
}

static void injected_wanted(struct hil_adc *adc) {
  if (adc->slave)
    hil_adc_dual_injected(adc);
  else
    hil_adc_begin_injected(adc);
}

/* A trigger's edge that counts. */
HIL_EXPORT void hil_adc_trigger(struct hil_adc *adc, bool injected) {
  if (injected)
    injected_wanted(adc);
  else
    regular_wanted(adc);
  update(adc);
}

/* --- registers */

static void power_off(struct hil_adc *adc) {
  break_off(adc);
  forget(&adc->regular);
  forget(&adc->injected);
  adc->unread = false;
}

static void calibrate(struct hil_adc *adc, uint32_t bit, int32_t event, uint32_t clocks) {
  if (!hil_adc_is_on(adc))
    note(adc, NOTE_CAL_OFF);
  values(adc)[ADC_CR2] |= bit;
  hil_event_at(adc->queue, event, now(adc) + clocks * (adc->clock_cycles ? adc->clock_cycles : 1), 0);
}

static void on_calibrated(void *whose) {
  struct hil_adc *adc = whose;
  values(adc)[ADC_CR2] &= ~(uint32_t)CAL;
  values(adc)[ADC_DR] = 0;
}

static void on_calibration_reset(void *whose) {
  struct hil_adc *adc = whose;
  values(adc)[ADC_CR2] &= ~(uint32_t)RSTCAL;
}

static void write_control(struct hil_adc *adc, uint32_t value) {
  uint32_t *cr2 = &values(adc)[ADC_CR2], before = *cr2, rising = value & ~before;
  bool starts = value & before & ADC_ADON;
  *cr2 = (before & (CAL | RSTCAL)) | (value & ~(uint32_t)(CAL | RSTCAL | SWSTART | JSWSTART));
  if (!(value & ADC_ADON)) {
    power_off(adc);
  } else if (rising & ADC_ADON) {
    adc->stable = false;
    adc->ask(ADC_BEGINS, 0);
  }
  if (!(value & DMA))
    adc->unread = false;
  if (rising & RSTCAL)
    calibrate(adc, RSTCAL, adc->calibration_reset, RESET_CLOCKS);
  if (rising & CAL)
    calibrate(adc, CAL, adc->calibrated, CALIBRATION_CLOCKS);
  if ((value ^ before) & TRIGGERS)
    adc->ask(ADC_LISTENS, 0);
  if (!starts) {
    if (value & (SWSTART | JSWSTART))
      note(adc, NOTE_WITHOUT_ON);
    return;
  }
  if (value == before)
    regular_wanted(adc);
  if (value & JSWSTART) {
    if (value & ADC_JEXTTRIG && (value >> JEXTSEL & 7) == BY_SOFTWARE)
      injected_wanted(adc);
    else
      note(adc, NOTE_NO_JSWSTART);
  }
  if (value & SWSTART) {
    if (value & ADC_EXTTRIG && (value >> EXTSEL & 7) == BY_SOFTWARE)
      regular_wanted(adc);
    else
      note(adc, NOTE_NO_SWSTART);
  }
}

/* Another sequence begins the group under way anew (section 11.3.3). */
static void begin_anew(struct hil_adc *adc, struct hil_adc_group *group) {
  if (!group->active)
    return;
  forget(group);
  if (adc->converting == group)
    break_off(adc);
  if (group == &adc->injected)
    start_injected(adc);
  else
    start_regular(adc);
  update(adc);
}

static bool read(struct hil_block *block, uint32_t word, uint32_t *value) {
  struct hil_adc *adc = (struct hil_adc *)block;
  uint32_t *r = values(adc);
  if (word > ADC_DR)
    return false;
  *value = r[word];
  if (word != ADC_DR)
    return true;
  adc->unread = false;
  r[ADC_SR] &= ~(uint32_t)EOC;
  update(adc);
  if (adc->slave && hil_adc_dual_mode(adc))
    *value |= adc->slave->block.registers.values[ADC_DR] << 16;
  return true;
}

static bool write(struct hil_block *block, uint32_t word, uint32_t value) {
  struct hil_adc *adc = (struct hil_adc *)block;
  uint32_t *r = values(adc), writable = block->registers.writable[word], before = r[word];
  if (word > ADC_DR)
    return false;
  if (!writable)
    return true;
  value &= writable;
  if (word == ADC_CR1 && !adc->slave && value >> ADC_DUALMOD & 0xF) {
    note(adc, NOTE_NO_DUAL);
    value &= ~(0xFu << ADC_DUALMOD);
  }
  if (word == ADC_SR) /* cleared where a 0 was written */
    r[ADC_SR] &= value;
  else if (word == ADC_CR2)
    write_control(adc, value);
  else
    r[word] = value;
  update(adc);
  if (value == before)
    return true;
  if (word == ADC_SQR1 || word == ADC_SQR2 || word == ADC_SQR3)
    begin_anew(adc, &adc->regular);
  else if (word == ADC_JSQR)
    begin_anew(adc, &adc->injected);
  else if (word == ADC_CR1 && (value ^ before) >> ADC_DUALMOD & 0xF)
    hil_adc_dual_changed(adc);
  return true;
}

/* --- the converter */

/* Go on at another rate; 0 stands still. */
HIL_EXPORT void hil_adc_clock(struct hil_adc *adc, uint32_t cycles) {
  if (adc->converting && adc->clock_cycles) {
    adc->halves = 2 * (adc->due - now(adc));
    adc->parts = adc->clock_cycles;
    hil_event_off(adc->queue, adc->step);
  }
  adc->clock_cycles = cycles;
  if (adc->converting && cycles) {
    uint64_t whole = 2ull * adc->parts;
    adc->due = now(adc) + (adc->halves * cycles + whole - 1) / whole;
    hil_event_at(adc->queue, adc->step, adc->due, 0);
  }
}

/* Go to the state after reset, once the registers have their values. */
HIL_EXPORT void hil_adc_reset(struct hil_adc *adc) {
  hil_event_off(adc->queue, adc->calibrated);
  hil_event_off(adc->queue, adc->calibration_reset);
  adc->held = false;
  power_off(adc);
  adc->ask(ADC_LISTENS, 0);
  update(adc);
  if (adc->slave)
    hil_adc_dual_changed(adc);
}

HIL_EXPORT struct hil_adc_inputs *hil_adc_inputs_of(struct hil_adc *adc) { return &adc->inputs; }

/* Drive an interrupt of a core without asking Python, */
HIL_EXPORT void hil_adc_interrupts(struct hil_adc *adc, struct hil_cpu *cpu, uint32_t irq) {
  adc->cpu = cpu;
  adc->irq = irq;
}

/* and a request to DMA. */
HIL_EXPORT void hil_adc_transfers(struct hil_adc *adc, struct hil_requests *requests, uint32_t line) {
  adc->requests = requests;
  adc->line = line;
}

HIL_EXPORT void hil_adc_free(struct hil_adc *adc) { free(adc); }

static const struct hil_saved SAVED = {.size = sizeof(struct hil_adc)};

/* Make a converter; it shares its interrupt with its master in the dual modes, or has none. Returns NULL if there is no
 * memory left. */
HIL_EXPORT struct hil_adc *hil_adc_new(struct hil_queue *queue, struct hil_adc *master, hil_adc_ask ask) {
  struct hil_adc *adc = calloc(1, sizeof *adc);
  if (!adc)
    return NULL;
  adc->block.saved = &SAVED;
  adc->queue = queue;
  adc->ask = ask;
  adc->block.read = read;
  adc->block.write = write;
  adc->beside = adc;
  forget(&adc->regular);
  forget(&adc->injected);
  adc->step = hil_event_new(queue, on_step, adc);
  adc->calibrated = hil_event_new(queue, on_calibrated, adc);
  adc->calibration_reset = hil_event_new(queue, on_calibration_reset, adc);
  if (adc->step == NO_EVENT || adc->calibrated == NO_EVENT || adc->calibration_reset == NO_EVENT ||
      (master && !hil_adc_dual_new(master, adc))) {
    free(adc);
    return NULL;
  }
  return adc;
}
