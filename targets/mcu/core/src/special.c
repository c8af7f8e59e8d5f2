/* Special registers: MRS, MSR and CPS (DDI0403 sections B5.2.1 to B5.2.3). */
#include "cpu.h"

enum { IPSR = 0x1FF, NPRIV = 1, SPSEL = 2, FPCA = 4 };

bool hil_is_privileged(const struct hil_state *state) {
  return (state->reg[R_XPSR] & IPSR) || !(state->reg[R_CONTROL] & NPRIV);
}

bool hil_uses_psp(const struct hil_state *state) {
  return !(state->reg[R_XPSR] & IPSR) && state->reg[R_CONTROL] & SPSEL;
}

/* Returns the stack pointer that is named, of which the one in use is in R13. */
static uint32_t *stack_pointer(struct hil_state *state, bool process) {
  if (hil_uses_psp(state) == process)
    return &state->reg[R_SP];
  return &state->reg[process ? R_PSP : R_MSP];
}

/* What MRS reads; what may not be read is 0. */
uint32_t hil_read_special(const struct hil_cpu *cpu, uint32_t number) {
  struct hil_state *state = (struct hil_state *)&cpu->state;
  uint32_t xpsr = state->reg[R_XPSR];
  if (number < 8) {
    uint32_t value = number & 1 ? xpsr & IPSR : 0;
    return number & 4 ? value : value | (xpsr & (cpu->has_dsp ? 0xF80F0000 : 0xF8000000));
  }
  if (number == 20)
    return state->reg[R_CONTROL];
  if (!hil_is_privileged(state))
    return 0;
  switch (number) {
  case 8: return *stack_pointer(state, false);
  case 9: return *stack_pointer(state, true);
  case 16: return state->reg[R_PRIMASK];
  case 17:
  case 18: return state->reg[R_BASEPRI];
  case 19: return state->reg[R_FAULTMASK];
  default: return 0;
  }
}

/* The stack pointer in use may become another one. */
static void write_control(struct hil_cpu *cpu, uint32_t value) {
  struct hil_state *state = &cpu->state;
  uint32_t writable = NPRIV | (state->reg[R_XPSR] & IPSR ? 0 : SPSEL) | (cpu->has_float ? FPCA : 0);
  state->reg[hil_uses_psp(state) ? R_PSP : R_MSP] = state->reg[R_SP];
  state->reg[R_CONTROL] = (state->reg[R_CONTROL] & ~writable) | (value & writable);
  state->reg[R_SP] = state->reg[hil_uses_psp(state) ? R_PSP : R_MSP];
}

static void write_fault_mask(struct hil_state *state, uint32_t value) {
  uint32_t running = state->reg[R_XPSR] & IPSR;
  if (!value || (running != NMI && running != HARD_FAULT))
    state->reg[R_FAULTMASK] = value;
}

/* MSR; returns true if an interrupt mask may have gone. */
bool hil_write_special(struct hil_cpu *cpu, uint32_t number, uint32_t mask, uint32_t value) {
  struct hil_state *state = &cpu->state;
  if (number < 4) {
    uint32_t bits = (mask & 2 ? 0xF8000000 : 0) | (mask & 1 && cpu->has_dsp ? 0x000F0000 : 0);
    state->reg[R_XPSR] = (state->reg[R_XPSR] & ~bits) | (value & bits);
    return false;
  }
  if (!hil_is_privileged(state))
    return false;
  uint32_t level = value & cpu->basepri_bits;
  switch (number) {
  case 8: *stack_pointer(state, false) = value & ~3u; return false;
  case 9: *stack_pointer(state, true) = value & ~3u; return false;
  case 16: state->reg[R_PRIMASK] = value & 1; return true;
  case 17: state->reg[R_BASEPRI] = level; return true;
  case 18:
    if (level && (level < state->reg[R_BASEPRI] || !state->reg[R_BASEPRI]))
      state->reg[R_BASEPRI] = level;
    return true;
  case 19: write_fault_mask(state, value & 1); return true;
  case 20: write_control(cpu, value); return false;
  default: return false;
  }
}

/* CPS: bit 4 disables, bit 1 is for PRIMASK, bit 0 for FAULTMASK; returns as `hil_write_special`. */
bool hil_change_masks(struct hil_cpu *cpu, uint32_t bits) {
  struct hil_state *state = &cpu->state;
  uint32_t disables = bits >> 2 & 1;
  if (!hil_is_privileged(state))
    return false;
  if (bits & 2)
    state->reg[R_PRIMASK] = disables;
  if (bits & 1)
    write_fault_mask(state, disables);
  return !disables;
}
