"""The check's end of the simulator's line: what it takes for a frame, and what it says by itself."""

from __future__ import annotations

import pytest

from hilbench.bench import Bench
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.systems.vehicle.simulator_peer import BoardPeer, SimulatorPeer
from protocols.carla import BAUD, VECTORS, CommandFrame, Mode, StatusFrame

F1, F2, F3 = (VECTORS[name].data for name in ("F1", "F2", "F3"))


@pytest.fixture
def there():
    bench = Bench(Scheduler(), Journal())
    link = MemoryLink(bench.scheduler, Line(baud=BAUD), name="simulator")
    return bench, SimulatorPeer(bench, link.a), link.b


def test_frames_and_what_is_between_them(there):
    bench, peer, board = there
    board.write(F1 + b"xy" + F2[:-1] + F3)
    bench.run_for(0.01)
    assert peer.modes() == [1, 4, 0]
    assert [got.raw for got in peer.frames()] == [frame[:-1] for frame in (F1, F2, F3)]
    assert peer.paddings == 2
    assert [(drop.reason, drop.data) for drop in peer.dropped] == [("NOISE", b"xy")]
    first = peer.frames()[0]
    assert (first.start_ns, first.at_ns) == (10_850, 314_670)


def test_a_frame_with_a_nan_is_a_frame(there):
    bench, peer, board = there
    board.write(F1.replace(bytes.fromhex("9A99193F"), bytes.fromhex("0000C07F")))
    bench.run_for(0.01)
    assert len(peer.frames()) == 1


def test_statuses_come_at_their_rate(there):
    bench, peer, board = there
    heard = []
    board.on_receive = lambda data, _at_ns: heard.append(data)
    peer.status = StatusFrame(lon_speed_m_s=8.3333, lat_speed_m_s=-0.05, heading_rate_rad_s=0.1, steering_rad=-0.2)
    peer.statuses.start(20.0, first_after_s=0.01)
    bench.run_for(0.2)
    assert b"".join(heard) == VECTORS["F5"].data * 4
    peer.statuses.stop()
    bench.run_for(0.2)
    assert peer.statuses.said == 4


def test_what_is_forgotten_is_gone(there):
    bench, peer, board = there
    board.write(F1)
    bench.run_for(0.01)
    peer.forget()
    assert (peer.frames(), peer.paddings, peer.bytes_received) == ([], 0, 0)


def test_the_board_s_end_is_the_reverse(there):
    bench, simulator, port = there
    board = BoardPeer(bench, port)
    board.command = CommandFrame(steering=-0.5, speed=0.75, mode=Mode.MANUAL)
    board.commands.start(100.0)
    simulator.statuses.start(20.0)
    bench.run_for(0.0999)
    assert simulator.modes() == [4] * 10
    assert simulator.paddings == 10
    assert [got.raw for got in board.frames()] == [VECTORS["F4"].data] * 2
    board.close()
    bench.run_for(0.1)
    assert len(simulator.frames()) == 10
    assert len(board.frames()) == 2
