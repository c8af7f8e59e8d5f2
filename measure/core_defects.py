"""``python -m measure.core_defects``: errors put into the core in C against the manual's sentences, and who finds each.

Each defect changes one place of the sources in a copy; the library that is made of it runs the random sequences and
floating-point operands of the differential tests, held against Unicorn and the definition, then the vectors by hand,
what the manual says of exceptions, and the self-tests that run on real boards.
What came of each is a row of a table on standard output. The exit code is 0 if each was found.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from targets.mcu.core import build, library, sources

ROOT = Path(__file__).parent.parent
EXCEPTIONS = "tests/targets/mcu/cortexm"
STM32 = "tests/targets/mcu/stm32"
# What tests a peripheral in C, by its file: self-tests on a board, and files.
PERIPHERALS = {
    "usart.c": ("usart", [f"{STM32}f1/usart"]),
    "usart_f1.c": ("usart", [f"{STM32}f1/usart"]),
    "usart_isr.c": ("(serial or usart-fifo) and holds", [f"{STM32}/usart", f"{STM32}h7/test_drain_loop.py"]),
    "dma_f1.c": ("dma or high-density", [f"{STM32}f1/dma"]),
    "dma_stream.c": ("(f767 and dma or dmamux) and holds", [f"{STM32}/dma", f"{STM32}h7"]),
    "requests.c": ("(f767 and (dma or spi) or dmamux) and holds", [f"{STM32}/dma", f"{STM32}f7/test_spi.py"]),
    "adc_f1.c": ("every_check_holds and adc and not (f767 or h753)", [f"{STM32}f1/adc"]),
    "adc_dual.c": ("every_check_holds and adc and not (f767 or h753)", [f"{STM32}f1/adc"]),
    "spi_f1.c": ("every_check_holds and spi and not (f767 or h753)", [f"{STM32}f1/spi"]),
    "spi_words.c": ("every_check_holds and spi and not (f767 or h753)", [f"{STM32}f1/spi"]),
    "port.c": (
        "gpio or pins",
        [f"{STM32}f1/test_gpio.py", f"{STM32}/test_gpio_v2.py", f"{STM32}f1/test_gpio_latches.py"],
    ),
}
SELF_TESTS = [f"tests/targets/firmware/test_{name}.py" for name in ("selftests", "f767_selftests", "h753_blocks")]
VECTORS = [f"tests/targets/mcu/differential/test_vectors{core}.py" for core in ("", "_m7")]
SEQUENCES = (("M3", 2), ("M7", 3))  # images of each core
OPERANDS = 40  # of each floating-point operation
LONGEST_S = 300


class Defect(NamedTuple):
    """A change of a text that stands once in a file, against a section of DDI0403E.e or of the manual named there."""

    name: str
    section: str
    file: str
    old: str
    new: str


def _run(name: str, section: str, old: str, new: str) -> Defect:
    return Defect(name, section, "run.c", old, new)


def _real(name: str, section: str, old: str, new: str) -> Defect:
    return Defect(name, section, "real.c", old, new)


def _nvic(name: str, section: str, old: str, new: str) -> Defect:
    return Defect(name, section, "nvic.c", old, new)


def _systick(name: str, old: str, new: str) -> Defect:
    return Defect(name, "B3.3", "systick.c", old, new)


def _usart(name: str, section: str, old: str, new: str) -> Defect:
    return Defect(name, f"RM0008 {section}", "usart.c", old, new)


def _usart_f1(name: str, section: str, old: str, new: str) -> Defect:
    return Defect(name, f"RM0008 {section}", "usart_f1.c", old, new)


def _usart_isr(name: str, manual: str, old: str, new: str) -> Defect:
    return Defect(name, manual, "usart_isr.c", old, new)


def _dma(name: str, section: str, old: str, new: str) -> Defect:
    return Defect(name, f"RM0008 {section}", "dma_f1.c", old, new)


def _stream(name: str, section: str, old: str, new: str) -> Defect:
    return Defect(name, f"RM0410 {section}", "dma_stream.c", old, new)


def _port(name: str, section: str, old: str, new: str) -> Defect:
    return Defect(name, f"RM0008 {section}", "port.c", old, new)


def _adc(name: str, section: str, old: str, new: str) -> Defect:
    return Defect(name, f"RM0008 {section}", "adc_f1.c", old, new)


def _dual(name: str, section: str, old: str, new: str) -> Defect:
    return Defect(name, f"RM0008 {section}", "adc_dual.c", old, new)


def _spi(name: str, section: str, old: str, new: str) -> Defect:
    return Defect(name, f"RM0008 {section}", "spi_f1.c", old, new)


def _words(name: str, section: str, old: str, new: str) -> Defect:
    return Defect(name, f"RM0008 {section}", "spi_words.c", old, new)


def _entry(name: str, section: str, old: str, new: str) -> Defect:
    return Defect(name, section, "entry.c", old, new)


DEFECTS = (
    _run(
        "ADC without the carry",
        "A7.7.1",
        "ARITHMETIC(ADC, r[op->b], second, c)",
        "ARITHMETIC(ADC, r[op->b], second, 0)",
    ),
    _run("SBC without the borrow", "A7.7.124", "(SBC, r[op->b], ~second, c)", "(SBC, r[op->b], ~second, 1)"),
    _run("RSB the wrong way", "A7.7.119", "(RSB, ~r[op->b], second, 1)", "(RSB, r[op->b], ~second, 1)"),
    _run("CMN compares", "A7.7.25", "(CMN, r[op->b], second, 0)", "(CMN, r[op->b], second, 1)"),
    _run("TEQ tests", "A7.7.187", "(TEQ, r[op->b] ^ second)", "(TEQ, r[op->b] & second)"),
    _run("ORN does not invert", "A7.7.90", "r[op->b] | ~second", "r[op->b] | second"),
    _run("BIC does not invert", "A7.7.15", "LOGICAL(BIC, r[op->b] & ~second)", "LOGICAL(BIC, r[op->b] & second)"),
    _run("overflow of unlike signs", "A2.2.1", "v = ~(x_ ^ y_) & (x_ ^ result)", "v = (x_ ^ y_) & (x_ ^ result)"),
    _run("RRX without the carry", "A2.2.1", "value >> 1 | *carry << 31", "value >> 1"),
    _run(
        "a shift right by 32", "A2.2.1", "by <= 32 ? value >> (by - 1) & 1 : 0", "by < 32 ? value >> (by - 1) & 1 : 0"
    ),
    _run("ASR by over 31", "A2.2.1", "(by < 32 ? by : 31)", "(by < 32 ? by : 30)"),
    _run("MLS adds", "A7.7.75", "r[op->d] - r[op->b] * r[op->c]", "r[op->d] + r[op->b] * r[op->c]"),
    _run("UMULL is signed", "A7.7.204", "LONG_RESULT(UNSIGNED_PRODUCT))", "LONG_RESULT(SIGNED_PRODUCT))"),
    _run("SMLAL does not add", "A7.7.137", "LONG_RESULT(LONG_SUM + SIGNED_PRODUCT)", "LONG_RESULT(SIGNED_PRODUCT)"),
    _run("UMAAL adds one word", "A7.7.202", "UNSIGNED_PRODUCT + r[op->a] + r[op->d]", "UNSIGNED_PRODUCT + r[op->a]"),
    _run(
        "a division by zero gives what is divided",
        "A7.7.127",
        "  if (m == 0)\n    return 0;",
        "  if (m == 0)\n    return (uint32_t)n;",
    ),
    _run("MUL sets no flags", "A7.7.84", "r[op->b] * r[op->c]; SET_NZ(r[op->a])", "r[op->b] * r[op->c]"),
    _run("SXTB extends with zeros", "A7.7.182", "(uint32_t)(int8_t)shifted", "(uint32_t)(uint8_t)shifted"),
    _run("UXTH does not rotate", "A7.7.224", "(uint16_t)shifted(3, r[op->c], op->imm, &value)", "(uint16_t)r[op->c]"),
    _run(
        "REVSH extends with zeros",
        "A7.7.115",
        "(uint32_t)(int16_t)__builtin_bswap16",
        "(uint32_t)(uint16_t)__builtin_bswap16",
    ),
    _run("REV16 of the lower half", "A7.7.114", "(r[op->c] & 0x00FF00FF) << 8)\n", "(r[op->c] & 0x000000FF) << 8)\n"),
    _run("CLZ of zero", "A7.7.24", "__builtin_clz(r[op->c]) : 32", "__builtin_clz(r[op->c]) : 31"),
    _run("UBFX one bit short", "A7.7.193", "op->imm & field_mask(op->e))", "op->imm & field_mask(op->e - 1u))"),
    _run("MOVT clears the lower half", "A7.7.79", "(r[op->a] & 0xFFFF) | op->imm << 16", "op->imm << 16"),
    _run("HI without Z", "A7.3.1", "BRANCH_IF(BHI, c && z)", "BRANCH_IF(BHI, c)"),
    _run("LE without Z", "A7.3.1", "BRANCH_IF(BLE, !z || (n ^ v) >> 31)", "BRANCH_IF(BLE, (n ^ v) >> 31)"),
    _run("GT in an IT block", "A7.3.1", "case 6: result = z && !((n ^ v) >> 31)", "case 6: result = !((n ^ v) >> 31)"),
    _run("CBNZ is CBZ", "A7.7.21", "BRANCH_IF(CBNZ, r[op->b])", "BRANCH_IF(CBNZ, !r[op->b])"),
    _run("BL without bit 0 of LR", "A7.7.18", "r[R_LR] = (PC_OF(op) + 4) | 1;", "r[R_LR] = PC_OF(op) + 4;"),
    _run("ITSTATE loses a condition", "A7.3.2", "(it & 0xE0) | (it << 1 & 0x1F)", "(it & 0xE0) | (it << 1 & 0x0F)"),
    _run("STREX keeps the mark", "A7.7.167", "  state->exclusive = 0;\n  r[op->d] = value;", "  r[op->d] = value;"),
    _run("LDREX does not mark", "A7.7.52", "  state->exclusive = 1;\n", ""),
    _run("VMSR writes reserved bits", "B1.4.7", "& 0xF7C0009F", "& 0xF7C0019F"),
    Defect(
        "constants 00XY00XY the other way", "A5.3.2", "decode.c", "0x00010001, 0x01000100", "0x01000100, 0x00010001"
    ),
    Defect("PC is not aligned for literals", "A7.7.44", "decode.c", "(address + 4) & ~3u", "address + 4"),
    Defect("J1 is not inverted", "A7.7.12", "decode.c", "i1 = !(j >> 1 ^ sign)", "i1 = j >> 1 ^ sign"),
    Defect("saturation without Q", "A7.7.152", "dsp.c", "    *saturated = true;", "    *saturated = false;"),
    Defect("GE of unsigned sums", "A7.7.190", "dsp.c", "value >> lanes->bits : value >= 0", "value >= 0 : value >= 0"),
    Defect(
        "QDADD does not double",
        "A7.7.101",
        "dsp.c",
        "hil_saturate(2 * second, 32, true, q)",
        "hil_saturate(second, 32, true, q)",
    ),
    Defect("SEL the other way", "A7.7.128", "dsp.c", "(n & mask) | (m & ~mask)", "(m & mask) | (n & ~mask)"),
    Defect("SMLAD does not exchange", "A7.7.136", "dsp.c", "    m = hil_rotated(m, 16);", "    m = hil_rotated(m, 0);"),
    Defect("SMMLAR does not round", "A7.7.146", "dsp.c", "(which ? 0x80000000 : 0)", "0"),
    Defect(
        "BASEPRI_MAX raises",
        "B5.2.3",
        "special.c",
        "level < state->reg[R_BASEPRI] || ",
        "level > state->reg[R_BASEPRI] || ",
    ),
    Defect(
        "MSR keeps low bits of SP",
        "B5.2.3",
        "special.c",
        "case 9: *stack_pointer(state, true) = value & ~3u",
        "case 9: *stack_pointer(state, true) = value",
    ),
    Defect("MSR writes Q not", "B5.2.3", "special.c", "mask & 2 ? 0xF8000000", "mask & 2 ? 0xF0000000"),
    Defect("VSUB negates NaN", "A2.5 FPSub", "vfp.c", "m.kind < QUIET_NAN ? hil_negated(m) : m", "hil_negated(m)"),
    Defect(
        "VNMLS negates the product",
        "A7.7.253",
        "vfp.c",
        "op->e == FLOAT_MLS || op->e == FLOAT_NMLA",
        "op->e == FLOAT_MLS || op->e == FLOAT_NMLS",
    ),
    Defect(
        "VCVT of fixed point by FPSCR",
        "A7.7.228",
        "vfp.c",
        "hil_round(number, in->format, TO_NEAREST, in->fpscr)",
        "hil_round(number, in->format, hil_rounding_of(in->fpscr), in->fpscr)",
    ),
    Defect("VCVTA to even", "A7.7.225", "vfp.c", "{TO_NEAREST_AWAY, TO_NEAREST,", "{TO_NEAREST, TO_NEAREST,"),
    Defect(
        "AHP keeps infinities",
        "A2.5 FPRound",
        "vfp.c",
        "alternative && value.kind >= INFINITE",
        "alternative && value.kind > INFINITE",
    ),
    _real("a sum of nothing is -0 upwards", "A2.5 FPAdd", "== TO_MINUS_INFINITY);", "== TO_PLUS_INFINITY);"),
    _real(
        "quiet NaNs first",
        "A2.5 FPProcessNaNs",
        "for (int kind = SIGNALLING_NAN; kind >= QUIET_NAN; kind--)",
        "for (int kind = QUIET_NAN; kind <= SIGNALLING_NAN; kind++)",
    ),
    _real("no IDC", "A2.5 FPUnpack", "    *fpscr |= FPSCR_IDC;\n", ""),
    _real("no DZC", "A2.5 FPDiv", "    *fpscr |= FPSCR_DZC;\n", "    (void)fpscr;\n"),
    _real("underflow where a tiny number is exact", "A2.5 FPRound", "if (!biased && rest)", "if (!biased)"),
    _real("ties to odd", "A2.5 FPRound", "rest == middle && odd", "rest == middle && !odd"),
    _real(
        "the largest number overflows", "A2.5 FPRound", "} else if (biased >= end) {", "} else if (biased + 1 >= end) {"
    ),
    _real(
        "infinity times zero with a quiet addend",
        "A2.5 FPMulAdd",
        "addend.kind == QUIET_NAN && is_infinity_times_zero(a, b)",
        "false",
    ),
    _real(
        "-0 is less than +0",
        "A2.5 FPCompare",
        "int sign_a = a.kind == ZERO ? 0 : a.negative ? -1 : 1",
        "int sign_a = a.negative ? -1 : a.kind == ZERO ? 0 : 1",
    ),
    _real("unordered is less", "A2.5 FPCompare", "    return 3;", "    return 8;"),
    _real("the root loses its rest", "A2.5 FPSqrt", "root << 2 | (rest != 0)", "root << 2"),
    _real("the quotient loses its rest", "A2.5 FPDiv", "quotient | (rest != 0)", "quotient"),
    _real(
        "saturation is inexact",
        "A2.5 FPToFixed",
        "  if (magnitude > most) {\n    *fpscr |= FPSCR_IOC;",
        "  if (magnitude > most) {\n    *fpscr |= FPSCR_IOC | FPSCR_IXC;",
    ),
    _real("DN keeps payloads", "A2.5 FPProcessNaN", "  if (*fpscr & FPSCR_DN)\n    return DEFAULT_NAN;\n", ""),
    _nvic("groups are not looked at", "B1.5.4", "-(2 << prigroup)", "-2"),
    _nvic("equal priorities: the last goes first", "B1.5.4", "[number] < best_priority", "[number] <= best_priority"),
    _nvic("eight bits of priority", "B1.5.4", "(priority & cpu->exceptions.priority_mask)", "priority"),
    _nvic("BASEPRI is not looked at", "B1.5.4", "basepri ? group(&cpu->exceptions, basepri)", "basepri ? 256"),
    _nvic(
        "no line stays pending",
        "B3.4.1",
        "!hil_in(x->high, number) || hil_in(x->active, number)",
        "true",
    ),
    _nvic("a line that stays high is served once", "B3.4.1", "if (hil_in(cpu->exceptions.high, number))", "if (!cpu)"),
    _nvic("STIR does nothing", "B3.4.10", "    hil_pend(cpu, FIRST_IRQ + (value & 0x1FF));\n", ""),
    _nvic("RETTOBASE when nested", "B3.2.4", "active == hil_in(x->active, value)", "active"),
    _nvic("a late arrival is told of by no one", "B1.5.4", "cpu->state.attention = cpu->state.changed = 1;", ""),
    _entry("FAULTMASK stays after return", "B1.5.8", "state->reg[R_FAULTMASK] = 0;", ""),
    _entry(
        "PRIMASK keeps WFI asleep",
        "B1.5.19",
        "hil_boosted_priority(cpu, x->for_event)",
        "hil_boosted_priority(cpu, true)",
    ),
    _entry("sleep on exit is not looked at", "B1.5.19", " && x->scr & SLEEPONEXIT", " && false"),
    _entry(
        "STKALIGN is not looked at", "B1.5.7", "extended || x->ccr & STKALIGN ? top & 4 : 0", "extended ? top & 4 : 0"
    ),
    _entry(
        "returns are not checked", "B1.5.8", "!is_legal(cpu, exc_return, alone)", "is_legal(cpu, exc_return, alone) > 1"
    ),
    _entry("WFE keeps the event", "B1.5.18", "    cpu->exceptions.event = 0;\n", "    (void)cpu;\n"),
    _entry("xPSR in the frame does not say it was aligned", "B1.5.6", "(padding ? ALIGNED : 0)", "0"),
    _entry("EXC_RETURN of the other stack", "B1.5.8", "of_process ? TO_THREAD_PSP : TO_THREAD_MSP", "TO_THREAD_MSP"),
    _entry(
        "the vector of the one that was stacked for",
        "B1.5.6",
        "uint32_t number = x->best, vector;",
        "uint32_t number = x->best + 1, vector;",
    ),
    _entry("LSPACT stays", "B1.5.7", "cpu->exceptions.fpccr &= ~(uint32_t)LSPACT;", ";"),
    _entry(
        "a new context keeps the modes",
        "A2.5.4",
        "(x->last_fpscr & ~(uint32_t)FPDSCR_BITS) | x->fpdscr",
        "x->last_fpscr",
    ),
    _entry(
        "no tail-chaining",
        "B1.5.8",
        "TAIL_CHAIN_CYCLES, TROUBLE_NONE);\n  return go_on(cpu, STEP_LEAVE",
        "TAIL_CHAIN_CYCLES + 1, TROUBLE_NONE);\n  return go_on(cpu, STEP_LEAVE",
    ),
    _entry(
        "exclusive marks live on",
        "A3.4.4",
        "  x->event = x->began = 1;\n  state->exclusive = 0;",
        "  x->event = x->began = 1;",
    ),
    _systick(
        "COUNTFLAG stays", "    timer->flag = 0;\n    plan(cpu, cpu->state.cycle);", "    plan(cpu, cpu->state.cycle);"
    ),
    _systick(
        "VAL keeps COUNTFLAG",
        "timer->value = timer->flag = 0;\n    timer->start",
        "timer->value = 0;\n    timer->start",
    ),
    _systick("a period is too long", "period = timer->load + 1;", "period = timer->load + 2;"),
    _systick("TICKINT is not looked at", "    if (timer->ctrl & TICKINT)\n", ""),
    _systick(
        "LOAD counts at once", "    timer->load = value & WIDTH;", "    timer->load = timer->value = value & WIDTH;"
    ),
    _systick("the reference clock is HCLK", "REFERENCE_DIVIDER = 8", "REFERENCE_DIVIDER = 1"),
    _systick(
        "an access that comes late",
        "  uint64_t now = cpu->state.cycle;\n  hil_tick(cpu);\n",
        "  uint64_t now = cpu->state.cycle;\n",
    ),
    _systick(
        "enabling reloads", "if (stood && counts(timer) && !timer->value)", "if (stood && (timer->value = timer->load))"
    ),
    _systick("no end of a run at a tick", "    cpu->state.changed = 1;\n}", "    cpu->state.changed = 0;\n}"),
    _usart_f1("TXE is not set", "27.3.2", "{ flag(usart, TXE); }", "{ flag(usart, 0); }"),
    _usart_f1("TC is not set", "27.3.2", "{ flag(usart, TC); }", "{ flag(usart, 0); }"),
    _usart_f1("TC is not cleared by SR and DR", "27.6.1", "CLEARED_BY_DR_WRITE = PE | TC", "CLEARED_BY_DR_WRITE = PE"),
    _usart_f1(
        "TC is cleared by DR alone", "27.6.1", "TXE | (line->seen & CLEARED_BY_DR_WRITE)", "TXE | CLEARED_BY_DR_WRITE"
    ),
    _usart_f1("RXNE is not cleared by DR", "27.6.1", "RXNE | (line->seen", "0 | (line->seen"),
    _usart_f1(
        "errors are cleared by DR alone",
        "27.6.1",
        "RXNE | (line->seen & CLEARED_BY_DR_READ)",
        "RXNE | CLEARED_BY_DR_READ",
    ),
    _usart_f1("flags are not cleared by writing 0", "27.6.1", "r[SR] &= value;", ";"),
    _usart_f1(
        "an overrun takes the new word",
        "27.3.3",
        "  if (!(*sr & RXNE)) {\n    line->received = word;",
        "  line->received = word;\n  if (!(*sr & RXNE)) {",
    ),
    _usart_f1("no parity error", "27.3.6", "parity_wrong(line, word) ? PE : 0", "0"),
    _usart_f1("no noise", "27.3.3", "noise ? NE : 0", "0"),
    _usart_f1("no framing error", "27.3.3", "framing_error ? FE : 0", "0"),
    _usart_f1("no IDLE", "27.3.3", "flag(usart, IDLE)", "flag(usart, 0)"),
    _usart_f1("mute mode hides nothing", "27.3.7", "return r[CR1] & RWU;", "return false;"),
    _usart_f1("every address is mine", "27.3.7", "(word & ADD) == (r[CR2] & ADD)", "true"),
    _usart_f1("errors interrupt without DMA", "27.6.6", "cr3 & EIE && cr3 & DMAR", "cr3 & EIE"),
    _usart_f1("no interrupt of CTS", "27.6.6", "sr & CTS && cr3 & CTSIE", "false"),
    _usart_f1("no interrupt of a LIN break", "27.6.5", "sr & LBD && r[CR2] & LBDIE", "false"),
    _usart_f1("DMA is asked to send while TXE is clear", "27.3.13", "cr3 & DMAT && sr & TXE", "!!(cr3 & DMAT)"),
    _usart_f1("DMA is not asked to receive", "27.3.13", "cr3 & DMAR && sr & RXNE", "false"),
    _usart_f1("RTS is always low", "27.3.14", "tell(NEWS_RTS, sr & RXNE, 0)", "tell(NEWS_RTS, 0, 0)"),
    _usart_isr("TC stays", "RM0410 34.8.11", "~(uint32_t)(TXE | TC | TXFE)", "~(uint32_t)(TXE | TXFE)"),
    _usart_isr("TXFE stays", "RM0433 48.7.10", "~(uint32_t)(TXE | TC | TXFE)", "~(uint32_t)(TXE | TC)"),
    _usart_isr("DATAINV one way only", "RM0410 34.8.2", "word = inverted(usart, bits), data", "word = bits, data"),
    _usart_isr("MSBFIRST one way only", "RM0410 34.8.2", "(word ^ data) | turned(usart, data)", "(word ^ data) | data"),
    _usart_isr(
        "OVRDIS is not looked at",
        "RM0410 34.8.3",
        "  if (is_full(usart) && !(r[CR3] & OVRDIS))\n",
        "  if (is_full(usart))\n",
    ),
    _usart_isr("ICR clears nothing", "RM0410 34.8.9", "(value & CLEARED_BY_ICR) |", "0 |"),
    _usart_isr("no match", "RM0410 34.8.8", "    r[ISR] |= CMF;", "    ;"),
    _usart_isr("mute mode hides nothing", "RM0410 34.5.7", "if (!(r[CR1] & MME))", "if (true)"),
    _usart_isr("every address is mine", "RM0410 34.5.7", "is_mine = !(", "is_mine = true || !("),
    _usart_isr("a break has no end", "RM0410 34.8.8", "&= ~(uint32_t)SBKF", "&= ~0u"),
    _usart_isr("an overrun is not flagged", "RM0410 34.5.3", "    r[ISR] |= ORE;", "    ;"),
    _usart_isr("no IDLE", "RM0410 34.5.3", "flag(usart, IDLE)", "flag(usart, 0)"),
    _usart_isr("DDRE is not looked at", "RM0410 34.8.3", "refused = cr3 & DDRE &&", "refused = false &&"),
    _usart_isr("RDR has no place of its own", "RM0433 48.7.10", "RX_WORDS = 17", "RX_WORDS = 16"),
    _usart_isr("the FIFO does not go on", "RM0433 48.5.4", "fifo->first++ %", "fifo->first %"),
    _usart_isr("seventeen wait", "RM0433 48.5.4", "TX_WORDS = 16", "TX_WORDS = 17"),
    _usart_isr("a threshold is one off", "RM0433 48.7.4", "(received >= threshold", "(received > threshold"),
    _usart_isr("TXFT before its time", "RM0433 48.7.4", "empty >= threshold", "1 + empty >= threshold"),
    _usart_isr("RXFTIE asks nobody", "RM0433 48.7.4", "cr3 & RXFTIE ? RXFT : 0", "cr3 & RXFTIE ? 0 : 0"),
    _usart_isr("TXFTIE asks nobody", "RM0433 48.7.4", "cr3 & TXFTIE ? TXFT : 0", "cr3 & TXFTIE ? 0 : 0"),
    _usart_isr(
        "OVRDIS does not pass it by",
        "RM0433 48.7.4",
        "  if (has_fifos(usart) && !(r[CR3] & OVRDIS)) {",
        "  if (has_fifos(usart)) {",
    ),
    _usart_isr(
        "the next word is not shown",
        "RM0433 48.5.4",
        "      show_first(usart);\n      hil_queue_cut",
        "      hil_queue_cut",
    ),
    _usart_isr("a read of RDR is passed over", "RM0433 48.5.4", "hil_queue_cut(usart->queue);", ";"),
    _usart("no preamble", "27.3.2", "line->enabled = line->preamble_due = on", "line->enabled = on"),
    _usart(
        "always one stop bit",
        "27.3.2",
        "(1 + line->word_bits) + 8 * line->stop_half_bits",
        "(1 + line->word_bits) + 16",
    ),
    _usart("parity the wrong way", "27.3.6", "is_odd ^ (line->parity == 2)", "is_odd ^ (line->parity != 2)"),
    _usart("a break has no stop bit", "27.3.2", "line->end += 8 * break_stop(line)", "line->end += 0"),
    _usart("the data register is not held back by CTS", "27.3.14", "line->holds && line->clear_to_send", "line->holds"),
    _usart("TC although a word waits", "27.3.2", "line->data_sent && !line->holds", "line->data_sent"),
    _usart(
        "the line is idle after half a frame",
        "27.3.3",
        "= frame_sixteenths(&usart->line)",
        "= frame_sixteenths(&usart->line) / 2",
    ),
    _usart("a start bit does not end the wait for an idle line", "27.3.3", "cycle <= usart->line.quiet_until", "false"),
    _dma("no half transfer", "13.3.3", "left == reload >> 1 ? HTIF : 0", "0"),
    _dma("a circle ends", "13.3.3", "left = reload;", ";"),
    _dma("a circle of memory to memory", "13.3.3", "control & CIRC && !(control & MEM2MEM)", "control & CIRC"),
    _dma("priorities are not looked at", "13.3.2", "[CCR] >> PL & 3", "[CCR] >> PL & 0"),
    _dma("of equals the last wins", "13.3.2", "own > priority", "own >= priority"),
    _dma("registers are written while enabled", "13.4.4", "} else if (r[CCR] & EN) {", "} else if (0) {"),
    _dma("CGIF clears itself only", "13.4.2", "(bits & GIF ? FLAGS : bits)", "bits"),
    _dma("GIF is not set", "13.4.1", "(flags(dma, n) | GIF)", "flags(dma, n)"),
    _dma("an error leaves the channel on", "13.3.4", "[CCR] = control & ~(uint32_t)EN;", "[CCR] = control;"),
    _dma("no transfer error", "13.3.4", "flag(dma, n, TEIF);", ";"),
    _dma(
        "wide targets are filled with the value again",
        "13.3.5",
        "*value = (uint32_t)answer;",
        "*value = (uint32_t)answer * 0x101;",
    ),
    _dma("the peripheral's address goes on always", "13.3.3", "if (control & PINC)", "if (true)"),
    _dma(
        "the memory's address goes on by the peripheral's width",
        "13.3.3",
        "memory += memory_size",
        "memory += peripheral_size",
    ),
    _dma("widths the wrong way round", "13.4.3", "PSIZE = 8, MSIZE = 10", "PSIZE = 10, MSIZE = 8"),
    _dma(
        "interrupts without their enables",
        "13.3.6",
        "flags(dma, other) & registers(dma, other)[CCR]",
        "flags(dma, other)",
    ),
    _dma("channel 5 has an interrupt of its own", "table 63", "n < dma->irqs ? n : dma->irqs - 1", "n"),
    _dma("a shared interrupt is that of the last", "table 63", "level |= (flags", "level = (flags"),
    _dma("a channel with nothing left goes on", "13.4.4", "r[CCR] & EN && r[CNDTR] && (", "r[CCR] & EN && ("),
    _stream("MINC is not looked at", "8.3.9", "stream->memory += setting->memory_step", "stream->memory += 0"),
    _stream(
        "PINC is not looked at", "8.3.9", "stream->peripheral += setting->peripheral_step", "stream->peripheral += 0"
    ),
    _stream("PINCOS is not looked at", "8.5.5", "control & PINCOS &&", "false &&"),
    _stream(
        "the FIFO is not emptied at the end",
        "8.3.12",
        "if (stream->closing || !stream->left || !setting->fifo)",
        "if (!stream->left || !setting->fifo)",
    ),
    _stream("direct mode has a threshold", "8.3.12", "it.fifo = fcr & DMDIS || between", "it.fifo = true"),
    _stream("half comes with the end", "8.3.10", "(stream->count + 1) / 2 *", "stream->count *"),
    _stream("every burst fits", "8.3.13", "return setting->memory_beats == 1 ||", "return true ||"),
    _stream(
        "a word in the FIFO is turned round",
        "8.3.12",
        "stream->fifo[n] << 8 * n",
        "stream->fifo[size - 1 - n] << 8 * n",
    ),
    _stream(
        "EN stays",
        "8.3.10",
        "  stream->runs = stream->in_access = false;\n  registers(dma, n)[CR] &= ~(uint32_t)EN;",
        "  stream->runs = stream->in_access = false;",
    ),
    _stream("a bus error is nothing", "8.3.18", "  stop(dma, n);\n  flag(dma, n, why);", "  stop(dma, n);"),
    _stream("no circle", "8.3.10", "if (stream->setting.circular && !stream->closing)", "if (false)"),
    _stream("one buffer", "8.3.11", "stream->setting.twice ? CT : 0", "0"),
    _stream("NDTR is not locked", "8.5.6", "} else if (registers(dma, n)[CR] & EN) {", "} else if (false) {"),
    _stream("NDTR does not come back", "8.5.6", ": stream->reload;", ": 0;"),
    _stream("no interrupt", "8.4", "(r[CR] & ENABLES) << 1", "0"),
    _stream("no interrupt of the FIFO", "8.4", "stream->flags & FEIF && r[FCR] & FEIE", "false"),
    _stream("a request is never answered", "8.3.3", "dma->lines->lines[selected[each]].once = false;", ";"),
    _stream("nobody hears of the last", "8.3.15", "if (dma->lines->lines[selected[each]].tells_last)", "if (false)"),
    _stream(
        "the lowest priority wins", "8.3.4", "best == STREAMS || own > priority", "best == STREAMS || own < priority"
    ),
    _stream(
        "an access comes a cycle early", "8.3.4", "port->cycles * dma->bus_cycle", "port->cycles * dma->bus_cycle - 1"
    ),
    _stream("a burst is one beat long", "8.3.13", "(beats - 1) * dma->bus_cycle", "dma->bus_cycle"),
    _stream("every controller goes between memories", "8.3.6", "BETWEEN && !dma->between_memories", "BETWEEN && false"),
    _stream("a buffer in use may be moved", "8.3.11", "what == (r[CR] & CT ? M1AR : M0AR)", "false"),
    _stream("FS is not shown", "8.5.10", "| status << FS", "| 0u << FS"),
    _stream("an overwritten item is not flagged", "8.3.18", "    stream->happened |= DMEIF;", "    ;"),
    _stream(
        "the first request of a channel alone",
        "8.3.3",
        "stream->selected[each] = lines[each];",
        "stream->selected[each] = lines[0];",
    ),
    Defect("nothing is ever left", "RM0410 35.9.2", "requests.c", "left += hil", "left += 0 * hil"),
    Defect("a request taken back is served", "RM0410 8.3.3", "requests.c", "line->once && level", "line->once"),
    Defect(
        "streams 0 of both controllers are one",
        "RM0433 17.3.1",
        "requests.c",
        "hil_stream_asked(lines->controllers[n / STREAMS]",
        "hil_stream_asked(lines->controllers[0]",
    ),
    _adc("sampling always takes 1.5 clocks", "11.6", ">> 3 * channel & 7]", ">> 3 * channel & 0]"),
    _adc("SMPR1 is not looked at", "11.12.4", "r[ADC_SMPR1] >> 3 * (channel - 10) & 7", "0"),
    _adc("13 clocks of conversion", "11.6", "CONVERSION_HALVES = 25", "CONVERSION_HALVES = 26"),
    _adc(
        "the voltage counts at the beginning", "11.6", "    adc->ask(ADC_VOLTS, at);", "    adc->inputs.until[at] = 1;"
    ),
    _adc("a voltage is never forgotten", "11.6", "now(adc) >= adc->inputs.until[at]", "!adc->inputs.until[at]"),
    _adc("the last code is not reached", "11.1", "steps >= CODES - 1 ? CODES - 1", "steps >= CODES - 1 ? CODES - 2"),
    _adc("ADON starts whatever is changed with it", "11.12.3", "if (value == before)\n    regular", "regular"),
    _adc("ADON once more starts nothing", "11.12.3", "if (value == before)\n    regular", "if (false)\n    regular"),
    _adc(
        "SWSTART starts without EXTTRIG too", "11.12.3", "value & ADC_EXTTRIG && (value >> EXTSEL", "(value >> EXTSEL"
    ),
    _adc("SWSTART starts beside another trigger", "11.12.3", "(value >> EXTSEL & 7) == BY_SOFTWARE", "true"),
    _adc("the calibration never ends", "11.4", "values(adc)[ADC_CR2] &= ~(uint32_t)CAL;", ";"),
    _adc("the calibration ends at once", "11.4", "CALIBRATION_CLOCKS = 83", "CALIBRATION_CLOCKS = 0"),
    _adc("a calibration does not matter", "11.4", "hil_adc_is_on(adc) && !calibrates", "hil_adc_is_on(adc)"),
    _adc("an injected group sets no EOC", "11.12.1", "|= JEOC | EOC", "|= JEOC"),
    _adc("JEOC comes after each conversion", "11.12.1", "  if (over(&adc->injected))\n", ""),
    _adc("EOC comes after each conversion", "11.12.1", "if (ended || cr1 & DISCEN)", "if (true)"),
    _adc("DISCEN is not looked at", "11.3.10", "cr1 & DISCEN ? (cr1 >> DISCNUM & 7) + 1 : 0", "0"),
    _adc("discontinuous mode begins with the first", "11.3.10", "!steps || group->rank >= count", "true"),
    _adc("JDISCEN is not looked at", "11.3.10", "cr1 & JDISCEN ? 1 : 0", "0"),
    _adc("SCAN is not looked at", "11.3.8", "cr1 & SCAN ? (r[ADC_SQR1] >> 20 & 0xF) + 1 : 1", "1"),
    _adc("all of the sequence in SQR3", "11.12.9", "r[ADC_SQR3 - rank / 6]", "r[ADC_SQR3]"),
    _adc("injected the other way round", "11.12.12", "5 * (4 - all + rank)", "5 * rank"),
    _adc("CONT is not looked at", "11.3.5", "cr2 & CONT &&", "false &&"),
    _adc("JAUTO is not looked at", "11.3.9", "if (cr1 & JAUTO)", "if (false)"),
    _adc(
        "an injected group waits",
        "11.3.9",
        "if (adc->converting == &adc->regular)\n    break_off(adc);\n  proceed",
        "proceed",
    ),
    _adc("left alignment is none", "11.5", "cr2 & ALIGN ? ALIGNED_LEFT : 0", "0"),
    _adc("injected data without their offset", "11.5", "adc->sampled - r[ADC_JOFR1 + rank]", "adc->sampled"),
    _adc("injected data aligned as regular ones", "11.5", "ALIGNED_LEFT - 1 : 0", "ALIGNED_LEFT : 0"),
    _adc("no watchdog", "11.3.7", "    r[ADC_SR] |= AWD;", "    ;"),
    _adc("the watchdog barks at its threshold", "11.3.7", "adc->sampled < r[ADC_LTR]", "adc->sampled <= r[ADC_LTR]"),
    _adc("the watchdog of one watches all", "11.3.7", "cr1 & AWDSGL &&", "false &&"),
    _adc("one watchdog for both groups", "11.3.7", "group == &adc->injected ? JAWDEN : AWDEN", "JAWDEN | AWDEN"),
    _adc("another sequence does not begin again", "11.3.3", "begin_anew(adc, &adc->regular);", ";"),
    _adc("another injected sequence does not, either", "11.3.3", "begin_anew(adc, &adc->injected);", ";"),
    _adc("no request to DMA", "11.8", "adc->unread = cr2 & DMA;", ""),
    _adc("DR leaves the request", "11.8", "  adc->unread = false;\n  r[ADC_SR]", "  r[ADC_SR]"),
    _adc("a request for what was there before", "11.8", "  if (!(value & DMA))\n    adc->unread = false;\n", ""),
    _adc("DR leaves EOC", "11.12.1", "r[ADC_SR] &= ~(uint32_t)EOC;", ";"),
    _adc("flags are cleared by ones", "11.12.1", "r[ADC_SR] &= value;", "r[ADC_SR] &= ~value;"),
    _adc("off it goes on", "11.12.3", "    power_off(adc);\n  } else", "  } else"),
    _adc("the interrupt never comes", "11.11", "adc->interrupts = irq;", "adc->interrupts = false;"),
    _adc(
        "one converter takes the other's interrupt back", "11.11", "    if (other->interrupts)\n      return;", "    ;"
    ),
    _adc("DUALMOD of a slave is kept", "11.12.2", "    value &= ~(0xFu << ADC_DUALMOD);", "    ;"),
    _adc(
        "another rate is for the next conversion",
        "11.2",
        "adc->due = now(adc) + (adc->halves",
        "adc->due = adc->due + 0 * (adc->halves",
    ),
    _adc("ADC2 is not in the word of ADC1", "11.9", "values[ADC_DR] << 16", "values[ADC_DR] << 16 & 0"),
    _adc("ADC2 is there without a dual mode", "11.9", "adc->slave && hil_adc_dual_mode(adc)", "adc->slave"),
    _dual("the slave stays where it is", "11.9.2", "if (in(SIMULTANEOUS, master) &&", "if (false &&"),
    _dual("injected, ADC1 alone", "11.9.1", "if (in(INJECTED_TOO, master) &&", "if (false &&"),
    _dual("alternate triggers are all for ADC1", "11.9.5", "master->turn = !master->turn;", ";"),
    _dual(
        "alternate triggers do not stop the others",
        "11.9.8",
        "hil_adc_hold(other, true);",
        "hil_adc_hold(other, false);",
    ),
    _dual("fast interleaved, ADC1 never comes", "11.9.3", "start_later(master, FAST_CLOCKS);", ";"),
    _dual("fast interleaved, eight clocks", "11.9.3", "FAST_CLOCKS = 7", "FAST_CLOCKS = 8"),
    _dual("slow interleaved, always the same", "11.9.4", "slave_next = !slave;", "slave_next = slave;"),
    _dual("slow interleaved, for ever", "11.9.4", "!hil_adc_is_on(master->slave) || ", ""),
    _dual("another mode leaves ADC1 on its way", "11.9", "  hil_event_off(master->queue, master->later);\n", ""),
    _dual(
        "the slave takes part without its triggers",
        "11.9",
        " && master->slave->block.registers.values[ADC_CR2] & enable",
        "",
    ),
    _spi("words take half as long", "25.5.1", "<< (control >> BR & 7)", "<< (control >> BR & 7) >> 1"),
    _spi("always eight bits", "25.5.1", "control & DFF ? 16 : 8", "control & 0 ? 16 : 8"),
    _spi("TXE stays", "25.5.3", "&= ~(uint32_t)TXE", "&= ~(uint32_t)0"),
    _spi("TXE never comes again", "25.5.3", "|= TXE", "|= 0"),
    _spi("DR leaves RXNE", "25.5.3", "&= ~(uint32_t)RXNE", "&= ~(uint32_t)0"),
    _spi("RXNE never comes", "25.5.3", "    r[SR] |= RXNE;", "    ;"),
    _spi("no overrun", "25.3.10", "r[SR] |= OVR;", ";"),
    _spi("an overrun has the last word", "25.3.10", "r[SR] |= OVR;", "r[SR] |= OVR, r[DR] = word;"),
    _spi("SR alone ends an overrun", "25.3.10", "*sr & OVR && spi->read_dr", "*sr & OVR"),
    _spi("DR alone ends an overrun", "25.3.10", "&= ~(uint32_t)RXNE", "&= ~(uint32_t)(RXNE | OVR)"),
    _spi("an overrun never ends", "25.3.10", "*sr &= ~(uint32_t)OVR;", ";"),
    _spi(
        "an overrun remembers a read of DR before it",
        "25.3.10",
        "r[SR] |= OVR;\n    spi->read_dr = false;",
        "r[SR] |= OVR;",
    ),
    _spi("no mode fault by SSI", "25.3.10", "return !(control & SSI);", "return false;"),
    _spi("no mode fault by NSS", "25.3.10", "  if (!is_master(spi))\n    return;\n", "  return;\n"),
    _spi(
        "a mode fault leaves MSTR",
        "25.3.10",
        "r[SR] |= MODF;\n    r[CR1] &= ~(uint32_t)(SPE | MSTR);",
        "r[SR] |= MODF;",
    ),
    _spi("MODF holds nothing", "25.3.10", "value &= ~(uint32_t)(SPE | MSTR);", ";"),
    _spi("MODF never ends", "25.3.10", "r[SR] &= ~(uint32_t)MODF;", ";"),
    _spi("MODF ends with CR1 alone", "25.3.10", "if (spi->saw_modf)", "if (true)"),
    _spi("SSOE lets NSS matter", "25.3.1", "!(values(spi)[CR2] & SSOE) && !spi", "!spi"),
    _spi("NSS is not driven", "25.3.1", "(drives_nss ? 2 : 0)", "0"),
    _spi("receive-only stops by itself", "25.3.5", "if (receives_only(values(spi)[CR1]))", "if (false)"),
    _spi("RXONLY is not looked at", "25.5.1", ": control & RXONLY;", ": false;"),
    _spi(
        "one wire out receives",
        "25.3.4",
        "(control & (BIDIMODE | BIDIOE)) == (BIDIMODE | BIDIOE);",
        "false && control;",
    ),
    _spi("one wire in is busy", "25.3.7", "(BIDIMODE | BIDIOE)) != BIDIMODE;", "(BIDIMODE | BIDIOE)) != 1;"),
    _spi("BSY never comes", "25.3.7", "shows_busy(spi) ? BSY : 0", "0"),
    _spi("LSBFIRST is not looked at", "25.5.1", "control & LSBFIRST ? reversed(word", "control & 0 ? reversed(word"),
    _spi("the CRC is not sent", "25.3.6", "        spi->has_word = true;\n", ""),
    _spi("the CRC is not compared", "25.3.6", "r[SR] |= CRCERR;", ";"),
    _spi("one wire out compares its CRC", "25.3.6", "!transmits_only(control) && received", "received"),
    _spi("CRCNEXT stays", "25.5.1", "r[CR1] &= ~(uint32_t)CRCNEXT;", ";"),
    _spi("CRCNEXT does not wait for the last word", "25.3.6", "!spi->has_word && (spi->crc_next", "(spi->crc_next"),
    _spi("no CRC after DMA", "25.3.7", " || last_of_dma(spi)", ""),
    _spi("a CRC of 16 bits", "25.3.6", "crc >> (bits - 1)", "crc >> 15"),
    _spi("CRCEN keeps the last CRC", "25.3.6", "r[RXCRCR] = r[TXCRCR] = 0;", ";"),
    _spi(
        "CRCERR is cleared by ones",
        "25.5.3",
        "r[SR] &= value | ~(uint32_t)CRCERR;",
        "r[SR] &= ~value | ~(uint32_t)CRCERR;",
    ),
    _spi("TXEIE is not looked at", "25.3.11", "(sr & TXE && cr2 & TXEIE) || ", ""),
    _spi("RXNEIE is not looked at", "25.3.11", "(sr & RXNE && cr2 & RXNEIE) || ", ""),
    _spi("ERRIE is not looked at", "25.3.11", " || (sr & (OVR | MODF | CRCERR) && cr2 & ERRIE)", ""),
    _spi("no request to send", "25.3.9", "sr & TXE && cr2 & TXDMAEN,", "false,"),
    _spi("no request to read", "25.3.9", "sr & RXNE && cr2 & RXDMAEN}", "false}"),
    _spi("off, a word is broken off", "25.3.8", "spi->busy && r[CR1] & MSTR", "false"),
    _spi("no slave by MSTR", "25.3.3", "(control & (SPE | MSTR)) != SPE || ", ""),
    _spi("a slave sends nothing", "25.3.3", "    sent = r[DR];\n", "    sent = 0;\n"),
    _spi("the rate is that of the beginning", "25.5.1", "if (!wires->clock_cycles)", "if (!wires->half_cycles)"),
    _words(
        "a word ends with its last edge but one",
        "25.3.1",
        "(uint64_t)spi->wires.halves",
        "(uint64_t)(spi->wires.halves - 1)",
    ),
    _words(
        "a floating pin is high",
        "25.3.5",
        "wires->miso) ? UINT32_MAX >> (32 - wires->count) : 0",
        "wires->miso) ? 0 : UINT32_MAX >> (32 - wires->count)",
    ),
    _words("a level is never forgotten", "25.3.5", ": !wires->known;", ": false;"),
    _words("one wire is read at MISO", "25.3.4", "wires->one_wire ? hil_spi_wants_what_comes_in(spi) : ", ""),
    _words("nobody hears what is sent", "25.3.1", "wires->asks && !promised", "false && !promised"),
    _words("MOSI stays where it was", "25.3.1", "wires->last = wires->bits & 1;", "wires->last = 0;"),
    _words("MOSI changes in the end alone", "25.3.1", "    wires->behind = 1;\n", ""),
    _words("who looks sees nothing", "25.3.1", "here = wires->plain ?", "here = true ?"),
    _words("a wire back brings the same bit", "25.3.1", "- 1 - wires->halves / 2) & 1", "- 1) & 1"),
    _words("who looks at a wire back sees nothing", "25.3.1", "  if (!wires->late)\n    bit", "  if (false)\n    bit"),
    _words("a promise holds in another mode", "25.3.1", " || mode(spi) != spi->promised_mode", ""),
    _words("what was sent meanwhile is forgotten", "25.3.1", "told[wires->heard++]", "told[wires->heard]"),
    _words("promised bytes come again", "25.3.1", "answers[spi->answered++]", "answers[spi->answered]"),
    _words("a promise has no end", "25.3.1", "spi->answered + bytes > spi->answer_count", "false"),
    _port(
        "BSRR: reset wins",
        "9.2.5",
        "(latches & ~(value >> 16)) | (value & LATCHES)",
        "(latches | (value & LATCHES)) & ~(value >> 16)",
    ),
    _port("BRR resets the wrong half", "9.2.6", "latches & ~(value & LATCHES)", "latches & ~(value >> 16)"),
    _port("an output does not show its latch", "9.2.3", "*levels ^= changed & pins->shown", "*levels ^= 0"),
    _port("a pin that is not there shows a latch", "9.2.3", "changed & pins->shown", "changed"),
    _port("edges are not written down", "9.2.4", "(changed & pins->noted && !note(port, latches))", "false"),
    _port(
        "edges come late",
        "9.2.4",
        "{hil_time_of(port->queue)->now, latches}",
        "{hil_time_of(port->queue)->now + 1, latches}",
    ),
    _port("a pin that somebody looks at is left alone", "9.2.4", "changed & ~pins->alone || ", ""),
    _port("levels that change by themselves are not asked for", "9.2.3", "what == IDR && port->pins.asked", "false"),
)


# --- in a process of its own, with the library of a defect


def _checks(peripheral: str) -> Iterator[tuple[str, Callable[[], bool]]]:
    """Return what may find a defect: name, and what says whether it did."""
    if peripheral:
        os.environ["HILBENCH_EXHAUSTIVE"] = "1"  # most self-tests are of that tier
    import pytest

    from tests.targets.mcu.differential import float_oracle, oracle
    from tests.targets.mcu.differential.image import CASES

    def sequences() -> bool:
        every = ((model, image * CASES) for model, images in SEQUENCES for image in range(images))
        return any(oracle.compare(model, 1, first).problems for model, first in every)

    def operands() -> bool:
        return any(
            float_oracle.problems(
                operation,
                [
                    *float_oracle.random_operands(operation, random.Random(operation.name), OPERANDS),
                    *float_oracle.corner_operands(operation),
                ],
                by_definition=True,
                by_unicorn=False,
            )
            for operation in float_oracle.BY_NAME.values()
        )

    def fails(*files: str) -> Callable[[], bool]:
        def run() -> bool:
            code = pytest.main(["-q", "-x", "-n0", "-p", "no:cacheprovider", *files])
            if code not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED):
                raise SystemExit(f"pytest {' '.join(files)}: {code!r}")
            return code == pytest.ExitCode.TESTS_FAILED

        return run

    if peripheral:
        self_tests, files = PERIPHERALS[peripheral]
        yield "self-tests", fails("-k", self_tests, *SELF_TESTS)
        yield "registers and lines", fails(*files)
        return
    yield "sequences", sequences
    yield "floating point", operands
    yield "vectors", fails(*VECTORS)
    yield "exceptions", fails(EXCEPTIONS)
    yield "self-tests", fails(*SELF_TESTS)


def judge(path: Path, digest: str, peripheral: str) -> str:
    """Return the first check that finds the library in that file wrong, or nothing.

    Args:
        path: the library.
        digest: of its sources.
        peripheral: which one has the defect; empty: the core.
    """
    library._found = lambda: (path, digest)  # noqa: SLF001 - what everybody loads in this process
    for name, finds in _checks(peripheral):
        with contextlib.redirect_stdout(io.StringIO()):
            try:
                wrong = finds()
            except Exception:  # noqa: BLE001 - whatever a program does that goes astray
                wrong = True
        if wrong:
            return name
    return ""


# --- the table


def make(defect: Defect, folder: Path) -> tuple[Path, str]:
    """Compile the sources with a defect; return the library and its digest."""
    changed = folder / "src"
    shutil.copytree(sources.SOURCES, changed)
    file = changed / defect.file
    text = file.read_text()
    if text.count(defect.old) != 1:
        raise ValueError(f"{defect.name}: stands {text.count(defect.old)} times in {defect.file}")
    file.write_text(text.replace(defect.old, defect.new))
    made = folder / sources.file_name()
    build.compile_library(made, build.some_compiler(), ["-O1"], changed)
    return made, sources.digest_of(changed)


def found_by(defect: Defect) -> str:
    """Return who finds a defect first, or nothing."""
    with tempfile.TemporaryDirectory() as folder:
        path, digest = make(defect, Path(folder))
        command = [sys.executable, "-m", "measure.core_defects", "--judge", str(path), "--digest", digest]
        command += ["--peripheral", defect.file if defect.file in PERIPHERALS else ""]
        try:
            done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=LONGEST_S, check=False)
        except subprocess.TimeoutExpired:
            return "does not end"
        return done.stdout.strip() if done.returncode == 0 else "crashes"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m measure.core_defects", description="Put defects into the core.")
    parser.add_argument("--only", default="", help="defects whose file or name contains this")
    parser.add_argument("--judge", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--digest", help=argparse.SUPPRESS)
    parser.add_argument("--peripheral", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.judge:
        sys.stdout.write(judge(options.judge, options.digest, options.peripheral) + "\n")
        return 0
    missed = 0
    sys.stdout.write("| Defect | Against | Found first by |\n|---|---|---|\n")
    for defect in DEFECTS:
        if options.only in f"{defect.file} {defect.name}":
            by = found_by(defect)
            missed += not by
            sys.stdout.write(f"| {defect.name} | {defect.section} | {by or '**nobody**'} |\n")
            sys.stdout.flush()
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
