"""Both ends over a line with a latency and faults."""

from __future__ import annotations

import pytest

from protocols.carla import (
    PROFILES,
    Commanded,
    Connection,
    ControlCommand,
    Mode,
    ModeChanged,
    Role,
    StatusReceived,
    Transmit,
    encode_command,
    encode_status,
)
from protocols.testing import LATENCY_NS, Pair, lossy
from tests.each import each
from tests.share import seeds

MS = 1_000_000
SECOND = 1_000_000_000
REPORTS_NS, COMMANDS_NS = 50 * MS, 33 * MS


class Rig(Pair):
    """A car that reports at 20 Hz behind the client, a driving stack that commands at 30 Hz behind the server."""

    def __init__(self, profile="hardened", **more):
        ends = PROFILES[profile]
        board = Connection(Role.BOARD, ends.board)
        super().__init__(Connection(Role.SIMULATOR, ends.simulator), board, transmit=Transmit, **more)
        self.reporting = self.commanding = True
        self._reports_ns = self._commands_ns = 0
        self.speed = 0.0
        self.said = {"client": [], "server": []}

    def next_moment_ns(self):
        return min(self._reports_ns, self._commands_ns)

    def moment(self):
        if self._reports_ns <= self.now_ns:
            self._reports_ns += REPORTS_NS
            if self.reporting:
                self.speed += 0.125
                self._take("client", self.client.velocity(self.speed, 0.25, -0.5, self.now_ns))
                self._take("client", self.client.steering(0.125, self.now_ns))
        if self._commands_ns <= self.now_ns:
            self._commands_ns += COMMANDS_NS
            if self.commanding:
                self._take("server", self.server.command(ControlCommand(speed_m_s=self.speed), self.now_ns))
            else:
                self._take("server", self.server.agent(self.now_ns))

    def write(self, end, data):
        self.said[end].append(data)
        super().write(end, data)

    def press(self):
        self._take("server", self.server.press(self.now_ns))

    def request(self, mode):
        self._take("server", self.server.request(mode, self.now_ns))


@each("profile", PROFILES)
def test_a_sound_line_keeps_autoware(profile):
    rig = Rig(profile)
    rig.run(10 * SECOND)
    assert rig.server.mode is Mode.AUTOWARE
    assert rig.of(ModeChanged) == []
    believed = [event.status.lon_speed_m_s for event in rig.of(StatusReceived)]
    assert believed == sorted(set(believed))
    handed_on = [event.command.speed_m_s for event in rig.of(Commanded)]
    assert handed_on == sorted(handed_on)
    if profile == "hardened":
        assert len(believed) == pytest.approx(200, abs=2)
        assert len(handed_on) == pytest.approx(200, abs=2)
        assert rig.server.counters.status_misses == 0


@each("profile", PROFILES)
def test_the_joystick_takes_over_and_gives_back(profile):
    rig = Rig(profile)
    rig.run(2 * SECOND)
    rig.press()
    rig.run(2 * SECOND)
    assert rig.server.mode is Mode.MANUAL
    assert rig.of(Commanded)[-1].mode in (4, 0)
    rig.press()
    rig.run(2 * SECOND)
    assert rig.server.mode is Mode.AUTOWARE
    assert rig.of(Commanded)[-1].mode == 1


@each(("pause_ms", "mode"), [(900, Mode.AUTOWARE), (1100, Mode.EMERGENCY)])
def test_how_long_the_simulator_may_pause(pause_ms, mode):
    rig = Rig()
    rig.run(2 * SECOND + 20 * MS)
    rig.reporting = False
    rig.run((pause_ms - 40) * MS)  # 20 ms are over since the last report, 20 ms later comes the next
    assert rig.server.mode is mode
    rig.reporting = True
    rig.run(100 * MS)
    assert rig.server.mode is (Mode.MANUAL if mode is Mode.EMERGENCY else mode)


def test_a_silent_driving_stack_stops_the_car_and_hands_it_to_the_joystick():
    rig = Rig()
    rig.run(2 * SECOND + 20 * MS)
    rig.commanding = False
    start = rig.now_ns
    rig.run(2 * SECOND)
    late = [(t, e) for t, who, e in rig.seen if who == "client" and isinstance(e, Commanded) and t > start + 120 * MS]
    assert all(event.command.speed_m_s == 0 for _, event in late if event.mode == 1)
    assert late[-1][1].mode == 4
    assert rig.server.mode is Mode.MANUAL


def test_a_dead_line_stops_the_car_at_both_ends():
    rig = Rig()
    rig.run(2 * SECOND)
    rig.damage = lambda data: b""
    rig.run(2 * SECOND)
    assert rig.server.mode is Mode.EMERGENCY
    last = rig.of(Commanded)[-1]
    assert (last.frame, last.command.speed_m_s) == (None, 0.0)
    assert rig.client.counters.silences == 1
    rig.damage = lambda data: data
    rig.run(100 * MS)
    assert rig.server.mode is Mode.MANUAL


@pytest.mark.parametrize("seed", seeds(20, 2))
def test_lost_doubled_and_added_bytes_are_hardly_ever_believed(seed):
    """Never is out of reach without a checksum: a frame cut before a float may go on with the next one's bytes."""
    rig = Rig(damage=lossy(seed, drop=0.2, repeat=0.1, noise=0.2))
    rig.run(30 * SECOND)
    assert len(set(rig.said["client"])) >= 590
    false = [event for event in rig.of(StatusReceived) if encode_status(event.status) not in rig.said["client"]]
    assert len(false) <= 2
    sent = {data[:29] for data in rig.said["server"]}
    handed_on = [event.frame for event in rig.of(Commanded) if event.frame is not None]
    assert len([frame for frame in handed_on if encode_command(frame)[:29] not in sent]) <= 2
    assert len(handed_on) > 100
    counters = rig.server.counters
    assert counters.noise + counters.bad_letters + counters.missing_fields > 20


@pytest.mark.parametrize("seed", seeds(10, 3))
def test_when_the_faults_end_everything_works_again(seed):
    rig = Rig(damage=lossy(seed, drop=0.6, flip=0.3, repeat=0.2, noise=0.4))
    rig.run(20 * SECOND)
    rig.damage = lambda data: data
    rig.run(2 * SECOND)
    assert rig.server.mode is not Mode.EMERGENCY
    if rig.server.mode is Mode.MANUAL:
        rig.request(1)
        rig.run(SECOND)
    before = len(rig.of(Commanded))
    rig.run(SECOND)
    assert rig.server.mode is Mode.AUTOWARE
    assert len(rig.of(Commanded)) - before == pytest.approx(20, abs=2)


def test_the_shipped_board_does_not_get_over_one_fault():
    rig = Rig("v0")
    rig.run(2 * SECOND)
    damaged = iter([b"\0"])
    rig.damage = lambda data: next(damaged, b"") + data if len(data) == 22 else data
    rig.run(60 * SECOND)
    assert rig.server.mode is Mode.EMERGENCY


def test_the_latency_is_what_a_reader_sees():
    rig = Rig()
    rig.run(50 * MS)
    first = next(t for t, who, event in rig.seen if isinstance(event, StatusReceived))
    assert first == LATENCY_NS
