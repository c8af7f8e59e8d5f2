"""Each self-test on the emulated chip: all of its checks, in both timing models, however it is run."""

from __future__ import annotations

import pytest

from targets.firmware import image_names

CHECKS = {
    "adc": 66,
    "cpu": 121,
    "crc": 10,
    "dac": 54,
    "dma": 43,
    "dwt-itm": 14,
    "exti": 31,
    "faults": 36,
    "flash": 50,
    "gpio": 46,
    "high-density": 60,
    "i2c": 27,
    "i2c-slave": 134,
    "iwdg": 23,
    "nvic": 88,
    "pwr-bkp": 22,
    "rcc": 57,
    "rtc": 26,
    "rtc-output": 9,
    "smbus": 32,
    "spi": 48,
    "systick": 21,
    "tim": 66,
    "tim-inputs": 57,
    "tim1": 54,
    "unaligned": 5,
    "usart": 98,
    "usart-clock": 18,
    "wwdg": 18,
}

LIMIT_MS = 1000


def test_all_self_tests_are_run():
    assert [f"selftest-{name}" for name in CHECKS] == [name for name in image_names() if name.startswith("selftest-")]


def with_the_gate_having(*few):
    """Return the names; those that are not among the few are left to the exhaustive tests."""
    rest = pytest.mark.exhaustive(f"the other self-tests; the gate has {', '.join(few)}")
    return [pytest.param(name, marks=() if name in few else rest) for name in CHECKS]


def check_all(start, name, timing):
    run = start(f"selftest-{name}", timing=timing).to(LIMIT_MS)
    passed, failed = run.checks
    assert failed == []
    assert len(passed) == CHECKS[name]
    ended = run.machine.ended
    assert (ended.kind, ended.status) == ("exit", 0)
    assert run.console.endswith(b"done %d ok 0 failed\n" % CHECKS[name])


@pytest.mark.exhaustive("golden traces of the same images hold every line that they say")
@pytest.mark.parametrize("name", CHECKS)
def test_every_check_holds(start, name):
    check_all(start, name, "flat")


@pytest.mark.parametrize("name", with_the_gate_having("cpu", "faults", "systick"))
def test_every_check_holds_with_other_timing(start, name):
    check_all(start, name, "table")


def end(start, name, step_ns=None, **options):
    run = start(f"selftest-{name}", **options).to(LIMIT_MS, step_ns=step_ns)
    return run.machine.ended, run.console, run.sent, run.resets


@pytest.mark.parametrize("name", with_the_gate_having("crc", "nvic", "tim"))
def test_it_ends_at_the_same_cycle_however_it_is_run(start, name):
    assert end(start, name) == end(start, name, step_ns=77_777, skip_idle=False)


@pytest.mark.exhaustive("each self-test in four ways; the gate has three of them in one")
@pytest.mark.parametrize("name", CHECKS)
@pytest.mark.parametrize(("step_ns", "skip_idle"), [(1009, True), (77_777, False)])
@pytest.mark.parametrize("timing", ["flat", "table"])
def test_steps_and_skipping_change_nothing(start, name, skip_idle, step_ns, timing):
    plain = end(start, name, timing=timing)
    assert plain == end(start, name, timing=timing, step_ns=step_ns, skip_idle=skip_idle)
