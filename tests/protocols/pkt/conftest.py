"""What several tests of PKT! need."""

from __future__ import annotations

import pytest

from protocols.pkt import Connection, Role, Transmit, decode_report, encode_frame
from protocols.pkt.framing import Frame, FrameReader

SECOND = 1_000_000_000


class Rover:
    """A rover on a line without delay, spoken to in bytes; it answers in bytes."""

    def __init__(self, options):
        self.options = options
        self.connection = Connection(Role.SERVER, options)
        self.now_ns = 0
        self.events = []

    def hear(self, data):
        """Bytes come now, and whoever polls has polled 10 ms later; returns the frames that the rover sends."""
        events = self.connection.receive(data, self.now_ns)
        self.events += events
        return [event.data for event in (*events, *self.wait(0.01)) if isinstance(event, Transmit)]

    def wait(self, seconds):
        """Time passes; returns what happens meanwhile."""
        self.now_ns += round(seconds * SECOND)
        events = self.connection.advance(self.now_ns)
        self.events += events
        return events

    def of(self, kind):
        return [event for event in self.events if isinstance(event, kind)]

    @property
    def counts(self):
        """ACC/REJ/OP/ERR, as the cases are written."""
        report = self.connection.telemetry
        return (report.accepted, report.rejected, report.last_opcode, report.last_error)

    def frame(self, payload):
        return encode_frame(payload, self.options.frames)

    def report_in(self, frame):
        (found,) = FrameReader(self.options.frames).receive(frame, 0)
        assert isinstance(found, Frame)
        return decode_report(found.payload, self.options.schema)


@pytest.fixture
def make_rover():
    return Rover
