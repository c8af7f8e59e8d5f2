"""Faulty servers, made by hand: what a firmware engineer gets wrong, and what a careless copy of ours would do."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from measure.mutants.mutant import Edge, Family, Mutant, server_edge
from measure.mutants.wire import (
    SIP,
    Become,
    Before,
    Bits,
    Checksum,
    Count,
    Cut,
    Drop,
    Late,
    Lose,
    Match,
    Mend,
    MendIn,
    Noise,
    OnceMoreEachSession,
    Operation,
    Pad,
    Put,
    Rule,
    Sonars,
    Stick,
    Swallow,
    Swap,
    Then,
    Twice,
    Way,
    Word,
)
from protocols.p2os import CommandNumber as C
from protocols.p2os import DropReason

NEGATIVE, POSITIVE = 0x1B, 0x3B
ON, OFF, TWO = (MappingProxyType({4: POSITIVE, 5: value}) for value in (1, 0, 2))


def hears(number: int, do: Operation, *, at: Mapping[int, int] = MappingProxyType({}), **match: object) -> Rule:
    """Do something to a command before the server hears it."""
    return Rule(Way.IN, Match(numbers=frozenset({number}), at=at, **match), do)  # type: ignore[arg-type]


def loses(reason: DropReason, do: Operation, **match: object) -> Rule:
    """Do something where bytes come that are no frame."""
    return Rule(Way.IN, Match(dropped=reason, **match), do)  # type: ignore[arg-type]


def says(number: int, do: Operation, **match: object) -> Rule:
    """Do something to a packet that the server sends."""
    return Rule(Way.OUT, Match(numbers=frozenset({number}), **match), do)  # type: ignore[arg-type]


def in_sips(do: Operation, **match: object) -> Rule:
    """Do something to the server's SIPs."""
    return Rule(Way.OUT, Match(numbers=SIP, **match), do)  # type: ignore[arg-type]


def on_wire(id: str, what: str, *rules: Rule, longest_in: int = 200) -> Mutant:  # noqa: A002 - the name of the field
    return Mutant(id=id, family=Family.SERVER_HAND, what=what, wire=rules, longest_in=longest_in)


def in_table(id: str, what: str, *edges: Edge) -> Mutant:  # noqa: A002
    return Mutant(id=id, family=Family.SERVER_HAND, what=what, edges=edges)


def in_flash(id: str, what: str, **settings: object) -> Mutant:  # noqa: A002
    return Mutant(id=id, family=Family.SERVER_HAND, what=what, settings=settings)


def in_options(id: str, what: str, **options: object) -> Mutant:  # noqa: A002
    return Mutant(id=id, family=Family.SERVER_HAND, what=what, server_options=options)


def deaf_to(*events: str, id: str, what: str) -> Mutant:  # noqa: A002
    return Mutant(id=id, family=Family.SERVER_HAND, what=what, mute=frozenset(events))


STOP, ENABLE_0 = bytes((C.STOP,)), bytes((C.ENABLE, POSITIVE, 0, 0))
ENABLE_1, VEL_0, RVEL_0 = (
    bytes((C.ENABLE, POSITIVE, 1, 0)),
    bytes((C.VEL, POSITIVE, 0, 0)),
    bytes((C.RVEL, POSITIVE, 0, 0)),
)

HANDSHAKE = (
    on_wire("echo0-wrong", "SYNC0 is answered with an echo of SYNC1", says(0, Become(b"\1"))),
    on_wire("echo1-wrong", "SYNC1 is answered with an echo of SYNC0", says(1, Become(b"\0"), body=1)),
    on_wire("echo1-argument", "the echo of SYNC1 has an argument", says(1, Become(b"\1\x3b\1\0"), body=1)),
    on_wire("echo-late", "the echo of SYNC0 comes 300 ms late", says(0, Late(0.3))),
    on_wire("echo-twice", "SYNC0 is echoed twice", says(0, Twice())),
    on_wire("echo-padded", "the echo of SYNC0 has a byte too many", says(0, Pad(b"\0"))),
    on_wire("id-no-nul", "the last string of the identification has no NUL", says(2, Cut(-1))),
    on_wire("id-two-strings", "the identification ends after the class", says(2, Cut(-5))),
    on_wire("id-padded", "a byte follows the identification", says(2, Pad(b"\0"))),
    in_flash("id-class", "the class is not Pioneer", robot_class="Pionier"),
    in_options("count-limit", "takes no count above 100", max_count=100),
    in_options("impatient", "gives a frame up 10 ms after its last byte", frame_timeout_s=0.01),
    in_table(
        "session-at-once",
        "begins the session with the identification, without waiting for OPEN",
        server_edge("WAIT2", "SYNC2_CLOSE", "OPEN", "IDENTIFY", "OPEN_SESSION"),
    ),
    in_table(
        "open-without-handshake",
        "takes an OPEN without any handshake",
        server_edge("WAIT", "OPEN_1", "OPEN", "OPEN_SESSION"),
    ),
    in_table(
        "commands-before-handshake",
        "obeys commands before the handshake",
        server_edge("WAIT", "COMMAND", "WAIT", "DELIVER_COMMAND"),
    ),
    in_table(
        "commands-before-open",
        "obeys commands between the identification and OPEN",
        server_edge("READY", "COMMAND", "READY", "DELIVER_COMMAND"),
    ),
    in_table(
        "echoes-everything",
        "echoes any command before the handshake",
        server_edge("WAIT", "COMMAND", "WAIT", "ECHO_0"),
    ),
    in_table(
        "no-restart",
        "SYNC0 does not restart a handshake",
        server_edge("WAIT1", "SYNC0_PULSE"),
        server_edge("WAIT2", "SYNC0_PULSE"),
    ),
    in_table("pulse-echoed", "echoes PULSE", server_edge("OPEN", "SYNC0_PULSE", "OPEN", "FEED_WATCHDOG", "ECHO")),
)

FRAMING = (
    on_wire("checksum-ignored", "takes frames with a wrong checksum", loses(DropReason.BAD_CHECKSUM, Mend())),
    on_wire(
        "checksum-bit-uncompared",
        "does not compare bit 5 of a checksum's low byte",
        loses(DropReason.BAD_CHECKSUM, MendIn(0xFFDF)),
    ),
    on_wire(
        "config-before-the-checksum",
        "answers CONFIG whatever its checksum is",
        loses(DropReason.BAD_CHECKSUM, Mend(), at={3: C.CONFIG}),
    ),
    on_wire("swallows-xon-xoff", "never sees XON and XOFF", Rule(Way.IN, Match(), Lose(b"\x11\x13"))),
    on_wire(
        "checksum-either-order",
        "takes a checksum with its low byte first, too",
        loses(DropReason.BAD_CHECKSUM, Mend(swapped=True)),
    ),
    on_wire("sync-lost-noise", "loses the frame behind noise", loses(DropReason.NOISE, Swallow())),
    on_wire(
        "sync-lost-checksum",
        "loses the frame behind one with a wrong checksum",
        loses(DropReason.BAD_CHECKSUM, Swallow()),
    ),
    on_wire("sync-lost-count", "loses the frame behind one with a wrong count", loses(DropReason.BAD_COUNT, Swallow())),
    on_wire("stray-fa", "loses the frame behind a stray FA", loses(DropReason.NOISE, Swallow(), ends=b"\xfa")),
    on_wire("short-count-taken", "takes a count of less than 3", loses(DropReason.BAD_COUNT, Then(b"\0"))),
    on_wire("long-count-taken", "takes a count of 250", Rule(Way.IN, Match(longer=200), Become(b"\0")), longest_in=255),
    on_wire("long-string-desync", "loses the frame behind a long string", hears(C.SAY, Swallow(), longer=100)),
    on_wire("one-per-cycle", "obeys one command in 50 ms", Rule(Way.IN, Match(within_s=0.05), Drop())),
    on_wire("say-nul-refused", "refuses a string with a NUL behind it", hears(C.SAY, Drop(), body=8)),
    on_wire("say-no-nul-refused", "refuses a string without a NUL behind it", hears(C.SAY, Drop(), body=7)),
    on_wire("say-desync", "loses the frame behind a string", hears(C.SAY, Swallow())),
    on_wire("out-checksum", "every tenth SIP has a wrong checksum", in_sips(Checksum(1), every=10)),
    on_wire("out-count", "the count of a SIP is one too many", in_sips(Count(1))),
    on_wire("out-count-now-and-then", "the count of every tenth SIP is one too few", in_sips(Count(-1), every=10)),
    on_wire("out-noise", "a byte stands before every tenth SIP", in_sips(Noise(b"\xfa"), every=10)),
)

SIPS = (
    on_wire("sip-padded", "a SIP has a byte too many", in_sips(Pad(b"\0"))),
    on_wire("sip-once-more", "says SIPs twice in the second session", Rule(Way.OUT, Match(), OnceMoreEachSession())),
    on_wire("sip-every-second", "every second SIP is left out", in_sips(Drop(), every=2)),
    on_wire("sip-twentieth", "every twentieth SIP is left out", in_sips(Drop(), every=20)),
    on_wire("sip-jitter", "every second SIP comes 30 ms late", in_sips(Late(0.03), every=2)),
    in_flash("sip-cycle", "a SIP comes every 130 ms", sip_cycle_ms=130),
    on_wire("type-standing", "the type is always 32", in_sips(Put(3, b"\x32"))),
    on_wire("type-moving", "the type is always 33", in_sips(Put(3, b"\x33"))),
    on_wire("stall-stuck", "the left stall bit is stuck", in_sips(Bits(offset=15, set=1))),
    on_wire(
        "stall-missing",
        "no stall bit is ever set",
        in_sips(Bits(offset=15, clear=1)),
        in_sips(Bits(offset=16, clear=1)),
    ),
    on_wire("stall-left-only", "a stall shows on the left only", in_sips(Bits(offset=16, clear=1))),
    on_wire("motors-flag-stuck", "the flag says motors on", in_sips(Bits(offset=19, set=1))),
    on_wire("motors-flag-missing", "the flag never says motors on", in_sips(Bits(offset=19, clear=1))),
    on_wire("sonar-flag-stuck", "the flag says sonar on", in_sips(Bits(offset=19, set=2))),
    on_wire("sonar-flag-missing", "the flag never says sonar on", in_sips(Bits(offset=19, clear=2))),
    on_wire("sonar-count", "the number of readings is off by one", in_sips(Bits(offset=22, turn=1))),
    on_wire("sonar-one-based", "discs are numbered from 1", in_sips(Sonars(plus=1))),
    on_wire("sonar-crowd", "every reading is sent ten times", in_sips(Sonars(copies=10))),
    on_wire("sonar-range", "ranges are 1 % too long", in_sips(Sonars(times=1.01))),
    in_flash("sonar-mm", "ranges are in mm", range_unit_mm=1.0),
    on_wire("th-sign", "Th grows clockwise", in_sips(Word(offset=8, signed=True, times=-1))),
    on_wire("th-unsigned", "Th goes from 0 to 4095", in_sips(Word(offset=8, signed=True, modulo=4096))),
    on_wire("th-stuck", "Th never changes", in_sips(Stick(8, 2))),
    on_wire("x-sign", "X decreases ahead", in_sips(Word(offset=4, times=-1, modulo=0x8000))),
    on_wire("x-stuck", "X never changes", in_sips(Stick(4, 2))),
    on_wire("y-stuck", "Y never changes", in_sips(Stick(6, 2))),
    on_wire("x-12-bits", "X wraps at 4096", in_sips(Word(offset=4, modulo=0x1000))),
    on_wire("x-16-bits", "X is negative in 16 bits", in_sips(Word(offset=4, plus=0x8000, least=0x4000))),
    on_wire("x-saturates", "X stays above 32000", in_sips(Word(offset=4, times=0, plus=32000, least=32000))),
    on_wire("x-at-rest", "X moves while the robot stands", in_sips(Word(offset=4, plus=3, modulo=0x8000), every=2)),
    in_flash("x-mm", "X and Y are in mm", distance_unit_mm=1.0),
    on_wire("speeds-swapped", "left and right speed are exchanged", in_sips(Swap(10, 12, 2))),
    on_wire("speeds-zero", "both speeds are always 0", in_sips(Put(10, bytes(4)))),
    on_wire("speeds-half", "the right speed is half of what it is", in_sips(Word(offset=12, signed=True, times=0.5))),
    on_wire("digout-stuck", "the outputs are always FF", in_sips(Put(-3, b"\xff"))),
    on_wire("battery-0", "the battery is always 0 V", in_sips(Put(14, b"\0"))),
    on_wire("battery-255", "the battery is always 25.5 V", in_sips(Put(14, b"\xff"))),
    on_wire("battery-jumps", "every second SIP has a battery of 15 V", in_sips(Put(14, b"\x96"), every=2)),
    on_wire("battery-drops-out", "every tenth SIP has a battery of 0 V", in_sips(Put(14, b"\0"), every=10)),
)

MOTION = (
    on_wire(
        "all-negative-positive",
        "takes negative arguments for positive",
        Rule(Way.IN, Match(at={4: NEGATIVE}), Put(4, b"\x3b")),
    ),
    on_wire(
        "vel-negative-positive", "takes a negative VEL for a positive", hears(C.VEL, Put(4, b"\x3b"), at={4: NEGATIVE})
    ),
    on_wire("vel-sign", "takes a positive VEL for a negative", hears(C.VEL, Put(4, b"\x1b"), at={4: POSITIVE})),
    on_wire("rvel-sign", "turns the other way at RVEL", hears(C.RVEL, Bits(offset=4, turn=0x20))),
    on_wire("rvel-unsigned", "turns left at a negative RVEL", hears(C.RVEL, Put(4, b"\x3b"))),
    on_wire("vel2-swapped", "exchanges the bytes of VEL2", hears(C.VEL2, Swap(5, 6))),
    on_wire("vel2-magnitude", "takes the magnitude of VEL2 for its bytes", hears(C.VEL2, Put(4, b"\x3b"))),
    on_wire("vel2-clipped", "refuses a VEL2 of 8000 hex and more", hears(C.VEL2, Drop(), at={4: POSITIVE, 6: 0xFB})),
    in_flash("vel2-unit", "takes VEL2 in 4 mm/s, as a Pioneer 1", vel2_unit_mm_s=4.0),
    on_wire("rvel-ends-vel", "RVEL ends a VEL", hears(C.RVEL, Before(VEL_0))),
    on_wire("vel-ignored", "ignores VEL", hears(C.VEL, Drop())),
    on_wire("head-sign", "takes HEAD clockwise", hears(C.HEAD, Bits(offset=4, turn=0x20))),
    on_wire("head-relative", "takes HEAD for DHEAD", hears(C.HEAD, Put(3, bytes((C.DHEAD,))))),
    on_wire("head-off", "turns 2 degrees too far at HEAD", hears(C.HEAD, Word(offset=5, plus=2))),
    on_wire("dhead-absolute", "takes DHEAD for HEAD", hears(C.DHEAD, Put(3, bytes((C.HEAD,))))),
    on_wire("dchead-dhead", "takes DCHEAD for DHEAD", hears(C.DCHEAD, Put(3, bytes((C.DHEAD,))))),
    on_wire("move-short", "goes 3 % too short at MOVE", hears(C.MOVE, Word(offset=5, times=0.97))),
    on_wire("setv-ignored", "ignores SETV", hears(C.SETV, Drop())),
    on_wire("seta-ignored", "ignores SETA", hears(C.SETA, Drop())),
    on_wire("seta-unsigned", "takes the deceleration of SETA for an acceleration", hears(C.SETA, Put(4, b"\x3b"))),
    on_wire("seto-ignored", "ignores SETO", hears(C.SETO, Drop())),
    on_wire("seto-truncated", "refuses a SETO whose argument has no value", hears(C.SETO, Drop(), body=2)),
    on_wire("stop-ignored", "ignores STOP", hears(C.STOP, Drop())),
    on_wire("stop-disables", "switches the motors off at STOP", hears(C.STOP, Become(ENABLE_0))),
    on_wire("stop-hard", "takes STOP for E_STOP", hears(C.STOP, Become(bytes((C.E_STOP,))))),
    on_wire("estop-soft", "takes E_STOP for STOP", hears(C.E_STOP, Become(STOP))),
    on_wire("estop-ignored", "ignores E_STOP", hears(C.E_STOP, Drop())),
    on_wire("motors-always-on", "switches the motors on at VEL", hears(C.VEL, Before(ENABLE_1))),
    on_wire("motors-on-at-open", "switches the motors on at OPEN", hears(C.OPEN, Then(ENABLE_1))),
    on_wire("enable-ignored", "ignores ENABLE 1", hears(C.ENABLE, Drop(), at=ON)),
    on_wire("enable-padded", "ignores an ENABLE with bytes behind its argument", hears(C.ENABLE, Drop(), longer=4)),
    on_wire("disable-ignored", "ignores ENABLE 0", hears(C.ENABLE, Drop(), at=OFF)),
    on_wire(
        "enable-behind-another", "ignores an ENABLE close behind another packet", hears(C.ENABLE, Drop(), within_s=0.02)
    ),
    on_wire(
        "outputs-behind-silence",
        "ignores ENABLE, SONAR and DIGOUT that come first behind two seconds of silence",
        Rule(Way.IN, Match(numbers=frozenset({C.ENABLE, C.SONAR, C.DIGOUT}), after_s=2.0), Drop()),
    ),
    on_wire(
        "late-stop-revives",
        "takes a command that stops for a PULSE where it comes first behind two seconds of silence",
        Rule(Way.IN, Match(numbers=frozenset({C.STOP, C.VEL, C.E_STOP}), after_s=2.0), Become(b"\0")),
    ),
    on_wire("enable-late", "obeys ENABLE 500 ms late", hears(C.ENABLE, Late(0.5))),
    in_options("watchdog-absent", "has no watchdog", watchdog_s=None),
    in_flash("watchdog-late", "has a watchdog of 4 s", watchdog_ms=4000),
    in_flash("watchdog-bit-late", "has a watchdog of 2.5 s", watchdog_ms=2500),
    in_flash("watchdog-early", "has a watchdog of 1 s", watchdog_ms=1000),
    deaf_to("WatchdogRevived", id="watchdog-final", what="does not go on after the watchdog"),
    in_table(
        "watchdog-pulse-only",
        "only PULSE feeds the watchdog",
        server_edge("OPEN", "COMMAND", "OPEN", "DELIVER_COMMAND"),
    ),
    in_table(
        "watchdog-closes",
        "closes the session when the watchdog runs out",
        server_edge("OPEN", "WATCHDOG", "WAIT", "CLOSE_SESSION"),
    ),
    on_wire("bumpstall-ignored", "ignores BUMPSTALL", hears(C.BUMPSTALL, Drop())),
    deaf_to("SessionClosed", id="motion-outlives-session", what="keeps motors and setpoints when a session ends"),
)

REQUESTS = (
    on_wire("sonar-off-ignored", "ignores SONAR 0", hears(C.SONAR, Drop(), at=OFF)),
    on_wire("sonar-on-ignored", "ignores SONAR 1", hears(C.SONAR, Drop(), at=ON)),
    on_wire(
        "sonar-off-at-open",
        "begins a session with the sonar off",
        hears(C.OPEN, Then(bytes((C.SONAR, POSITIVE, 0, 0)))),
    ),
    on_wire("polling-ignored", "ignores POLLING", hears(C.POLLING, Drop())),
    on_wire("polling-zero-based", "takes the numbers of POLLING from 0", hears(C.POLLING, Put(6, b"\2\6"))),
    on_wire("config-missing", "does not answer CONFIG", says(0x20, Drop())),
    on_wire("config-cut", "CONFIG ends in the middle", says(0x20, Cut(40))),
    on_wire("config-twice", "answers CONFIG twice", says(0x20, Twice())),
    on_wire("config-argument", "refuses a CONFIG without argument", hears(C.CONFIG, Drop(), body=1)),
    on_wire("encoder-endless", "does not end the stream of ENCODER", hears(C.ENCODER, Drop(), at=OFF)),
    on_wire("encoder-stream", "takes ENCODER 1 for ENCODER 2", hears(C.ENCODER, Put(5, b"\2"), at=ON)),
    on_wire("encoder-once", "takes ENCODER 2 for ENCODER 1", hears(C.ENCODER, Put(5, b"\1"), at=TWO)),
    on_wire("io-endless", "does not end the stream of IOREQUEST", hears(C.IOREQUEST, Drop(), at=OFF)),
    on_wire("io-missing", "does not answer IOREQUEST", says(0xF0, Drop())),
    on_wire("digout-ignored", "ignores DIGOUT", hears(C.DIGOUT, Drop())),
    on_wire("digout-swapped", "takes the mask of DIGOUT for the value", hears(C.DIGOUT, Swap(5, 6))),
    on_wire("digout-magnitude", "takes the magnitude of DIGOUT for its bytes", hears(C.DIGOUT, Put(4, b"\x3b"))),
    on_wire("battery-info-ends", "ends the session at BATTERYINFO", hears(C.BATTERYINFO, Become(bytes((C.CLOSE,))))),
    on_wire("unknown-ends", "ends the session at an unknown command", hears(200, Become(bytes((C.CLOSE,))))),
    on_wire("hostbaud-ignored", "ignores HOSTBAUD", hears(C.HOSTBAUD, Drop())),
    in_flash("hostbaud-final", "keeps an unused baud rate for 10 s", host_baud_trial_ms=10_000),
    on_wire("getaux-early", "sends AUX bytes when one is there", hears(C.GETAUX, Put(5, b"\1"), at=TWO)),
    on_wire("getaux-missing", "never sends AUX bytes", says(0xB0, Drop())),
)

CONFIG_TOP, CONFIG_CYCLE, CONFIG_LOW_BATTERY = 29, 48, 56
"""Where RotVelTop, SIPcycle and LowBattery stand in the CONFIG of the bench's robot, behind its strings."""

SETTINGS = (
    on_wire("gain-ignored", "ignores TRANSKI", hears(C.TRANSKI, Drop())),
    on_wire("config-top-off", "RotVelTop in CONFIG is one too many", says(0x20, Word(offset=CONFIG_TOP, plus=1))),
    on_wire("config-cycle", "CONFIG says 50 ms from SIP to SIP", says(0x20, Put(CONFIG_CYCLE, b"\x32"))),
    on_wire(
        "config-swapped",
        "LowBattery in CONFIG has its high byte first",
        says(0x20, Swap(CONFIG_LOW_BATTERY, CONFIG_LOW_BATTERY + 1)),
    ),
    on_wire(
        "config-revcount",
        "RevCount in CONFIG has its high byte first",
        says(0x20, Swap(CONFIG_LOW_BATTERY + 2, CONFIG_LOW_BATTERY + 3)),
    ),
    on_wire("config-baud", "HostBaud in CONFIG is 1 at 9600 bit/s", says(0x20, Put(CONFIG_CYCLE + 1, b"\x01"))),
    on_wire("encoders-exchanged", "exchanges the wheels of an encoder packet", says(0x90, Swap(4, 8, 4))),
    on_wire("io-inverted", "inverts the inputs of an IO packet", says(0xF0, Bits(offset=5, turn=0xFF))),
    on_wire("adsel-ignored", "ignores ADSEL", hears(C.ADSEL, Drop())),
    on_wire("stop-behind", "obeys STOP 100 ms late", hears(C.STOP, Late(0.1))),
    on_wire("setpoint-sign", "the setpoint grows clockwise", in_sips(Word(offset=17, signed=True, times=-1))),
)

SERVER_MUTANTS: tuple[Mutant, ...] = (*HANDSHAKE, *FRAMING, *SIPS, *MOTION, *REQUESTS, *SETTINGS)
