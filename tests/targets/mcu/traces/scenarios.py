"""What is run for the golden traces: each image, for how long, and what comes in from outside."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from random import Random

from protocols import xrce
from protocols.autoware import AckermannControlCommand, AgentOnline, Message, encode_frame, encode_message
from protocols.carla import StatusFrame, encode_status
from targets.boards import Board, built_in_board
from targets.firmware import image_names, image_path
from targets.mcu.engine.hooks import MOST_BREAKPOINTS, Watchpoint
from targets.mcu.image import Image, limits_of, load_image
from targets.mcu.machine import Machine
from targets.mcu.serial_line import SerialFormat
from targets.mcu.trace import Trace
from tests.targets.firmware.high_density import IMAGES as HIGH_DENSITY_IMAGES
from tests.targets.firmware.wires import put_wires

__all__ = ["PLAIN", "RUNS", "SCENARIOS", "Input", "Run", "Scenario", "trace"]

MS = 1_000_000
S = 1000 * MS
BLUE_PILL = built_in_board("bluepill")
BOARDS = {
    "f767": built_in_board("nucleo-f767zi"),
    "h753": built_in_board("nucleo-h753zi"),
    "style-hse-bypass": built_in_board("nucleo-f103rb"),
    "vehicle": built_in_board("nucleo-h753zi"),
    **HIGH_DENSITY_IMAGES,
}
_MOST_STEPS, _PLACES = 4000, 8
_MOST_HITS = 2000


@dataclass(frozen=True, slots=True)
class Input:
    """Something that happens outside, at a moment of bench time."""

    ns: int
    act: Callable[[Machine], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """An image, how long it runs at most, and what comes in."""

    image: str
    span_ns: int
    timing: str = "flat"
    inputs: tuple[Input, ...] = ()

    @property
    def name(self) -> str:
        return self.image if self.timing == "flat" else f"{self.image}.{self.timing}"

    @property
    def board(self) -> Board:
        return BOARDS.get(self.image) or BOARDS.get(self.image.partition("-")[0], BLUE_PILL)


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """A way to run a scenario; none may change its trace.

    Attributes:
        skip_idle: pass over loops that change nothing.
        step_ns: of the calls of `run_to`; None for a single call.
        seed: the calls of `run_to` end at times by chance, more of them in the beginning; None for not so.
        watched: somebody listens to each pin, so that every edge is told at its cycle.
        late: inputs are entered when the machine has come to them, not beforehand.
        hooked: it stops at many places, counts edges, and writes accesses to registers down.
    """

    skip_idle: bool = True
    step_ns: int | None = None
    seed: int | None = None
    watched: bool = False
    late: bool = False
    hooked: bool = False


PLAIN = Run()

RUNS: dict[str, Run] = {
    "executing-all": Run(skip_idle=False),
    "steps-of-137-ns": Run(step_ns=137),
    "steps-of-10-us": Run(step_ns=10_000),
    "steps-of-100-us": Run(step_ns=100_000),
    "steps-of-1-ms": Run(step_ns=MS),
    "steps-of-7-ms": Run(step_ns=7 * MS),
    "irregular-steps": Run(seed=1),
    "executing-all-in-irregular-steps": Run(skip_idle=False, seed=2),
    "watched": Run(watched=True),
    "inputs-entered-late": Run(late=True),
    "hooked": Run(hooked=True),
    "hooked-in-irregular-steps": Run(hooked=True, seed=3),
}


def load(name: str, board: Board) -> Image:
    return load_image(image_path(name), limits_of(board.variant))


def trace(scenario: Scenario, run: Run = PLAIN, *, image: str | None = None) -> tuple[list[str], list[str]]:
    """Return header and lines of a run, of another file with the same image if one is given."""
    board, name = scenario.board, image or scenario.image
    machine = Machine(board, load(name, board), timing=scenario.timing, skip_idle=run.skip_idle)
    put_wires(machine, scenario.image)
    recorder = Trace(machine)
    if run.watched:
        for pin in machine.chip.pins:
            pin.on_edge(lambda _cycle, _ns, _level: None)
    if not run.late:
        for one in scenario.inputs:
            machine.at_ns(one.ns, partial(one.act, machine))
    if run.hooked:
        _hook(machine)
    lines: list[str] = []
    hits = 0
    for stop_ns, due in _stops(scenario, run):
        machine.run_to(stop_ns)
        while machine.hit is not None:
            hits += 1
            if hits == _MOST_HITS:
                _unhook(machine)
            machine.run_to(stop_ns)
        lines += recorder.take()
        for one in due:
            one.act(machine)
    return [*recorder.header(), f"# span {scenario.span_ns} ns"], lines + recorder.close()


def _hook(machine: Machine) -> None:
    """Have it stop at functions, at places of flash by chance, within the stack, and at registers."""
    hooks, chance, code = machine.engine.hooks, Random(1), machine.image.segments[0]
    functions = sorted({symbol.address & ~1 for symbol in machine.image.symbols.functions})[: MOST_BREAKPOINTS // 2]
    places = (code.address + 2 * chance.randrange(len(code.data) // 2) for _ in range(MOST_BREAKPOINTS // 2))
    hooks.breakpoints = [*functions, *places]
    stack = int.from_bytes(code.data[:4], "little") - 256
    hooks.watchpoints = [Watchpoint(stack, 240, reads=True), Watchpoint(0x4001_0000, 0x1000, reads=True)]
    hooks.map_edges(1 << 16)
    hooks.log_accesses(1000)


def _unhook(machine: Machine) -> None:
    """Have it stop no more, but watch all the same."""
    hooks = machine.engine.hooks
    hooks.breakpoints = ()
    hooks.watchpoints = [Watchpoint(memory.base + len(memory.data) - 1, 1) for memory in machine.chip.memories]


def _stops(scenario: Scenario, run: Run) -> list[tuple[int, list[Input]]]:
    """Return where `run_to` ends each time, and what comes in then."""
    due: dict[int, list[Input]] = {}
    if run.late:
        for one in scenario.inputs:
            if one.ns < scenario.span_ns:
                due.setdefault(one.ns, []).append(one)
    return [(ns, due.get(ns, [])) for ns in sorted({scenario.span_ns, *_steps(scenario.span_ns, run), *due})]


def _steps(span_ns: int, run: Run) -> set[int]:
    """Return the ends of the steps: all over the span if they are few, otherwise in a few places of it."""
    if run.seed is not None:
        chance = Random(run.seed)
        everywhere = {chance.randrange(1, span_ns) for _ in range(_MOST_STEPS // 2)}
        early = {int(10 ** chance.uniform(2, 8)) for _ in range(_MOST_STEPS // 4)}
        return {ns for ns in everywhere | early if ns < span_ns}
    step_ns = run.step_ns
    if step_ns is None:
        return set()
    if span_ns // step_ns <= _MOST_STEPS:
        return set(range(step_ns, span_ns, step_ns))
    places = range(0, span_ns, span_ns // _PLACES)
    steps = {place + step * step_ns for place in places for step in range(_MOST_STEPS // _PLACES)}
    return {ns for ns in steps if 0 < ns < span_ns}


# --- inputs


def sends(usart: str, data: bytes, *, baud: int, at_ns: int, text_format: str = "8N1") -> tuple[Input, ...]:
    """Return the frames of `data`, one directly after the other, on the RX line of a USART."""
    form = SerialFormat.parse(text_format)
    half_bits = form.frame_half_bits

    def send(machine: Machine, index: int) -> None:
        start_s = Fraction(at_ns, S) + Fraction(index * half_bits, 2 * baud)
        machine.chip.usarts[usart].receive(form.frame(data[index], start_s, Fraction(1, baud)))

    return tuple(
        Input(at_ns + index * half_bits * S // (2 * baud), partial(send, index=index)) for index in range(len(data))
    )


def drives(pin: str, *changes: tuple[int, bool | None]) -> tuple[Input, ...]:
    """Return the levels that are put on a pin, at their moments."""
    return tuple(Input(ns, lambda machine, level=level: machine.chip.pins[pin].drive(level)) for ns, level in changes)


def puts(pin: str, *changes: tuple[int, float]) -> tuple[Input, ...]:
    """Return the voltages that are put on a pin, at their moments."""
    return tuple(
        Input(ns, lambda machine, volts=volts: machine.chip.pins[pin].drive_volts(volts)) for ns, volts in changes
    )


def frame_of(message: Message) -> bytes:
    """Return a message of the driving stack as it lies on the line."""
    return encode_frame(encode_message(message))


def _says(
    said: xrce.Submessage, *, at_ms: float, number: int | None = None, session_id: int = 0x81
) -> tuple[Input, ...]:
    """Return what an agent of DDS-XRCE says, on no stream or as a message of the built-in reliable one."""
    stream_id = 0 if number is None else 0x80
    header = xrce.Header(session_id=session_id, stream_id=stream_id, sequence=number or 0)
    frame = xrce.encode_frame(xrce.encode_message(header, xrce.encode_submessage(said)))
    return sends("USART3", frame, baud=921_600, at_ns=round(at_ms * MS))


def _object_at(place: int) -> int:
    """Return the id of the object that the vehicle interface creates there (targets/firmware/xrce/objects.c)."""
    if place < 3:
        return (0x11, 0x13, 0x14)[place]
    endpoint, is_end = divmod(place - 3, 2)
    kinds = (5, 5, 5, 6, 6, 8, 5, 5, 6, 6)  # writers, readers, a replier
    return endpoint + 2 << 4 | (kinds[endpoint] if is_end else 2)


def _control(angle_rad: float) -> bytes:
    """Return an AckermannControlCommand in CDR."""
    return struct.pack("<iIiIffiIfff", 0, 0, 0, 0, angle_rad, 0.0, 0, 0, 5.0, 0.0, 0.0)


# --- which

_TEXT = b"The quick brown fox jumps over the lazy dog. 0123456789\r\n" + bytes(range(0x80, 0x100))

_SPANS_MS = {
    "selftest": 1000,
    "bad": 300,
    "style": 250,
    "boot": 250,
    "robot": 250,
    "broken": 250,
    "bench": 100,
    "echo": 60,
    "h753": 250,
    "vehicle": 400,
}

# Statuses with a stray byte among them, a press of the joystick.
_CAR = (
    *(
        one
        for step in range(20)
        for one in sends(
            "USART2",
            b"#" * (step == 12) + encode_status(StatusFrame(lon_speed_m_s=0.25 * step)),
            baud=921_600,
            at_ns=(40 + 50 * step) * MS + 500_000,
        )
    ),
    *drives("PF13", (1080 * MS, False), (1100 * MS, None)),
)

# The same with an agent and ten commands.
_DRIVE = (
    *sends("USART3", frame_of(AgentOnline()), baud=921_600, at_ns=20 * MS),
    *(
        one
        for step in range(10)
        for one in sends(
            "USART3",
            frame_of(AckermannControlCommand(steering_tire_angle=0.1 * step, speed=5.0)),
            baud=921_600,
            at_ns=(30 + 33 * step) * MS,
        )
    ),
    *_CAR,
)

# The same with an agent that speaks DDS-XRCE: it has all objects created, and then acknowledges nothing any more.
_CREATED = [place for place in range(23) if place != 13]  # the sixth endpoint, a service, has no topic
_MICRO_ROS = (
    *_says(xrce.Info(request_id=1, object_id=xrce.OBJECT_AGENT, implementation_status=0), at_ms=20, session_id=0x80),
    *_says(xrce.StatusAgent(status=xrce.Status.OK, agent=xrce.Agent()), at_ms=25),
    *(
        one
        for number, place in enumerate(_CREATED)
        for one in (
            *_says(xrce.AckNack(first_unacked=number + 1, nack_bitmap=0, stream_id=0x80), at_ms=30 + number),
            *_says(
                xrce.StatusReply(request_id=10 + place, object_id=_object_at(place), status=xrce.Status.OK),
                at_ms=30.5 + number,
                number=number,
            ),
        )
    ),
    *_says(xrce.AckNack(first_unacked=len(_CREATED) + 5, nack_bitmap=0, stream_id=0x80), at_ms=56),
    *(
        one
        for step in range(10)
        for one in _says(
            xrce.TopicData(request_id=0x104, object_id=0x66, data=_control(0.1 * step)),
            at_ms=60 + 33 * step,
            number=len(_CREATED) + step,
        )
    ),
    *_CAR,
)

_OWN: dict[str, Scenario] = {
    scenario.image: scenario
    for scenario in (
        Scenario(
            image="echo-irq",
            span_ns=60 * MS,
            inputs=(
                *sends("USART1", _TEXT, baud=115_200, at_ns=10 * MS),
                *sends("USART1", b"slow", baud=112_000, at_ns=40 * MS),
                *sends("USART1", b"wrong rate", baud=76_800, at_ns=50 * MS),
            ),
        ),
        Scenario(
            image="echo-irq-921600", span_ns=20 * MS, inputs=sends("USART1", 4 * _TEXT, baud=921_600, at_ns=10 * MS)
        ),
        Scenario(image="echo-dma", span_ns=20 * MS, inputs=sends("USART1", 4 * _TEXT, baud=921_600, at_ns=10 * MS)),
        Scenario(
            image="echo-all",
            span_ns=40 * MS,
            inputs=(
                *sends("USART1", _TEXT, baud=115_200, at_ns=10 * MS),
                *sends("USART2", _TEXT[::-1], baud=115_200, at_ns=10 * MS),
                *sends("USART3", _TEXT, baud=115_200, at_ns=10 * MS + 1),
            ),
        ),
        Scenario(image="style-clock", span_ns=80_000 * MS),
        Scenario(
            image="style-analog",
            span_ns=70 * MS,
            inputs=(
                *puts("PA0", (0, 1.65), (30 * MS, 0.5), (45 * MS, 3.0)),
                *puts("PA1", (0, 2.0), (38 * MS, 2.6), (39 * MS, 2.4)),
            ),
        ),
        Scenario(
            image="style-irq-dma",
            span_ns=60 * MS,
            inputs=(
                *sends("USART1", b"count\r\n", baud=115_200, at_ns=12 * MS),
                *drives("PA0", (20 * MS, False), (21 * MS, True), (30 * MS, False), (34 * MS, None)),
                *sends("USART1", b"led\r\nnothing like this\r\ncount\r\n", baud=115_200, at_ns=35 * MS),
            ),
        ),
        Scenario(
            image="style-hal", span_ns=220 * MS, inputs=sends("USART2", b"lower case", baud=115_200, at_ns=110 * MS)
        ),
        Scenario(
            image="style-ll-sleep",
            span_ns=1300 * MS,
            inputs=drives("PA0", (50 * MS, True), (51 * MS, False), (1200 * MS, True), (1210 * MS, None)),
        ),
        Scenario(image="bench-adc-dma", span_ns=8 * MS, inputs=puts("PA0", (0, 1.0), (4 * MS, 2.0))),
        Scenario(image="style-display", span_ns=20 * MS),
        Scenario(image="style-soft-i2c", span_ns=40 * MS),
        Scenario(image="style-registers", span_ns=1600 * MS),
        *(
            Scenario(image=f"style-{name}", span_ns=60 * MS, inputs=(*puts("PA0", (0, 1.65)), *puts("PA1", (0, 0.4))))
            for name in ("arduino", "drivers", "hal-buses", "ll-buses", "opencm3")
        ),
        Scenario(
            image="style-value-line",
            span_ns=120 * MS,
            inputs=(
                *sends("USART1", b"value", baud=115_200, at_ns=20 * MS),
                *drives("PA0", (60 * MS, True), (75 * MS, False)),
            ),
        ),
        Scenario(
            image="style-dac-dma",
            span_ns=120 * MS,
            inputs=(
                *sends("UART4", b"dac, Dma.", baud=115_200, at_ns=20 * MS),
                *sends("UART4", b"x", baud=76_800, at_ns=40 * MS),
            ),
        ),
        Scenario(
            image="style-hse-bypass",
            span_ns=120 * MS,
            inputs=(
                *sends("USART2", b"echo", baud=115_200, at_ns=20 * MS),
                *drives("PC13", (70 * MS, False), (80 * MS, None)),
            ),
        ),
        Scenario(
            image="f767-demo",
            span_ns=300 * MS,
            inputs=(
                *sends("USART3", _TEXT, baud=115_200, at_ns=20 * MS),
                *sends("USART3", b"wrong rate", baud=76_800, at_ns=40 * MS),
                *drives("PC13", (50 * MS, True), (60_500_000, None)),
            ),
        ),
        Scenario(image="f767-chip", span_ns=2200 * MS),
        Scenario(
            image="h753-demo",
            span_ns=300 * MS,
            inputs=(
                *sends("USART3", _TEXT, baud=115_200, at_ns=20 * MS),
                *sends("USART3", b"wrong rate", baud=76_800, at_ns=40 * MS),
                *drives("PC13", (50 * MS, True), (60_500_000, None)),
            ),
        ),
        Scenario(image="h753-chip", span_ns=1200 * MS),
        *(Scenario(image=f"h753-{name}", span_ns=25 * MS) for name in ("adc16", "dmamux", "one-shot", "usart-fifo")),
        *(Scenario(image=f"{board}-lptim", span_ns=150 * MS) for board in ("f767", "h753")),
        Scenario(image="f767-ticker", span_ns=4700 * MS),
        *(
            Scenario(
                image=f"{board}-sleep",
                span_ns=250 * MS,
                inputs=drives(
                    "PC13", *((50 * MS + 5 * MS * step, step % 2 == 0) for step in (0, 1, 10, 11, 20, 21, 30, 31))
                ),
            )
            for board in ("f767", "h753")
        ),
        *(Scenario(image=f"f767-{name}", span_ns=50 * MS) for name in ("adc", "dma", "i2c", "spi")),
        *(Scenario(image=f"{board}-flash", span_ns=10 * MS) for board in ("f767", "h753")),
        Scenario(image="h753-spi", span_ns=25 * MS),
        *(Scenario(image=f"vehicle{which}", span_ns=1200 * MS, inputs=_DRIVE) for which in ("", "-v0", "-v1")),
        Scenario(image="vehicle-micro-ros", span_ns=1200 * MS, inputs=_MICRO_ROS),
        Scenario(image="f767-pins", span_ns=50 * MS),
        Scenario(image="f767-serial", span_ns=50 * MS),
        Scenario(image="f767-timers", span_ns=50 * MS),
        Scenario(image="boot-loader", span_ns=100 * MS, inputs=drives("PB9", (0, False))),
    )
}


def _scenario(image: str) -> Scenario:
    return _OWN.get(image) or Scenario(image=image, span_ns=_SPANS_MS[image.partition("-")[0]] * MS)


_BY_TABLE = (
    replace(_scenario("f767-demo"), timing="table", span_ns=30 * MS),
    replace(_scenario("h753-demo"), timing="table", span_ns=25 * MS),
    replace(_scenario("bench-tick-1khz"), timing="table"),
    replace(_scenario("bad-hardfault-loop"), timing="table", span_ns=5 * MS),
    replace(_scenario("echo-irq"), timing="table", span_ns=25 * MS),
    replace(_scenario("echo-dma"), timing="table", span_ns=14 * MS),
    replace(_scenario("style-irq-dma"), timing="table"),
    replace(_scenario("style-kernel"), timing="table", span_ns=20 * MS),
    replace(_scenario("style-ll-sleep"), timing="table"),
    replace(_scenario("selftest-systick"), timing="table"),
    replace(_scenario("selftest-nvic"), timing="table"),
)

# The rovers do little without a rover around them; of the vehicle interfaces these say what there is to say.
_VEHICLES = ("vehicle", "vehicle-v0", "vehicle-v1", "vehicle-micro-ros")
_IMAGES = [name for name in image_names() if not name.startswith(("rover", "vehicle-")) or name in _VEHICLES]

SCENARIOS: dict[str, Scenario] = {scenario.name: scenario for scenario in (*map(_scenario, _IMAGES), *_BY_TABLE)}
"""By name: that of the image, and ``.table`` for runs with that timing model."""
