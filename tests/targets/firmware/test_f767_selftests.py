"""The self-tests of the blocks of the STM32F767: each of their checks holds, however they are run."""

from __future__ import annotations

import pytest

CHECKS = {"adc": 28, "dma": 37, "i2c": 23, "lptim": 65, "pins": 37, "serial": 55, "spi": 55, "timers": 31}
NOTES = {
    "dma": ["DMA1_S1NDTR", "DMA1_S1PAR"],
    "lptim": ["LPTIM1_CR", "LPTIM1_IER"],
    "serial": ["USART2_BRR", "USART2_CR2.TXINV", "USART2_CR2.RXINV"],
    "timers": ["TIM6_0x34"],
}
LIMIT_MS = 50
OTHER_TIMING = pytest.mark.exhaustive("the other timing model; the gate has golden traces with it")


@pytest.mark.exhaustive("golden traces of the same images hold every line that they say")
@pytest.mark.parametrize("name", CHECKS)
@pytest.mark.parametrize("timing", ["flat", pytest.param("table", marks=OTHER_TIMING)])
def test_every_check_holds(start, name, timing):
    run = start(f"f767-{name}", timing=timing).to(LIMIT_MS)
    passed, failed = run.checks
    assert (len(passed), failed) == (CHECKS[name], [])
    assert (run.machine.ended.kind, run.machine.ended.status) == ("exit", 0)
    assert [note.where for note in run.machine.notes.all] == NOTES.get(name, [])


@pytest.mark.exhaustive("each self-test in other ways; the gate has fifteen images so in traces/test_goldens.py")
@pytest.mark.parametrize("name", CHECKS)
def test_it_ends_at_the_same_cycle_however_it_is_run(start, name):
    def end(step_ns=None, **options):
        run = start(f"f767-{name}", **options).to(LIMIT_MS, step_ns=step_ns)
        return run.machine.ended, run.console

    assert end() == end(step_ns=77_777, skip_idle=False)
