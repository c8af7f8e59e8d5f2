"""A client under test, as the cases of `p2os_client` see it: what it sends, and what it says it understood."""

from __future__ import annotations

from typing import Protocol

from hilbench.bench import Bench
from hilbench.check import Untimely, Violation
from hilbench.clock import NS_PER_S
from hilbench.errors import InternalError, UnavailableError
from hilbench.systems.pioneer.client import P2osClient
from hilbench.systems.pioneer.reporting_client import ReportingClient
from hilbench.systems.pioneer.scripted import Heard, ScriptedServer
from hilbench.systems.pioneer.under_test import ClientUnderTest
from protocols.p2os import ClientState, Identification, Sip, SipReading, SyncEcho, encode_packet

LAST_BYTES_S = 0.3
"""How long the last bytes of a program that has ended may still be on the line."""

START_WITHIN_S = 10.0
"""How long a program may take to its first byte, in seconds. A choice: a busy machine starts an interpreter in two."""

CONNECT_WITHIN_S = 20.0
"""How long a client may take from its first byte to OPEN, whatever it meets, in seconds. A choice: ARIA gives up after
11 unanswered SYNCs, Player after some 14 s."""

WORKING_PERIOD_S = 2.0
"""How long a session is watched for ill effects of what went before."""

CONFIG_WITHIN_S = 5.0
"""How long a client may wait for a CONFIG packet, in seconds. No source gives a limit; ARIA waits 1 s."""

UNDERSTAND_S = 0.4
"""Long enough for the longest SIP, which takes 0.1 s at 9600 baud, to have come twice."""

_NO_SESSION = ("SYNC1", "SYNC2", "OPEN", "CLOSE", "ENABLE", "STOP")
"""What a client may well send that takes its session for lost: it takes leave, or begins anew."""

ECHO0, ECHO1 = (encode_packet(SyncEcho(number=number)) for number in (0, 1))


class ClientBench(Protocol):
    """The part of a case's bench that these cases use."""

    bench: Bench

    @property
    def server(self) -> ScriptedServer:
        """The robot the client talks to."""

    @property
    def client(self) -> ClientUnderTest:
        """The client under test."""


def identification(subclass: str) -> bytes:
    """Return the answer to SYNC2 of another robot."""
    return encode_packet(Identification(name="bench", subclass=subclass))


def damaged(frame: bytes) -> bytes:
    """Return the frame with one bit of its body's second byte flipped, so that its checksum is wrong."""
    return frame[:4] + bytes((frame[4] ^ 0x01,)) + frame[5:]


def begin(bench: ClientBench) -> None:
    """Start the client and wait for its first byte.

    Raises:
        Violation: it says nothing.
        UnavailableError: it is a program that ended before it said anything: there is no client to judge.
    """
    client, server = bench.client, bench.server
    client.start()
    if not server.wait(lambda: server.bytes_received > 0 or bool(client.ended()), START_WITHIN_S):
        raise Untimely(f"the client sent nothing within {START_WITHIN_S:g} s of its start", spare_s=START_WITHIN_S / 2)
    if not server.wait(lambda: server.bytes_received > 0, LAST_BYTES_S):
        raise UnavailableError(f"the client {client.ended()} before it sent anything", hint="run its command by hand")


def connect(bench: ClientBench) -> Heard:
    """Start the client, wait until it is in session, and return its OPEN.

    Raises:
        Violation: it does not come so far.
    """
    begin(bench)
    return expect_session(bench)


def expect_session(bench: ClientBench) -> Heard:
    """Wait until the client, once started, is in session, and return its OPEN.

    Raises:
        Violation: it does not come so far.
    """
    opened = bench.server.expect_session(CONNECT_WITHIN_S)
    own = bench.client.own
    if own is not None and not bench.server.wait(lambda: own.state is ClientState.OPEN, CONFIG_WITHIN_S):
        raise Untimely(f"the client got an answer, but still: {own.state.value}", spare_s=CONFIG_WITHIN_S / 2)
    return opened


def require_session(bench: ClientBench, for_s: float, why: str) -> None:
    """Require that the client stays in its session for some time.

    Raises:
        Violation: it left, or is gone.
    """
    server, own = bench.server, bench.client.own
    server.run(for_s)
    if not server.in_session:
        raise Violation(f"the client closed its session: {why}")
    if not server.port.line_is_up:
        raise Violation(f"the client is gone: {why}")
    if own is not None and own.state is not ClientState.OPEN:
        raise Violation(f"the client says '{own.failure or own.state.value}': {why}")


def require_lost(bench: ClientBench, why: str) -> None:
    """Require that the client takes its session for lost, now that the robot has left it as well.

    It may be silent, hang up, or begin anew. SYNC0 is the same frame as PULSE; but the robot answers it here, and who
    begins anew goes on with SYNC1.

    Raises:
        Violation: it goes on as if nothing had happened.
    """
    server, own = bench.server, bench.client.own
    server.end_session()
    mark, sessions = server.mark(), server.sessions_opened
    server.run(3.0)
    if own is not None and not own.failure:
        raise Violation(f"the client does not report it: {why}")
    if server.sessions_opened > sessions:
        return
    goes_on = [heard.name for heard in server.heard(mark=mark) if heard.name not in _NO_SESSION]
    begins_anew = bool(server.heard("SYNC1", mark=mark))
    if len(goes_on) > 1 and not begins_anew:  # one may have been under way
        raise Violation(f"the client continues with {', '.join(dict.fromkeys(goes_on))}: {why}")


def require_end(bench: ClientBench, within_s: float, why: str) -> None:
    """Require that the client stops talking.

    Raises:
        Violation: it still talks after ``within_s`` seconds.
    """
    if not bench.server.wait_quiet(3.0, within_s):
        raise Untimely(f"the client still talks after {within_s:g} s: {why}", spare_s=within_s / 2)


def own_client(bench: ClientBench) -> P2osClient | ReportingClient:
    """Return the client that can be asked and told; only for cases that need one."""
    own = bench.client.own
    if own is None:
        raise InternalError("a case asks a foreign client what it understood", hint="needs client.report")
    return own


def understood(bench: ClientBench, data: bytes) -> SipReading:
    """Send bytes in each SIP's place and return what the client makes of them.

    Raises:
        Violation: it understands no SIP.
    """
    own = own_client(bench)
    bench.server.stream = lambda _tick: data
    before = len(own.sips)
    bench.server.run(UNDERSTAND_S)
    reading = own.reading
    if reading is None or len(own.sips) == before:
        raise Untimely("the client took none of the SIPs", spare_s=UNDERSTAND_S / 2)
    return reading


def sips_since(bench: ClientBench, mark: int) -> list[Sip]:
    """Return what the client understood, from its ``mark``-th SIP on."""
    return own_client(bench).sips[mark:]


def seconds_between(first: Heard, second: Heard) -> float:
    """Return how long the client was silent between two frames, in seconds."""
    return (second.start_ns - first.at_ns) / NS_PER_S


def byte_pair(argument: int) -> tuple[int, int]:
    """Return the (high, low) signed bytes of an argument: the magnitude with its sign, modulo 65536.

    Written out here, so that the client is not held against its own arithmetic.
    """
    word = argument % 0x10000
    high, low = word // 0x100, word % 0x100
    return high - 0x100 if high > 0x7F else high, low - 0x100 if low > 0x7F else low
