"""What several tests of the simulator's line need."""

from __future__ import annotations

import pytest

from protocols.carla import (
    PROFILES,
    Commanded,
    Connection,
    ControlCommand,
    Mode,
    ModeReported,
    Role,
    StatusFrame,
    StatusReported,
    Transmit,
    encode_status,
    with_quirks,
)

MS = 1_000_000
SECOND = 1_000_000_000
DRIVE = ControlCommand(steering_rad=0.5, steering_rate_rad_s=0.1, speed_m_s=5.0, acceleration_m_s2=1.0, jerk_m_s3=0.2)


class Board:
    """A board on a line without delay, with a simulator and a driving stack that do what they are told.

    Attributes:
        status_every_ns: how often the simulator sends a status; None: not at all.
        command_every_ns: how often the driving stack commands; None: not at all.
        agent_every_ns: how often the driving stack's agent gives a sign of life.
    """

    def __init__(self, profile="hardened", quirks=(), options=None, **tables):
        self.options = with_quirks(PROFILES[profile], quirks).board if options is None else options
        self.connection = Connection(Role.BOARD, self.options, **tables)
        self.now_ns = 0
        self.seen = []
        self._every = {}
        self._next = {}
        self.speed = 1.0

    def every(self, what, seconds, *, phase=0.0):
        """Has status, command or agent come so often from now on; None: no more."""
        self._every[what] = None if seconds is None else round(seconds * SECOND)
        self._next[what] = None if seconds is None else self.now_ns + round(phase * SECOND)

    def run(self, seconds):
        end_ns = self.now_ns + round(seconds * SECOND)
        while (at_ns := self._soonest()) <= end_ns:
            self.now_ns = at_ns
            self._take(self.connection.advance(at_ns))
            for what, due_ns in list(self._next.items()):
                if due_ns is not None and due_ns <= at_ns:
                    self._next[what] = due_ns + self._every[what]
                    getattr(self, what)()
        self.now_ns = end_ns
        return self

    def status(self):
        self.speed += 0.25
        self.hear(encode_status(StatusFrame(lon_speed_m_s=self.speed)))

    def command(self, command=DRIVE):
        self._take(self.connection.command(command, self.now_ns))

    def agent(self, online=True):
        self._take(self.connection.agent(self.now_ns, online=online))

    def hear(self, data):
        self._take(self.connection.receive(data, self.now_ns))

    def request(self, mode):
        self._take(self.connection.request(mode, self.now_ns))

    def press(self):
        self._take(self.connection.press(self.now_ns))

    def joystick(self, x, y):
        self._take(self.connection.joystick(x, y, self.now_ns))

    def line_error(self):
        self._take(self.connection.line_error(self.now_ns))

    def since(self, at_ns, kind):
        return [event for time_ns, event in self.seen if time_ns >= at_ns and isinstance(event, kind)]

    def times(self, kind, since_ns=0, where=lambda event: True):
        """When events of a kind came, in ms since then."""
        found = [t for t, event in self.seen if t >= since_ns and isinstance(event, kind) and where(event)]
        return [round((t - since_ns) / MS) for t in found]

    def frames(self, since_ns=0):
        """(ms since then, mode byte) of each frame that was sent; mode None for one that nobody filled."""
        return [
            (round((t - since_ns) / MS), None if event.frame is None else int(event.frame.mode))
            for t, event in self.seen
            if t >= since_ns and isinstance(event, Transmit)
        ]

    @property
    def last(self):
        return next(event for _, event in reversed(self.seen) if isinstance(event, Transmit))

    @property
    def mode(self):
        return self.connection.mode

    @property
    def counters(self):
        return self.connection.counters

    def statuses(self, since_ns=0):
        return self.since(since_ns, StatusReported)

    def modes_reported(self, since_ns=0):
        told = [event.mode for event in self.since(since_ns, ModeReported)]
        return [mode for at, mode in enumerate(told) if at == 0 or told[at - 1] != mode]

    def _soonest(self):
        times = [self.connection.next_deadline_ns(), *self._next.values()]
        return min((time for time in times if time is not None), default=1 << 62)

    def _take(self, events):
        self.seen += [(self.now_ns, event) for event in events]


class Simulator:
    """The simulator's side of a line without delay."""

    def __init__(self, profile="hardened", quirks=(), options=None):
        self.options = with_quirks(PROFILES[profile], quirks).simulator if options is None else options
        self.connection = Connection(Role.SIMULATOR, self.options)
        self.now_ns = 0
        self.seen = []

    def hear(self, data):
        self._take(self.connection.receive(data, self.now_ns))

    def run(self, seconds):
        end_ns = self.now_ns + round(seconds * SECOND)
        while (at_ns := self.connection.next_deadline_ns()) is not None and at_ns <= end_ns:
            self.now_ns = max(at_ns, self.now_ns)
            self._take(self.connection.advance(self.now_ns))
        self.now_ns = end_ns
        return self

    def velocity(self, lon=0.0, lat=0.0, rate=0.0):
        self._take(self.connection.velocity(lon, lat, rate, self.now_ns))

    def steering(self, angle=0.0):
        self._take(self.connection.steering(angle, self.now_ns))

    def read_error(self, failing=True):
        self._take(self.connection.read_error(self.now_ns, failing=failing))

    def of(self, kind, since_ns=0):
        return [event for t, event in self.seen if t >= since_ns and isinstance(event, kind)]

    @property
    def commands(self):
        return [event.command for event in self.of(Commanded)]

    @property
    def sent(self):
        return [(t, event.data) for t, event in self.seen if isinstance(event, Transmit)]

    @property
    def counters(self):
        return self.connection.counters

    def _take(self, events):
        self.seen += [(self.now_ns, event) for event in events]


@pytest.fixture
def make_board():
    return Board


@pytest.fixture
def make_simulator():
    return Simulator


@pytest.fixture
def driving(make_board):
    """Makes a board that drives in AUTOWARE: agent, commands at 30 Hz, statuses at 20 Hz."""

    def make(profile="hardened", quirks=(), seconds=2.01, **more):
        board = make_board(profile, quirks, **more)
        board.every("agent", 1.0)
        board.every("command", 1 / 30)
        board.every("status", 0.05)
        board.run(seconds)
        assert board.mode is Mode.AUTOWARE
        return board

    return make


@pytest.fixture
def by_hand(driving):
    """Makes a board that was switched to MANUAL by its joystick."""

    def make(profile="hardened", quirks=(), **more):
        board = driving(profile, quirks, **more)
        board.press()
        board.run(1.5)
        assert board.mode is Mode.MANUAL
        return board

    return make
