/* A converter of the STM32F1: see adc_f1.c. */
#ifndef HIL_ADC_F1_H
#define HIL_ADC_F1_H

#include "block.h"
#include "queue.h"
#include "requests.h"

struct hil_adc;
struct hil_cpu;

/* What Python is asked and told. */
enum hil_adc_question {
  ADC_VOLTS,    /* put the voltage at channel `value` into the struct, and until when it holds */
  ADC_BEGINS,   /* ADON rises */
  ADC_STABLE,   /* whether t_STAB has passed since then */
  ADC_LISTENS,  /* CR2 may choose other triggers than before */
  ADC_REQUESTS, /* the level of the request to DMA, and of the interrupt, where that is not driven here */
  ADC_DRIVES,
  ADC_NOTES,    /* `enum hil_adc_note` */
};

/* What a program has got wrong, or what is not modelled. */
enum hil_adc_note {
  NOTE_TOO_SOON,    /* a conversion was started within t_STAB of ADON */
  NOTE_WITHOUT_ON,  /* a start by software together with ADON, or without */
  NOTE_NO_SWSTART, NOTE_NO_JSWSTART, /* it is not the trigger that is chosen, or triggers are not enabled */
  NOTE_CAL_OFF,     /* a calibration of a converter that is off */
  NOTE_CALIBRATING, /* a start during a calibration */
  NOTE_NO_DUAL,     /* DUALMOD of a converter that is no master */
  NOTE_RESERVED,    /* a reserved mode */
  NOTE_BROKEN_OFF,  /* an interleaved mode that injected groups break off */
  NOTE_NO_EXTTRIG, NOTE_NO_JEXTTRIG, /* the slave takes no part: it is off, or lacks this bit */
};

typedef uint32_t (*hil_adc_ask)(uint32_t question, uint32_t value);

/* reference_volts: VREF+. volts: what stood at each channel when it was asked for last. until: from this cycle on it has
 *   to be asked for again; whoever knows of another voltage sets it to 0. */
#define HIL_ADC_INPUTS_FIELDS(ONE, MANY) \
    ONE(double, reference_volts) MANY(double, volts, 32) MANY(uint64_t, until, 32)
HIL_STRUCT(hil_adc_inputs, HIL_ADC_INPUTS_FIELDS);

enum { MOST_RANKS = 16 };

/* Channels one after the other.
 *
 * active: conversions were asked for and are not all made. rank: which one of the sequence is next. end: the one before
 * which a trigger's share ends. count: of the sequence. */
struct hil_adc_group {
  bool active;
  uint8_t rank, end, count, sequence[MOST_RANKS];
};

/* clock_cycles: HCLK cycles of a clock of the converter; 0 while it stands still.
 * converting: the group whose conversion is under way. sampling: it has its voltage not yet. step: the event at the end
 *   of that half of it, at `due`; halves, parts: halves / parts of a clock that were left when the clock has changed.
 * sampled: the code. unread: DMA is asked to fetch DR. requests_high, interrupts: as driven last.
 * stable: t_STAB has passed. held: no regular conversion is begun: the other converter has the turn.
 * beside: the next in a circle of converters with the same interrupt.
 * slave, master: of the dual modes. turn: of alternate triggers: the slave's is next. later: the event at which a
 *   converter starts behind the other; slave_next: the slave does. */
struct hil_adc {
  struct hil_block block;    /* first: a block is the converter that it belongs to */
  struct hil_adc_inputs inputs;
  struct hil_queue *queue;
  struct hil_cpu *cpu;       /* whose interrupt `irq` is driven; NULL: Python is told */
  uint32_t irq;
  struct hil_requests *requests; /* where they go; NULL: Python is told */
  uint32_t line;             /* its number */
  hil_adc_ask ask;
  uint32_t clock_cycles;
  struct hil_adc_group regular, injected, *converting;
  bool sampling;
  int32_t step, calibrated, calibration_reset; /* events */
  uint64_t due, halves;
  uint32_t parts, sampled;
  bool unread, requests_high, interrupts, stable, held;
  struct hil_adc *beside, *slave, *master;
  int32_t later;
  bool turn, slave_next;
};

enum { ADC_SR, ADC_CR1, ADC_CR2, ADC_SMPR1, ADC_SMPR2, ADC_JOFR1, ADC_HTR = 9, ADC_LTR, ADC_SQR1, ADC_SQR2, ADC_SQR3,
       ADC_JSQR, ADC_JDR1, ADC_DR = 19 };
enum { ADC_ADON = 1 << 0, ADC_JEXTTRIG = 1 << 15, ADC_EXTTRIG = 1 << 20 }; /* CR2 */
enum { ADC_DUALMOD = 16 };                                                 /* CR1; four bits */

/* adc_f1.c */
bool hil_adc_is_on(const struct hil_adc *adc);
void hil_adc_begin_regular(struct hil_adc *adc);
void hil_adc_begin_injected(struct hil_adc *adc);
void hil_adc_start_regular(struct hil_adc *adc);
void hil_adc_start_injected(struct hil_adc *adc);
void hil_adc_hold(struct hil_adc *adc, bool held);

/* adc_dual.c */
bool hil_adc_dual_new(struct hil_adc *master, struct hil_adc *slave);
uint32_t hil_adc_dual_mode(const struct hil_adc *master);
void hil_adc_dual_changed(struct hil_adc *master);
void hil_adc_dual_regular(struct hil_adc *master);
void hil_adc_dual_injected(struct hil_adc *master);

#endif
