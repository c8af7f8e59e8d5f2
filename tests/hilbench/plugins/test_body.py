"""A device of a plug-in with a body: it lives in the world of its bench, and is several state machines if it likes."""

from __future__ import annotations

import pytest

from hilbench.bench import Bench
from hilbench.clock import Scheduler
from hilbench.config import open_bench
from hilbench.errors import PluginError, UnavailableError
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.plugins.protocol import Device
from hilbench.protocol_bench.cases import machines_of
from hilbench.protocol_bench.placed import PlacedDevice

SYSTEM = """
from pathlib import Path

import tiny
from dataclasses import replace
from hilbench.plugins.protocol import Device
from hilbench.protocol_bench.system import ProtocolSystem

class Silent:
    receive = lambda self, data, now_ns: b""
    advance = lambda self, now_ns: b""
    next_deadline_ns = lambda self: None
    line_down = lambda self, now_ns: b""
    take_events = lambda self: []

class Wheels(Silent):
    def __init__(self, settings):
        self.steps = []

    def enter(self, body):
        self.body = body

    def step(self, now_ns):
        self.steps.append(now_ns)

CART = ProtocolSystem(replace(tiny.TINY, name="cart", title="Cart", device=Device(make=Wheels)), has_body=True)
"""
BENCH = """
version = 1
plugins = ["cart.py"]
[targets.cart]
model = "cart"
[world]
physics = "plane"
"""


@pytest.fixture
def bench_file(tmp_path, tiny, plugins):
    """Return a bench with a device in a world, on the plane."""
    tmp_path.joinpath("cart.py").write_text(SYSTEM)
    file = tmp_path / "cart.toml"
    file.write_text(BENCH)
    return file


def place(bench_file, made=None, **more):
    import cart

    bench = Bench(Scheduler(), Journal())
    link = MemoryLink(bench.scheduler, Line(baud=9600), name="host")
    made = Device(make=made or cart.Wheels)
    return bench, PlacedDevice(bench, open_bench(str(bench_file)), made, link.b, seed=0, **more)


def test_it_has_its_body_and_acts_after_each_step(bench_file):
    open_bench(str(bench_file))
    bench, placed = place(bench_file)
    bench.run_for(0.1)
    assert placed.device.body.world is placed.world
    assert placed.world.step_index == len(placed.device.steps) == 24
    assert placed.device.steps[0] == pytest.approx(1e9 / 240, abs=1)
    placed.close()


def test_a_device_that_takes_no_body_is_refused(bench_file):
    open_bench(str(bench_file))
    import cart

    with pytest.raises(PluginError, match="stands in a world, and has no 'enter' and 'step'"):
        place(bench_file, made=lambda settings: cart.Silent())


def test_a_world_that_cannot_be_opened_is_named(bench_file):
    open_bench(str(bench_file))
    with pytest.raises(UnavailableError, match='scene wall: physics "plane" has no obstacles'):
        place(bench_file, scene="wall")


def test_a_device_may_be_several_machines():
    class Bus:
        observed = {"left": 1, "right": 2}  # noqa: RUF012

    class Node:
        observed = 3

    assert machines_of({"device": Bus(), "client": Node(), "other": object()}) == {"left": 1, "right": 2, "client": 3}
