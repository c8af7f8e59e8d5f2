"""A bench with emulated boards: machines from images, lines, wires, a robot at the far end, and what is recorded."""

from __future__ import annotations

import contextlib
import dataclasses
from collections import Counter, deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import ceil
from pathlib import Path

from hilbench.bench import Bench
from hilbench.bench.byte_log import ByteLog
from hilbench.benchfile.bench_file import BenchFile, EmulatedBoard, Link, Net
from hilbench.clock import NS_PER_S, EventClass, Scheduler
from hilbench.journal import Journal
from hilbench.mcu.far_ends import FarEnds
from hilbench.mcu.group import FREE_STEP_NS, MachineGroup
from hilbench.mcu.images import load, translated
from hilbench.mcu.pin_log import PinLog
from hilbench.mcu.seams import Ending, Machine
from hilbench.mcu.stimuli import Stimuli
from hilbench.mcu.surroundings import Surroundings
from hilbench.mcu.usart_port import UsartPort
from hilbench.mcu.vcd import Waveforms
from targets.mcu.cortexm.faults import Fault
from targets.mcu.errors import McuError
from targets.mcu.fidelity import Fidelity, Note
from targets.mcu.image import Image
from targets.mcu.nets import Nets
from targets.mcu.pins import Pin
from targets.mcu.registers import Peripheral, Register
from targets.mcu.serial_line import SerialFrame, Words

__all__ = ["EmulatedBench", "End", "MachineFactory", "make_machine"]

_FRAME_BITS = 8
"""Of a frame of ten bits this much must have gone by at most when its receiver learns of it."""
_FROM_OUTSIDE = frozenset({"POR", "PIN"})
"""Resets that say nothing of the firmware: power and the button."""
_LOCKSTEPS_PER_BIT = 4
"""A frame whose edges are late by up to a quarter of a bit is read rightly in most cases, by more in few (choice)."""

_LOOK_NS = 10_000_000
"""How often a look is taken at what programs do (choice); a bench with a world has many more rounds than that."""
_ASLEEP_STEP_NS = NS_PER_S // 10
"""It changes nothing but how much is collected; pins are looked at as often anyway, see `pin_log` (choice)."""
_LOOKS, _FUNCTIONS_NAMED = 32, 3
"""How many looks at a program that neither waits nor sleeps are kept, and what is reported of them (choice)."""

MachineFactory = Callable[[EmulatedBoard, Image], Machine]


def make_machine(emulated: EmulatedBoard, image: Image) -> Machine:
    """Make the chip of a board, with its image flashed and power just on."""
    from targets.mcu.machine import Machine as RealMachine

    board = dataclasses.replace(emulated.board, straps=emulated.straps)
    return RealMachine(board, image, timing=emulated.timing, skip_idle=emulated.skip_idle)


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class End:
    """How the firmware of a board came to its end.

    Attributes:
        board: name of the board in the bench.
        kind: ``exit``, ``stop`` where it was to end, or what has gone wrong.
        status: what the firmware gave with its exit.
        ns: bench time.
        pc: address of the instruction.
        place: function and source line, as far as the image tells.
        cause: what happened, in words.
    """

    board: str
    kind: str
    status: int
    ns: int
    pc: int
    place: str
    cause: str

    @property
    def good(self) -> bool:
        """True if the firmware has said that all is well, or the run was to end there."""
        return self.kind in ("exit", "stop") and self.status == 0

    def __str__(self) -> str:
        where = f"PC 0x{self.pc:08X}, after {self.ns / NS_PER_S:.6f} s"
        if self.kind == "exit":
            at = f"{self.place}, {where}" if self.place else where
            return f"{self.board}: the firmware ended with status {self.status}: {at}"
        at = f"in {self.place}, {where}" if self.place else f"at {where}"
        return f"{self.board}: {self.kind} {at}: {self.cause.removeprefix(f'{self.kind}: ')}"


@dataclass(frozen=True, slots=True)
class _Lack:
    """A wait for something that is not modelled.

    Attributes:
        since_ns: bench time at which it was first seen.
        writes: what the program had written until then.
        text: for people.
    """

    since_ns: int
    writes: int
    text: str


@dataclass(slots=True)
class Resets:
    """How often a board was reset by one cause.

    Attributes:
        count: how often.
        last_ns: bench time of the last one.
    """

    count: int = 0
    last_ns: int = 0


class EmulatedBench:
    """See the module.

    Args:
        bench_file: what to build; it names at least one board.
        seed: of everything random.
        journal: where the journal is written; None keeps the latest events in memory only.
        vcd: where waveforms are written; None for none.
        step_ns: how far the chips run ahead of bench time.
        edges_of_frames: whether the journal gets the edges of pins that send serial frames, beside the bytes.
        make_machine: makes the chips.
        bench: time and journal to live in, which stay the caller's to close; None for its own.

    Raises:
        UsageError: an image cannot run on its board; a wire or a robot is wrong.
        UnavailableError: an image, the engine or the physics is missing; journal or waveforms cannot be written.

    Attributes:
        bench: time and journal.
        images: the firmware, by board.
        machines: the chips, by board.
        ports: the far ends of the USARTs' lines, as ``BOARD.usart1``, without faults.
        far_ends: the same with the faults of the bench file, for who speaks to the boards.
        consoles: who receives what a console says, as ``BOARD.CHANNEL``; a console is there once it has spoken.
        on_console: called with the name of each new console.
        stimuli: does what is done to the boards from outside; those of the bench file are booked.
        surroundings: parts, and a robot or a vehicle in its world, as far as the bench has them.
        at_close: called before the bench closes.
        end: how the firmware of the first board that ended came to its end; None while all run.
        resets: of each board, by cause.
    """

    def __init__(
        self,
        bench_file: BenchFile,
        *,
        seed: int = 0,
        journal: Path | None = None,
        journal_max: int | None = None,
        vcd: Path | None = None,
        step_ns: int = FREE_STEP_NS,
        edges_of_frames: bool = False,
        make_machine: MachineFactory = make_machine,
        bench: Bench | None = None,
    ) -> None:
        self.bench_file = bench_file
        self._seed = seed
        self._step_ns = step_ns
        self._edges_of_frames = edges_of_frames
        self._far_wired = {
            str(pin) for net in bench_file.nets if len({pin.board for pin in net.pins}) > 1 for pin in net.pins
        }
        self.images: Mapping[str, Image] = {name: load(emulated) for name, emulated in bench_file.boards.items()}
        self.at_close: list[Callable[[], None]] = []
        self._notes: list[dict[str, object]] = []
        self._happened: dict[tuple[str, str, str], dict[str, object]] = {}
        self.consoles: dict[str, list[Callable[[bytes, int], None]]] = {}
        self.on_console: Callable[[str], None] = lambda _name: None
        self.end: End | None = None
        self.resets: dict[tuple[str, str], Resets] = {}
        self._lacks: dict[str, _Lack | None] = {}
        self._heard_ns: dict[str, int] = {}
        self._said: dict[str, SerialFrame] = {}
        self._next_look_ns = 0
        self._looks: dict[str, deque[int]] = {name: deque(maxlen=_LOOKS) for name in bench_file.boards}
        with contextlib.ExitStack() as undo:
            self.machines = self._make_machines(make_machine)
            if bench is None:
                bench = Bench(Scheduler(), Journal(journal, self._header(), max_bytes=journal_max))
                undo.callback(lambda: self.bench.journal.close(self.bench.now_ns))
            self.bench = bench
            self._group = MachineGroup(self.bench, self.machines, step_ns=step_ns)
            self._group.on_ended = self._ended
            self._group.after_round.append(self._look)
            self._waveforms = Waveforms(vcd) if vcd is not None else None
            if self._waveforms is not None:
                undo.callback(self._close_waveforms)
            self.ports: dict[str, UsartPort] = dict(self._make_ports())
            self._byte_logs: list[ByteLog] = []
            for full, port in self.ports.items():
                port.heard_taps.append(partial(self._heard, _board_of(full)))
                port.frame_taps.append(partial(self._say, _board_of(full)))
            self._wire()
            self._join_lines()
            self.far_ends = FarEnds(self.bench, bench_file, self.ports, seed=seed)
            self.surroundings = Surroundings(
                self.bench, bench_file, self._group, self.machines, self.far_ends, seed=seed
            )
            undo.callback(self.surroundings.close)
            for name in self.machines:
                self._listen_to(name)
            self._declare_nets()
            self.stimuli = Stimuli(self.bench, bench_file, self.machines, self.far_ends)
            for stimulus in bench_file.stimuli:
                self.stimuli.add(stimulus)
            self._closing = undo.pop_all()

    def notes(self) -> list[dict[str, object]]:
        """Return what the firmware touched that is not modelled, or got wrong, in order of bench time."""
        return self._notes

    def noted(self) -> list[dict[str, object]]:
        """Return `notes`, with resets that came from within, faults, and how firmware came to its end; each once."""
        ended = [] if self.end is None or self.end.good else [_entry_of(self.end)]
        return [*self._notes, *self._happened.values(), *ended]

    def lacking(self, name: str) -> str:
        """Return on what that is not modelled the program of a board waits, for people; empty: on nothing of the kind.

        It waits if it polls nothing else and has written no register of a peripheral since it was first seen to, unless
        that was after it was spoken to last and it had said something in between: what it said may be what is wrong. Of
        several boards only those count that were spoken to, if any was.
        """
        self._see_lack(name)
        lack = self._lacks.get(name)
        if lack is None or (self._heard_ns and name not in self._heard_ns):
            return ""
        heard_ns, said = self._heard_ns.get(name, 0), self._said.get(name)
        answered = said is not None and said.start_ns > heard_ns  # what goes out during the wait was written before it
        return "" if answered and lack.since_ns > heard_ns else lack.text

    def _heard(self, name: str, _data: bytes, at_ns: int) -> None:
        self._heard_ns[name] = at_ns

    def _say(self, name: str, frame: SerialFrame) -> None:
        self._said[name] = frame

    def _see_lack(self, name: str) -> None:
        machine, lack = self.machines[name], self._lacks.get(name)
        if lack is not None and lack.writes != machine.writes:
            lack = None
        loop = machine.waits_in
        absent = [_absent_at(machine, address) for address in loop.polled] if loop is not None else []
        if machine.asleep is not None or machine.ended is not None or (loop is not None and not all(absent or [""])):
            lack = None
        elif lack is None and absent:
            lack = _Lack(machine.now_ns, machine.writes, f"{name} {self.waiting(name)}; {absent[0]}")
        self._lacks[name] = lack

    def waiting(self, name: str) -> str:
        """Return where the program of a board waits, sleeps or was when it was last looked at, for people; or ""."""
        machine = self.machines[name]
        if machine.asleep is not None:
            mode, pc = machine.asleep
            return f"sleeps in {machine.place(pc)}" + (f", in {mode} mode" if mode != "Sleep" else "")
        loop = machine.waits_in
        if loop is None:
            return self._running(machine, self._looks[name])
        registers = [_register_at(machine, address) for address in loop.polled]
        polls = f", polling {', '.join(registers)}" if registers else ""
        return f"waits in {machine.place(loop.pc)}{polls}"

    @staticmethod
    def _running(machine: Machine, looks: Sequence[int]) -> str:
        """Return in which functions a program was that neither waits nor sleeps: most often, at the ends of steps."""
        if not looks:
            return ""
        (first, count), *more = Counter(map(machine.function, looks)).most_common(_FUNCTIONS_NAMED)
        others = "".join(f", {function} ({times})" for function, times in more)
        looked = f"{len(looks)} look{'s' if len(looks) > 1 else ''} at its program counter"
        return f"runs in {first} ({count} of {looked}){others}"

    def _look(self, reached_ns: int) -> None:
        if reached_ns < self._next_look_ns:
            return
        self._next_look_ns = reached_ns + _LOOK_NS
        for name, machine in self.machines.items():
            self._see_lack(name)
            if machine.asleep is None and machine.waits_in is None:
                self._looks[name].append(machine.pc)
            else:
                self._looks[name].clear()

    def starting(self, name: str) -> Mapping[str, int]:
        """Return when the oscillators of a board that start at present will be ready, by name, in ns of bench time."""
        return {clock: ceil(ready_s * NS_PER_S) for clock, ready_s in self.machines[name].chip.starting.items()}

    def pass_over_sleep(self) -> None:
        """Let more time pass at once while all programs sleep; for who looks at nothing but the end."""
        self._group.asleep_step_ns = _ASLEEP_STEP_NS

    def write_journal(self, path: Path, max_bytes: int | None = None) -> None:
        """Write the journal to a file from now on, with what has happened so far; see `Journal` for `max_bytes`.

        Raises:
            UsageError: the path holds something else.
            UnavailableError: the file cannot be written.
        """
        self.bench.journal = Journal(path, self._header(), max_bytes=max_bytes, after=self.bench.journal)

    def close(self) -> None:
        """End journal and waveforms."""
        for action in [log.flush for log in self._byte_logs] + self.at_close:
            action()
        self._group.stop()
        self._closing.close()

    # --- parts

    def _header(self) -> dict[str, object]:
        images = {name: {"format": image.format, "sha256": image.digest} for name, image in self.images.items()}
        return self.bench_file.header(self._seed) | {"images": images}

    def _make_machines(self, make_machine: MachineFactory) -> dict[str, Machine]:
        try:
            return {name: make_machine(self.bench_file.boards[name], image) for name, image in self.images.items()}
        except McuError as error:
            raise translated(error) from error

    def _make_ports(self) -> Iterator[tuple[str, UsartPort]]:
        own = {end: link.baud for link in self.bench_file.links for end in link.ends}
        for name, machine in self.machines.items():
            for usart in self.bench_file.boards[name].board.variant.usarts:
                full = f"{name}.{usart.lower()}"
                port = UsartPort(
                    self.bench, self._group, machine, machine.chip.usarts[usart], full, baud=own.get(full, 0)
                )
                port.reacts = False
                yield full, port

    def _wire(self) -> None:
        nets = Nets()
        try:
            for net in self.bench_file.nets:
                pins = self._pins_of(net)
                if len(pins) > 1:
                    nets.wire(str(net), *pins)
                for supply in net.supplies if pins else ():
                    pins[0].drive(supply == "3v3")
        except McuError as error:
            raise translated(error) from error

    def _pins_of(self, net: Net) -> list[Pin]:
        return [self.machines[end.board].chip.pins[end.pin] for end in net.pins]

    def _join_lines(self) -> None:
        for link in self.bench_file.links:
            ends = [self.ports[end] for end in link.ends if end in self.ports]
            if len(ends) == 2:
                ends[0].join(ends[1])
                for end in ends:
                    end.on_follow = self._set_turn
        self._set_turn()

    def _set_turn(self) -> None:
        """Let no board be further ahead of another than what they tell each other allows."""
        nets = ({pin.board for pin in net.pins} for net in self.bench_file.nets)
        lines = [self._frame_ns(link) for link in self.bench_file.links if self._joins_boards(link)]
        wires = [self.bench_file.lockstep_ns for boards in nets if len(boards) > 1]
        self._group.turn_ns = min([self._step_ns, *lines, *wires])

    def _joins_boards(self, link: Link) -> bool:
        return len({end.partition(".")[0] for end in link.ends if end in self.ports}) > 1

    def _frame_ns(self, link: Link) -> int:
        """Return how long the shortest frame on a line lasts, without its stop bit and with some allowance."""
        rates = [self.ports[end].usart_baud_hz for end in link.ends]
        if not all(rates):
            return self.bench_file.lockstep_ns  # the first frame comes one idle frame after the rate is set
        return int(_FRAME_BITS * NS_PER_S / max(rates))

    # --- what is recorded

    def _listen_to(self, name: str) -> None:
        machine = self.machines[name]
        machine.on_console = partial(self._console, name)
        machine.on_reset = partial(self._reset, name)
        machine.on_fault = partial(self._fault, name)
        machine.notes.on_note = partial(self._note, name)
        for text in self.images[name].notes:
            about = {"kind": "image", "where": self.images[name].path.name, "text": text}
            self._record_note(name, Note(**about, pc=None, cycle=0, ns=self.bench.now_ns))
        for note in machine.notes.all:
            self._record_note(name, note)
        waveforms = self._waveforms
        scope = f"{name}.pins"
        if waveforms is not None:
            for pin in machine.chip.pins:
                if pin.bonded:
                    waveforms.declare(scope, [pin.name], pin.level)
        pin_log = PinLog(
            self.bench,
            self._group,
            name,
            machine.chip.pins,
            everything=None if waveforms is None else partial(waveforms.edges, scope),
        )
        for full, port in self.ports.items():
            if full.startswith(f"{name}."):
                self._record_line(full, port)
                signal = f"{full.partition('.')[2].upper()}_TX"
                port.frame_taps.append(partial(self._frame_at_pin, name, signal, pin_log))
        if waveforms is not None:
            self._draw_buses(name, waveforms)
            self._group.after_round.append(waveforms.write_to)

    def _draw_buses(self, name: str, waveforms: Waveforms) -> None:
        for interface, i2c in self.machines[name].chip.i2cs.items():
            scope = f"{name}.{interface.lower()}"
            waveforms.declare(scope, ["scl", "sda"], initial=True)
            i2c.draw(partial(waveforms.level, scope))
            waveforms.late.append(i2c.undrawn_ns)

    def _record_line(self, full: str, port: UsartPort) -> None:
        sent, heard = ByteLog(self.bench, "tx", full), ByteLog(self.bench, "rx", full)
        self._byte_logs += [sent, heard]
        port.taps.append(sent.add)
        waveforms = self._waveforms
        if waveforms is not None:
            waveforms.declare(full, ["tx", "rx"], initial=True)
            port.each_frame = True
            port.frame_taps.append(partial(waveforms.frame, full, "tx"))

        def take(words: Words, at_ns: int) -> None:
            form = port.line_format
            data = bytes(form.value(bits) & 0xFF for bits in words.bits)
            heard.add(data, at_ns)
            for tap in port.heard_taps:
                self._group.output(at_ns, partial(tap, data, at_ns), source=full, reacts=False)
            if waveforms is not None:
                for frame in words.frames():
                    waveforms.frame(full, "rx", frame)

        port.on_heard = take

    def _frame_at_pin(self, name: str, signal: str, pin_log: PinLog, frame: SerialFrame) -> None:
        """Take a frame that begins now, with the pin that carries it, if there is one."""
        machine = self.machines[name]
        pin = machine.chip.signals.route_of(signal)
        if pin is None or not machine.chip.pins[pin].alternate:
            return
        if not self._edges_of_frames:
            pin_log.leave_out(pin, frame)
        lockstep_ns = self.bench_file.lockstep_ns
        if f"{name}.{pin}" in self._far_wired and frame.bit_s * NS_PER_S < _LOCKSTEPS_PER_BIT * lockstep_ns:
            text = f"edges on a wire to another board come up to {lockstep_ns // 1000} us late, too late for this rate"
            machine.notes.add("assumed", f"{pin}.{signal}", f"{text}; join serial lines with [[links]]")

    def _declare_nets(self) -> None:
        if self._waveforms is not None:
            for net in self.bench_file.nets:
                if not net.pins:
                    continue
                end = net.pins[0]
                level = self.machines[end.board].chip.pins[end.pin].level
                self._waveforms.declare_net(str(net), f"{end.board}.pins", end.pin, level)

    def _close_waveforms(self) -> None:
        assert self._waveforms is not None
        self._waveforms.close(self.bench.now_ns)

    def _output(self, name: str, action: Callable[[], None]) -> None:
        now_ns = max(self.machines[name].now_ns, self.bench.now_ns)
        self._group.output(now_ns, action, order=EventClass.CONTROL, source=name, reacts=False)

    def _console(self, name: str, data: bytes, channel: str) -> None:
        full = f"{name}.{channel}"
        if full not in self.consoles:
            log = ByteLog(self.bench, "console", full)
            self._byte_logs.append(log)
            self.consoles[full] = [log.add]
            self.on_console(full)
        now_ns = self.machines[name].now_ns
        for tap in self.consoles[full]:
            self._output(name, partial(tap, data, now_ns))

    def _reset(self, name: str, cause: str) -> None:
        if cause not in _FROM_OUTSIDE:
            self._happen(name, "reset", cause, cause)
        self._output(name, partial(self._record_reset, name, cause))

    def _record_reset(self, name: str, cause: str) -> None:
        if cause != "POR":  # that is how it begins
            resets = self.resets.setdefault((name, cause), Resets())
            resets.count, resets.last_ns = resets.count + 1, self.bench.now_ns
        self.bench.record("reset", name, reason=cause)

    def _fault(self, name: str, fault: Fault) -> None:
        self._happen(name, "fault", " ".join(fault.causes), fault.describe(), self.machines[name].place(fault.pc))

    def _happen(self, name: str, kind: str, cause: str, text: str, at: str = "") -> None:
        about = {"board": name, "ns": self.machines[name].now_ns, "kind": kind, "where": kind, "text": text, "at": at}
        self._happened.setdefault((name, kind, cause), about)  # a probe of memory has hundreds of one cause

    def _note(self, name: str, note: Note) -> None:
        self._output(name, lambda: self._record_note(name, note))

    def _record_note(self, name: str, note: Note) -> None:
        place = "" if note.pc is None else self.machines[name].place(note.pc)
        about = {"kind": note.kind, "where": note.where, "text": note.text, "at": place}
        self._notes.append({"board": name, "ns": note.ns, **about})
        self.bench.record("note", name, note=note.kind, where=note.where, text=note.text, at=place)

    def _ended(self, name: str, ending: Ending) -> None:
        end = End(
            board=name,
            kind=ending.kind,
            status=ending.status,
            ns=ending.ns,
            pc=ending.pc,
            place=ending.place,
            cause=ending.cause,
        )
        self.end = end
        self.bench.record("end", name, reason=end.kind, status=end.status, pc=end.pc, at=end.place, cause=end.cause)


def _entry_of(end: End) -> dict[str, object]:
    about = {"kind": end.kind, "where": end.kind, "text": end.cause.removeprefix(f"{end.kind}: "), "at": end.place}
    return {"board": end.board, "ns": end.ns, **about}


def _part_at(machine: Machine, address: int) -> tuple[Peripheral | None, Register | None]:
    parts = [part for part in machine.chip.blocks if part.base <= address < part.base + part.size]
    for part in parts:  # several at the addresses of the system control space
        register = part.registers.get(address - part.base & ~3)
        if register is not None:
            return part, register
    return parts[0] if parts else None, None


def _register_at(machine: Machine, address: int) -> str:
    part, register = _part_at(machine, address)
    return f"0x{address:08X}" if part is None or register is None else f"{part.name}_{register.name}"


def _board_of(full: str) -> str:
    return full.partition(".")[0]


def _absent_at(machine: Machine, address: int) -> str:
    """Return why a register that is polled never says what is waited for, if that is because we lack it.

    A block whose clock is off answers nothing anywhere: that is none of these.
    """
    part, register = _part_at(machine, address)
    if part is None or not part.clocked:
        return ""
    there = [register] if register is not None else [*part.registers.values()]  # a block that is absent lacks some
    lacks = bool(there) and all(one.fidelity is Fidelity.ABSENT for one in there)
    return (there[0].note or f"{part.name} is not modelled") if lacks else ""
