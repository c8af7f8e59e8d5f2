"""Robots that answer well and move wrongly, made by hand."""

from __future__ import annotations

from measure.mutants.mutant import BodyFault, Family, Mutant
from measure.mutants.server_hand import OFF, STOP, hears, in_sips
from measure.mutants.wire import Become, Before, Bits, Drop, Put, Rule, Sonars, Stick, Swap, Word
from protocols.p2os import CommandNumber as C

_ENABLE_1, _VEL_0, _RVEL_0 = (
    bytes((number, 0x3B, value, 0)) for number, value in ((C.ENABLE, 1), (C.VEL, 0), (C.RVEL, 0))
)


def in_body(id: str, what: str, **fault: object) -> Mutant:  # noqa: A002 - the name of the field
    return Mutant(id=f"m-{id}", family=Family.MOTION_HAND, what=what, body=BodyFault(**fault))  # type: ignore[arg-type]


def in_flash(id: str, what: str, **settings: object) -> Mutant:  # noqa: A002
    return Mutant(id=f"m-{id}", family=Family.MOTION_HAND, what=what, settings=settings)


def on_wire(id: str, what: str, *rules: Rule) -> Mutant:  # noqa: A002
    return Mutant(id=f"m-{id}", family=Family.MOTION_HAND, what=what, wire=rules)


MOTION_MUTANTS: tuple[Mutant, ...] = (
    # wheels and track
    in_body("wheels-fast", "both wheels turn 1 % too fast", wheel_scale=(1.01, 1.01)),
    in_body("wheel-left-slow", "the left wheel turns 1 % too slowly", wheel_scale=(0.99, 1.0)),
    in_flash("wheel-diameter", "believes in wheels of 168 mm instead of 165", wheel_diameter_mm=168.0),
    in_flash("wheel-right-error", "believes the right wheel 1 % larger than it is", right_wheel_error=0.01),
    in_flash("track-error", "believes in a track 2 % too wide", track_error=0.02),
    in_body("wheels-limited", "the wheels turn at 430 mm/s at most", top_rad_s=5.2),
    # ways, speeds, ramps
    on_wire("move-short", "goes 1 % too short at MOVE", hears(C.MOVE, Word(offset=5, times=0.99))),
    on_wire("vel-slow", "drives 2 % too slowly at VEL", hears(C.VEL, Word(offset=5, times=0.98))),
    on_wire("vel-unsigned", "drives ahead at a negative VEL", hears(C.VEL, Put(4, b"\x3b"))),
    on_wire("seta-ignored", "ignores SETA", hears(C.SETA, Drop())),
    on_wire("acceleration-high", "accelerates 10 % too fast", hears(C.SETA, Word(offset=5, times=1.1), at={4: 0x3B})),
    on_wire("deceleration-low", "brakes 10 % too gently", hears(C.SETA, Word(offset=5, times=0.9), at={4: 0x1B})),
    on_wire("setv-ignored", "ignores SETV", hears(C.SETV, Drop())),
    on_wire("setv-loose", "goes 5 % beyond SETV", hears(C.SETV, Word(offset=5, times=1.05))),
    on_wire("setrv-ignored", "ignores SETRV", hears(C.SETRV, Drop())),
    # turning
    on_wire("rvel-sign", "turns the other way at RVEL", hears(C.RVEL, Bits(offset=4, turn=0x20))),
    on_wire("rvel-slow", "turns 2 degrees/s too slowly at RVEL", hears(C.RVEL, Word(offset=5, plus=-2))),
    on_wire("head-relative", "takes HEAD for DHEAD", hears(C.HEAD, Put(3, bytes((C.DHEAD,))))),
    on_wire("head-short", "turns 1 degree too little at HEAD", hears(C.HEAD, Word(offset=5, plus=-1))),
    on_wire("dhead-absolute", "takes DHEAD for HEAD", hears(C.DHEAD, Put(3, bytes((C.HEAD,))))),
    on_wire("dhead-sign", "turns the other way at DHEAD", hears(C.DHEAD, Bits(offset=4, turn=0x20))),
    on_wire("rvel-ends-vel", "RVEL ends a VEL", hears(C.RVEL, Before(_VEL_0))),
    on_wire("vel2-swapped", "exchanges the bytes of VEL2", hears(C.VEL2, Swap(5, 6))),
    in_flash("vel2-unit", "takes VEL2 in 19 mm/s", vel2_unit_mm_s=19.0),
    # stopping
    in_flash("watchdog-late", "has a watchdog of 2.2 s", watchdog_ms=2200),
    Mutant(
        id="m-watchdog-absent", family=Family.MOTION_HAND, what="has no watchdog", server_options={"watchdog_s": None}
    ),
    on_wire("estop-soft", "takes E_STOP for STOP", hears(C.E_STOP, Become(STOP))),
    on_wire("stop-ignored", "ignores STOP", hears(C.STOP, Drop())),
    on_wire("disable-ignored", "ignores ENABLE 0", hears(C.ENABLE, Drop(), at=OFF)),
    in_body("never-released", "the wheels stay under power when the motors are off", never_released=True),
    on_wire("motors-always-on", "switches the motors on at VEL", hears(C.VEL, Before(_ENABLE_1))),
    on_wire("motors-on-at-move", "switches the motors on at MOVE", hears(C.MOVE, Before(_ENABLE_1))),
    # what is reported
    in_flash("x-unit", "reports X and Y 2 % too small", distance_unit_mm=0.84 * 1.02),
    on_wire("y-sign", "Y grows to the right", in_sips(Word(offset=6, times=-1, modulo=0x8000))),
    on_wire("y-stuck", "Y never changes", in_sips(Stick(6, 2))),
    on_wire("th-sign", "Th grows clockwise", in_sips(Word(offset=8, signed=True, times=-1))),
    on_wire("th-stuck", "Th never changes", in_sips(Stick(8, 2))),
    on_wire("th-scale", "Th is 2 % too small", in_sips(Word(offset=8, signed=True, times=0.98))),
    # contacts
    in_flash("stall-never", "never notices a stall", stall_pwm=65_535),
    in_flash("stall-eager", "takes hard work for a stall", stall_pwm=10),
    in_flash("stall-for-ever", "keeps a stalled wheel off for a minute", stall_wait_ms=60_000),
    in_body("load-zero", "the motors report no load", motor_load=0.0),
    on_wire(
        "stall-stuck", "the stall bits are stuck", in_sips(Bits(offset=15, set=1)), in_sips(Bits(offset=16, set=1))
    ),
    on_wire("stall-left-only", "a stall shows on the left only", in_sips(Bits(offset=16, clear=1))),
    in_body("bumpers-mirrored", "the bumper segments are counted from the wrong side", bumpers_mirrored=True),
    in_body("bumpers-swapped", "front and rear bumper are exchanged", bumpers_swapped=True),
    on_wire(
        "bumpers-silent",
        "no bumper bit is ever set",
        in_sips(Bits(offset=15, clear=0x3E)),
        in_sips(Bits(offset=16, clear=0x3E)),
    ),
    # echoes
    in_body("sonar-far", "ranges are 2 % too long", sonar_scale=1.02),
    in_body("sonar-near", "ranges are 30 mm too short", sonar_shift_m=-0.03),
    in_body("sonar-mirrored", "the discs are counted from the wrong side", sonar_mirrored=True),
    in_body("sonar-deaf", "disc 5 never hears anything", sonar_deaf=frozenset({5})),
    on_wire("sonar-one-based", "discs are numbered from 1", in_sips(Sonars(plus=1))),
    on_wire("sonar-swallowed", "no SIP has a reading", in_sips(Sonars(keep=0))),
)
