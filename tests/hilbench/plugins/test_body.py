"""A device of a plug-in with a body: it lives in the world of its bench, and is several state machines if it likes."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest

from hilbench.bench import Bench
from hilbench.bench.placed_device import PlacedDevice
from hilbench.bench.protocol_cases import machines_of
from hilbench.benchfile.reader import open_bench
from hilbench.check.bench_provider import make_provider
from hilbench.clock import Scheduler
from hilbench.errors import PluginError, UnavailableError
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.mcu.attached_board import AttachedBoardProvider
from hilbench.plugins.protocol import Device
from hilbench.terminal.options import CheckOptions, TargetChoice

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


def test_a_joint_that_its_body_does_not_have_is_the_device_s_error(bench_file, hilbench, tmp_path):
    cart = tmp_path / "cart.py"
    cart.write_text(cart.read_text().replace("self.steps.append(now_ns)", "self.body.world.command('mast', 1.0, 1.0)"))
    suite = tmp_path / "test_cart.py"
    suite.write_text(
        'from hilbench.check import case\n@case("C1", text="a", level="must", source="a")\n'
        "def test_it(peer): peer.run(0.1)\n"
    )
    line = 1 + cart.read_text().splitlines().index("        self.body.world.command('mast', 1.0, 1.0)")
    code, out, _ = hilbench("check", bench_file, "--suite", suite)
    assert code == 2
    assert f"cart.py:{line}: UnknownNameError: unknown joint 'mast'" in out


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


def test_it_does_not_speak_to_boards_that_speak_something_else(bench_file):
    open_bench(str(bench_file))
    import cart

    for protocols in ({}, {"brain.usart1": object()}):
        about = SimpleNamespace(checker_lines={"": "brain.usart1"}, protocols=protocols)
        assert cart.CART.board_rig(SimpleNamespace(bench_file=about, ports={}), seed=0) is None


def test_a_board_at_a_port_that_runs_its_suite_is_spoken_to_by_the_suite(bench_file, tmp_path):
    image = Path(__file__).parents[3] / "targets/firmware/images/echo-irq.elf"
    suite = tmp_path / "suite.py"
    suite.write_text("")
    cart = tmp_path / "cart.py"
    cart.write_text(cart.read_text().replace("device=", f"suites=(Path({str(suite)!r}),), device="))
    bench_file.write_text(
        f'version = 1\nplugins = ["cart.py", "tiny.py"]\nsuites = ["suite.py"]\n'
        f'[targets.brain]\nboard = "bluepill"\nfirmware = "{image}"\n'
        '[[links]]\nends = ["peer", "brain.usart1"]\nprotocol = "tiny"\n'
    )
    choice = TargetChoice(spec="serial:/dev/nothing", name="brain.usart1")
    provider = make_provider(CheckOptions(bench=str(bench_file), targets=(choice,)))
    assert isinstance(provider, AttachedBoardProvider)
    provider.close()
