"""Parts at the pins of a chip that runs: exact times both ways, and cases with a second bench."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hilbench.bench.shared import Shared
from hilbench.benchfile.reader import open_bench
from hilbench.journal import Journal
from hilbench.judging.provider import CaseInfo, CaseSetup
from hilbench.mcu.board_provider import BoardProvider
from targets.parts.encoder_3bit import SECTOR_RAD
from targets.parts.motor_code import MotorWord
from worlds.errors import WorldError

CYCLE_NS = 125
"""Of the clock of 8 MHz with which a program begins that sets none."""


@pytest.fixture
def open_case():
    shared = Shared(bench_file=open_bench("bluepill"), timeout_scale=1.0, journal=Journal())
    provider = BoardProvider(shared)

    def make(**setup):
        scene = setup.pop("scene", "empty")
        info = CaseInfo(id="a/case", clause_ids=("G01",), seed=1, scene=scene, setup=CaseSetup(**setup))
        return provider.open_case(info)

    return make


@pytest.mark.needs_physics
def test_an_edge_of_a_part_is_at_the_pin_at_its_time(open_case):
    with open_case(program="quiet") as bench:
        bench.emulated.surroundings.parts.senses = False
        bench.board.run(0.0501)
        edges = []
        for name in ("PB4", "PB3", "PA15"):
            pin = bench.board.pin(name)
            pin.on_edge(lambda _cycle, ns, level, name=name: edges.append((name, level, ns)))
        now_ns = bench.now_ns
        angles = ({"angle": 0.5 * SECTOR_RAD}, {"angle": 3.5 * SECTOR_RAD})
        bench.parts["encoder_left"].after_step(now_ns, now_ns + 3_000_000, *angles)
        bench.board.run(0.005)
        assert [edge[:2] for edge in edges] == [
            ("PB4", True),
            ("PB4", False),
            ("PB3", True),
            ("PB4", True),
        ]
        for (_, _, ns), expected_ms in zip(edges, (0.5, 1.5, 1.5, 2.5), strict=True):
            assert 0 <= ns - now_ns - expected_ms * 1e6 <= CYCLE_NS


@pytest.mark.needs_physics
def test_a_part_reads_a_pin_as_it_is_at_its_time(open_case):
    """A pulse of 2 us in which a word is published, and one that misses it."""
    with open_case(program="quiet") as bench:
        words = []
        bench.emulated.surroundings.parts.taps.append(
            lambda name, event: (
                words.append(event.raw) if name == "motor_left" and isinstance(event, MotorWord) else None
            )
        )
        machine, pin = bench.emulated.machines["brain"], bench.board.pin("PB6")
        for begin_ns in (99_999_000, 200_001_000):
            machine.at_ns(begin_ns, lambda: pin.drive(True))
            machine.at_ns(begin_ns + 2000, lambda: pin.drive(False))
        bench.board.run(0.31)
        assert words == [2, 0, 0]


@pytest.mark.needs_physics
def test_a_second_bench_has_a_time_and_a_journal_of_its_own(open_case):
    with open_case(program="quiet") as bench:
        other = bench.open_other(
            CaseSetup(variant="robot", program="words", settings={"adapter": {"dead_time_s": 0.0}}), "post"
        )
        other.board.run(0.2)
        assert bench.now_ns == 0
        assert other.bench.now_s == pytest.approx(0.2)
        assert other.world.scene.name == "post"
        assert other.bench.journal is not bench.journal
        assert "adapter" in other.parts
        assert "adapter" not in bench.parts
        world = other.world
    with pytest.raises(WorldError, match="closed"):
        world.step()


@pytest.mark.needs_physics
def test_an_alteration_is_the_last_word_on_every_bench_of_a_case():
    shared = Shared(bench_file=open_bench("bluepill"), timeout_scale=1.0, journal=Journal())
    provider = BoardProvider(shared, alter=lambda bench_file: replace(bench_file, parts={}, nets=()))
    info = CaseInfo(id="a/case", clause_ids=("G01",), seed=1, scene="empty", setup=CaseSetup(program="quiet"))
    with provider.open_case(info) as bench:
        assert bench.parts == {}
        assert bench.open_other(CaseSetup(program="quiet")).parts == {}
