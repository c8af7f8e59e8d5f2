"""What benchmarks of several benches measure with."""

from __future__ import annotations

import time

import pytest


class Shares:
    """Adds up what calls take, less the calls in them that are watched as well."""

    def __init__(self):
        self.spent_s = {}
        self._nested_s = 0.0

    def timed(self, call, label):
        def run(*args, **named):
            outer_s, self._nested_s = self._nested_s, 0.0
            began = time.process_time()
            try:
                return call(*args, **named)
            finally:
                took_s = time.process_time() - began
                self.spent_s[label] = self.spent_s.get(label, 0.0) + took_s - self._nested_s
                self._nested_s = outer_s + took_s

        return run

    def watch(self, owner, name, label):
        setattr(owner, name, self.timed(getattr(owner, name), label))

    def watch_bench(self, emulated):
        """Watch the chips and the world of a bench of emulated boards."""
        around = emulated.surroundings
        if around.world is not None:
            self.watch(around.world, "step", "physics")
            around.runner.before[:] = [self.timed(call, "wiring") for call in around.runner.before]
            around.runner.after[:] = [self.timed(call, "wiring") for call in around.runner.after]
        for machine in emulated.machines.values():
            self.watch(machine, "run_to", "chip")
            self.watch(machine.engine, "_call", "instructions, exceptions, registers and events")
        group = emulated._group
        group.after_round[:] = [self.timed(call, "pins into the journal") for call in group.after_round]

    def of(self, total_s):
        """Return the share of each in a time, and of what is left, largest first."""
        self.spent_s["the bench around"] = total_s - sum(self.spent_s.values())
        shares = sorted(self.spent_s.items(), key=lambda share: -share[1])
        return {label: spent_s / total_s for label, spent_s in shares}


@pytest.fixture
def shares():
    """Where the time goes."""
    return Shares()


@pytest.fixture
def show(capsys):
    """Print a speed and where the time went."""

    def show(what, factor, parts):
        shown = ", ".join(f"{label} {100 * share:.0f} %" for label, share in parts.items() if share >= 0.005)
        with capsys.disabled():
            print(f"\n{what}: {factor:.2f} x real time\n  {shown}")  # noqa: T201 - what one runs it for

    return show
