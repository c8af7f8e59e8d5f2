"""Faulty clients, made by hand."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from measure.mutants.mutant import Edge, Family, Mutant, client_edge
from measure.mutants.wire import (
    Become,
    Bits,
    Drop,
    FillSip,
    Late,
    Leave,
    Match,
    Mend,
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
from protocols.p2os import DropReason, UnknownSubclass

SIP = frozenset({0x32, 0x33})
NEGATIVE = 0x1B
CONFIG, IDENTIFICATION, RESET = 0x20, 0x02, 0xFF
SOUND_IDENTIFICATION = b"\x02bench\0Pioneer\0p2dx\0"


def hears(number: int, do: Operation, *, at: Mapping[int, int] = MappingProxyType({}), **match: object) -> Rule:
    """Do something to a packet before the client hears it."""
    return Rule(Way.IN, Match(numbers=frozenset({number}), at=at, **match), do)  # type: ignore[arg-type]


def in_sips(do: Operation, **match: object) -> Rule:
    """Do something to the SIPs before the client hears them."""
    return Rule(Way.IN, Match(numbers=SIP, **match), do)  # type: ignore[arg-type]


def loses(reason: DropReason, do: Operation) -> Rule:
    """Do something where bytes come that are no frame."""
    return Rule(Way.IN, Match(dropped=reason), do)


def says(number: int, do: Operation, *, at: Mapping[int, int] = MappingProxyType({}), **match: object) -> Rule:
    """Do something to a command that the client sends."""
    return Rule(Way.OUT, Match(numbers=frozenset({number}), at=at, **match), do)  # type: ignore[arg-type]


def on_wire(id: str, what: str, *rules: Rule) -> Mutant:  # noqa: A002 - the name of the field
    return Mutant(id=id, family=Family.CLIENT_HAND, what=what, wire=rules)


def in_options(id: str, what: str, **options: object) -> Mutant:  # noqa: A002
    return Mutant(id=id, family=Family.CLIENT_HAND, what=what, client_options=options)


def in_table(id: str, what: str, *edges: Edge) -> Mutant:  # noqa: A002
    return Mutant(id=id, family=Family.CLIENT_HAND, what=what, edges=edges)


CLIENT_MUTANTS: tuple[Mutant, ...] = (
    # the handshake
    in_options("c-never-gives-up", "tries for ever", silent_attempts=10**6),
    in_options("c-one-try", "tries SYNC0 once", silent_attempts=1),
    in_options("c-hasty", "waits 300 ms for an echo", sync_timeout_s=0.3, max_misses=3),
    in_options("c-frame-timeout", "gives a frame up 10 ms after its last byte", frame_timeout_s=0.01),
    in_options("c-no-pause-after-close", "does not wait after CLOSE to an old session", close_silence_s=0.01),
    in_options("c-one-rate", "tries one baud rate", bauds=()),
    in_options(
        "c-always-falls-back",
        "takes any robot for a p2dx",
        unknown_subclass=UnknownSubclass.FALL_BACK,
        fallback_subclass="p2dx",
    ),
    in_options(
        "c-always-refuses", "refuses an unknown robot whatever it is told", unknown_subclass=UnknownSubclass.REFUSE
    ),
    on_wire("c-pipelines", "sends SYNC1 behind SYNC0 at once", says(0, Then(b"\1"))),
    on_wire("c-opens-early", "sends OPEN behind SYNC2 at once", says(2, Then(b"\1\x3b\1\0"), body=1)),
    on_wire("c-old-session-moving", "does not notice an old session in motion", hears(0x33, Drop())),
    on_wire("c-refusal-unheard", "does not hear a SYNC error", hears(RESET, Drop())),
    on_wire(
        "c-takes-broken-id",
        "takes an identification without its strings",
        hears(IDENTIFICATION, Become(SOUND_IDENTIFICATION), shorter=20),
    ),
    on_wire("c-name-lost", "misreads the name of the robot", hears(IDENTIFICATION, Put(4, b"B"))),
    in_table(
        "c-any-echo",
        "takes any echo for that of SYNC1",
        client_edge("SYNC1_SENT", "ECHO0", "SYNC2_SENT", "SEND_SYNC2"),
    ),
    in_table(
        "c-skips-sync2",
        "opens a session without SYNC2",
        client_edge("SYNC1_SENT", "ECHO1", "OPENING", "ACCEPT"),
    ),
    # what comes in
    on_wire("c-checksum-ignored", "takes packets with a wrong checksum", loses(DropReason.BAD_CHECKSUM, Mend())),
    on_wire("c-sync-lost-noise", "loses the packet behind noise", loses(DropReason.NOISE, Swallow())),
    on_wire("c-sync-lost-checksum", "loses the packet behind a damaged one", loses(DropReason.BAD_CHECKSUM, Swallow())),
    on_wire("c-unknown-is-reset", "takes an unknown packet for a reset", hears(0x61, Become(b"\xff"))),
    on_wire("c-empty-unknown-is-reset", "takes 7E for a reset", hears(0x7E, Become(b"\xff"))),
    on_wire("c-eight-sonars", "keeps eight readings", in_sips(Sonars(keep=8), whole_sip=True)),
    on_wire("c-no-tail", "refuses a SIP with more behind its last field", in_sips(Drop(), more_than_sip=True)),
    on_wire("c-over-read", "reads a SIP beyond its end", in_sips(FillSip(), less_than_sip=True)),
    on_wire("c-twice", "takes every SIP twice", in_sips(Twice())),
    on_wire("c-x-12-bits", "takes X for 12 bits", in_sips(Word(offset=4, modulo=0x1000))),
    on_wire("c-x-signed", "takes X for a signed byte and a half", in_sips(Word(offset=4, modulo=0x4000))),
    on_wire("c-th-unsigned", "takes Th for a number without sign", in_sips(Word(offset=8, signed=True, modulo=4096))),
    on_wire("c-th-sign", "takes Th clockwise", in_sips(Word(offset=8, signed=True, times=-1))),
    on_wire("c-speeds-swapped", "exchanges left and right speed", in_sips(Swap(10, 12, 2))),
    on_wire("c-stalls-swapped", "exchanges left and right stall", in_sips(Swap(15, 16))),
    on_wire("c-battery", "misreads the battery by a volt", in_sips(Bits(offset=14, turn=8))),
    on_wire("c-range-big-endian", "takes ranges high byte first", in_sips(Swap(24, 25), longer=25)),
    on_wire("c-short-config-refused", "refuses a CONFIG that ends early", hears(CONFIG, Drop(), shorter=60)),
    on_wire("c-reset-unheard", "does not notice a reset", hears(RESET, Drop())),
    on_wire("c-config-big-endian", "takes RotVelTop of CONFIG high byte first", hears(CONFIG, Swap(27, 28))),
    on_wire("c-compass-stuck", "reads the compass once", in_sips(Stick(21, 1))),
    in_options("c-config-or-nothing", "waits for CONFIG for ever", config_wait_s=10.0**6),
    in_options("c-patient", "takes a silent robot for alive for 30 s", sip_timeout_s=30.0),
    in_options("c-bit-patient", "takes a silent robot for alive for 11 s", sip_timeout_s=11.0),
    # what goes out
    in_options("c-no-keepalive", "does not keep its session alive", keepalive_s=None),
    in_options("c-slow-keepalive", "speaks every 1.5 s", keepalive_s=1.5),
    on_wire(
        "c-negative-positive",
        "sends negative arguments as positive",
        Rule(Way.OUT, Match(at={4: NEGATIVE}), Put(4, b"\x3b")),
    ),
    on_wire(
        "c-twos-complement",
        "sends -200 as 3B 38 FF",
        says(C.VEL, Word(offset=5, times=-1), at={4: NEGATIVE}),
        says(C.VEL, Put(4, b"\x3b")),
    ),
    on_wire("c-big-endian", "sends arguments high byte first", says(C.VEL, Swap(5, 6)), says(C.HEAD, Swap(5, 6))),
    on_wire("c-enable-2", "sends ENABLE 2 to switch the motors on", says(C.ENABLE, Put(5, b"\2"), at={5: 1})),
    on_wire("c-vel2-swapped", "exchanges the bytes of VEL2", says(C.VEL2, Swap(5, 6))),
    on_wire("c-vel2-magnitude", "sends the bytes of VEL2 without their sign", says(C.VEL2, Put(4, b"\x3b"))),
    on_wire("c-string-no-length", "sends strings without a length", says(C.SAY, Leave(5), longer=3)),
    on_wire("c-count-over-200", "fills long strings up to more than 200", says(C.SAY, Pad(bytes(20)), longer=150)),
    on_wire("c-motors-left-on", "leaves without stopping the robot", says(C.ENABLE, Drop(), at={5: 0})),
    on_wire("c-close-missing", "leaves without CLOSE", says(C.CLOSE, Drop(), longer=1)),
    on_wire("c-late-leave", "sends CLOSE 5 s late", says(C.CLOSE, Late(5.0), longer=1)),
    on_wire("c-open-missing", "does not send OPEN", says(C.OPEN, Drop(), longer=1)),
    in_table(
        "c-leave-and-talk",
        "goes on talking after its leave",
        client_edge("CLOSING", "TIMEOUT", "SYNC0_SENT", "SEND_CLOSE", "SEND_SYNC0"),
    ),
)
