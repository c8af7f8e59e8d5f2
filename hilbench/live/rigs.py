"""What stands on a live bench: the target of a bench file, and one of our own clients at the end of its line."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from hilbench.bench import Bench
from hilbench.bench_file import BenchFile, ModelTarget
from hilbench.errors import UnavailableError, UsageError
from hilbench.links import DEFAULT_BAUD, Line, MemoryLink, Port, ReconnectingPort, parse_serial_target
from hilbench.links.memory import REAL_TIME_GROUP_NS
from hilbench.live.about import about_boards, about_line, about_world
from hilbench.live.driver import Drives
from hilbench.live.operators import Operator
from hilbench.live.resuming import resume_sessions
from hilbench.live.scenes import on_board
from hilbench.live.tap import Tap
from hilbench.live.teller import Observed, Sense, Senses, describe_machine
from hilbench.model_kinds import board_protocol
from hilbench.options import TargetChoice
from hilbench.systems.pioneer.about import about_sonars
from hilbench.systems.rover.about import about_pkt
from hilbench.target import TargetKind, target_of
from targets.robots.pioneer import RobotSettings
from worlds.errors import WorldError

if TYPE_CHECKING:
    from hilbench.mcu.emulated import EmulatedBench
    from hilbench.plugins.protocol import Device, ProtocolPlugin
    from hilbench.systems.pioneer.operator import PioneerOperator
    from hilbench.systems.rover.operator import RoverOperator
    from hilbench.systems.vehicle.live import LiveVehicle

__all__ = ["Rig", "open_attached", "open_rig", "ports_asked"]


_ROVER_BAUD = 115_200
"""As `hilbench.systems.rover.provider.AttachedRoverProvider.USUAL_BAUD`."""


_CLIENT = "client"
"""The source in the journal of the host that a plug-in brings."""

_SENSES = {"KEEPALIVE": Sense.REST}
"""Our clients speak when this one runs out, which is what it is for."""


@dataclass(slots=True, kw_only=True)
class Rig:
    """A target and who speaks to it.

    Attributes:
        operator: one of our clients; None if no line of the bench leads to one, or several are driven together.
        taps: our ends of the lines, by their names.
        machines: the state machines that can be looked at, by their source in the journal.
        senses: what the ends of their timers mean.
        views: what else can be looked at, see `hilbench.live.teller.Teller`.
        about: what the header of the journal says for those who show it.
        drive: begins to drive, the demo driver first or not; None where a `Driver` with the operator does, or nobody.
        demo: whether the demo driver may drive it.
        reset: presses the reset button; None where there is none.
        ended: says why the target will never go on; empty while it does.
        close: gives everything back.
    """

    operator: Operator | None = None
    taps: Mapping[str, Tap] = field(default_factory=dict)
    machines: Mapping[str, Observed]
    senses: Senses = field(default_factory=dict)
    views: Mapping[str, Callable[[], Mapping[str, object]]] = field(default_factory=dict)
    about: Mapping[str, Any] = field(default_factory=dict)
    demo: bool = True
    drive: Callable[[bool], Drives] | None = None
    reset: Callable[[], None] | None = None
    ended: Callable[[], str] = lambda: ""
    close: Callable[[], None] = lambda: None


def open_rig(bench: Bench, bench_file: BenchFile, *, seed: int) -> Rig:
    """Build the target of a bench file, and a client for it.

    Raises:
        UnavailableError: physics, engine or an image is missing.
        UsageError: the bench file does not fit together.
    """
    if bench_file.boards:
        return _boards(bench, bench_file, seed)
    if bench_file.rover is not None:
        return _rover_model(bench, bench_file, seed)
    if bench_file.vehicle is not None:
        return _vehicle_model(bench, bench_file, seed)
    if bench_file.plugged_in is not None:
        return _plugged_in(bench, bench_file, bench_file.plugged_in, seed)
    if not any(isinstance(target.settings, RobotSettings) for target in bench_file.targets.values()):
        raise UsageError("the dashboard has no view of this model yet", where=bench_file.name)
    return _pioneer(bench, bench_file, seed)


def open_attached(bench: Bench, bench_file: BenchFile, targets: Sequence[TargetChoice], *, seed: int) -> Rig:
    """Attach to what somebody else runs at serial ports or behind pyserial URLs; nobody drives it unasked.

    Args:
        bench: whose time passes.
        bench_file: says which protocol is spoken, and on which lines.
        targets: as ``serial:/dev/ttyACM0@115200``; one for each line, by its name where there are several.
        seed: decides what chance decides in faults.

    Raises:
        UsageError: a target is no serial port, a line has none, or the bench has no line that a client of ours could
            speak on.
        UnavailableError: a port cannot be opened.
    """
    ports = ports_asked(bench_file, targets)
    if len(ports) > 1:
        return _attached_vehicle(bench, bench_file, ports, seed)
    target = ports[""]
    protocol = _protocol_of(bench_file)
    if protocol is not None:
        port = _at(bench, bench_file, target, protocol.baud)
        tap = Tap(bench, port, _CLIENT, seed=seed)  # and no host: it would speak, and move something, unasked
        return Rig(
            taps=_host(tap), machines={}, about=about_line(_CLIENT, protocol.name, {}), demo=False, close=port.close
        )
    operator: Operator
    if bench_file.rover is not None or board_protocol(bench_file.suites) == "PKT!":
        port = _at(bench, bench_file, target, _ROVER_BAUD)
        profile = "documented" if bench_file.rover is None else bench_file.rover.profile
        tap, operator = _station(bench, port, profile, seed)
        about = about_pkt(operator.name, {operator.name: operator.observed}, profile)
    else:
        port = _at(bench, bench_file, target, DEFAULT_BAUD)
        tap, operator = _client(bench, port, seed)
        about = about_line(operator.name, "p2os", {operator.name: operator.observed})
    resume_sessions(tap, operator)
    return Rig(
        operator=operator,
        taps=_host(tap),
        machines={operator.name: operator.observed},
        senses={operator.name: _SENSES},
        about=about,
        demo=False,
        close=port.close,
    )


def ports_asked(bench_file: BenchFile, targets: Sequence[TargetChoice]) -> Mapping[str, str]:
    """Return what is asked for at the far end of each line of ours, by its name; of a line without one, by nothing.

    Raises:
        UsageError: a target is no serial port, a line has none, or two.
    """
    for choice in targets:
        if target_of(choice).kind is not TargetKind.SERIAL:
            hint = "write serial:/dev/ttyUSB0@115200 or a pyserial URL"
            raise UsageError("is no serial port", where=choice.where, hint=hint)
    known = _protocol_of(bench_file)
    protocol = "CARLA" if on_board(bench_file) else board_protocol(bench_file.suites)
    if bench_file.boards and not protocol and known is None:
        where = f"bench '{bench_file.name}'"
        raise UsageError("no client of ours speaks to its boards", where=where, hint="leave --target away")
    if not bench_file.boards and bench_file.vehicle is None and bench_file.rover is None and known is None:
        bench_file.pioneer()
    if bench_file.vehicle is not None or protocol == "CARLA":
        from hilbench.checker_lines import ports_of_lines
        from hilbench.systems.vehicle.live import SIMULATOR, STACK
        from hilbench.systems.vehicle.provider import vehicle_lines

        lines = vehicle_lines(bench_file)
        specs = ports_of_lines(lines, targets)
        return {name: specs[line] for name, line in zip((SIMULATOR, STACK), lines, strict=True)}
    first, *more = targets
    if more or first.name:
        where = " ".join(choice.where for choice in targets)
        raise UsageError("this bench has one line, without a name", where=where, hint=f"write --target {first.spec}")
    return {"": first.spec}


def _protocol_of(bench_file: BenchFile) -> ProtocolPlugin | None:
    """Return what a bench file says is spoken on the checker's line; None where hilbench's own clients know it."""
    there = bench_file.plugged_in
    if there is not None:
        return there.protocol
    return bench_file.protocols.get(bench_file.checker_lines.get("", ""))


def _host_of(bench: Bench, port: Port, protocol: ProtocolPlugin, seed: int) -> tuple[Tap, Mapping[str, Observed]]:
    """Put the host of a plug-in at the end of a line; where it brings none, the line is listened to."""
    from hilbench.devices import DeviceActor
    from hilbench.protocol_bench.cases import machines_of

    tap = Tap(bench, port, _CLIENT, seed=seed)
    if protocol.host is None:
        return tap, {}
    host = protocol.host.make(protocol.host.settings())
    DeviceActor(bench, host, tap, name=_CLIENT)
    return tap, machines_of({_CLIENT: host})


def _plugged_in(bench: Bench, bench_file: BenchFile, target: ModelTarget, seed: int) -> Rig:
    from hilbench.devices import DeviceActor
    from hilbench.protocol_bench.cases import DEVICE, device_baud, machines_of

    protocol = target.protocol
    assert protocol is not None
    assert protocol.device is not None
    line = Line(baud=device_baud(bench_file, protocol))
    link = MemoryLink(bench.scheduler, line, name="host", group_ns=REAL_TIME_GROUP_NS)
    device = protocol.device.make(target.settings)
    DeviceActor(bench, device, link.b, name=DEVICE)
    tap, machines = _host_of(bench, link.a, protocol, seed)
    machines = {**machines, **machines_of({DEVICE: device})}
    senses = _senses({_CLIENT: protocol.host, DEVICE: protocol.device})
    about = about_line(_CLIENT, protocol.name, machines)
    return Rig(taps=_host(tap), machines=machines, senses=senses, about=about)


def _senses(devices: Mapping[str, Device | None]) -> Senses:
    return {name: dict.fromkeys(one.resting, Sense.REST) for name, one in devices.items() if one is not None}


def _attached_vehicle(bench: Bench, bench_file: BenchFile, specs: Mapping[str, str], seed: int) -> Rig:
    from hilbench.systems.vehicle.live import attached_vehicle
    from protocols.carla import BAUD

    with contextlib.ExitStack() as undo:
        ports: dict[str, Port] = {}
        for name, spec in specs.items():
            ports[name] = _at(bench, bench_file, spec, BAUD)
            undo.callback(ports[name].close)
        vehicle, world = attached_vehicle(bench, ports, seed=seed)
        undo.callback(world.close)
        close = undo.pop_all().close
    return _vehicle(vehicle, demo=False, close=close)


def _at(bench: Bench, bench_file: BenchFile, target: str, usual_baud: int) -> ReconnectingPort:
    serial = parse_serial_target(target, usual_baud, bench_file.port.settings)
    return ReconnectingPort(bench.scheduler, serial, record=bench.record)


def _pioneer(bench: Bench, bench_file: BenchFile, seed: int) -> Rig:
    from hilbench.systems.pioneer.robot import VirtualPioneer, plan_of

    plan = plan_of(bench_file)
    link = MemoryLink(bench.scheduler, Line(baud=plan.settings.host_baud), name="host", group_ns=REAL_TIME_GROUP_NS)
    try:
        pioneer = VirtualPioneer(bench, link.b, plan, seed=seed)
    except WorldError as error:
        raise UnavailableError(str(error), where=f"scene {plan.scene}") from error
    tap, operator = _client(bench, link.a, seed)
    machines = {"client": operator.observed, "robot": pioneer.robot.connection}
    about = (
        about_line(operator.name, "p2os", machines) | about_sonars(plan.settings.subclass) | about_world(pioneer.world)
    )
    return Rig(
        operator=operator,
        taps=_host(tap),
        machines=machines,
        senses={operator.name: _SENSES},
        about=about,
        close=pioneer.close,
    )


def _rover_model(bench: Bench, bench_file: BenchFile, seed: int) -> Rig:
    from hilbench.devices import DeviceActor
    from hilbench.systems.rover.cases import rover_baud
    from targets.robots.rover import RoverRobot

    settings = bench_file.rover
    assert settings is not None
    link = MemoryLink(bench.scheduler, Line(baud=rover_baud(bench_file)), name="host", group_ns=REAL_TIME_GROUP_NS)
    robot = RoverRobot(settings)
    DeviceActor(bench, robot, link.b, name="rover")
    tap, operator = _station(bench, link.a, settings.profile, seed)
    machines = {"station": operator.observed, "rover": robot.connection}
    return Rig(
        operator=operator,
        taps=_host(tap),
        machines=machines,
        senses={operator.name: _SENSES},
        about=about_pkt(operator.name, machines, settings.profile),
    )


def _boards(bench: Bench, bench_file: BenchFile, seed: int) -> Rig:
    from hilbench.mcu.emulated import EmulatedBench
    from hilbench.mcu.group import LOCKED_STEP_NS

    emulated = EmulatedBench(bench_file, seed=seed, step_ns=LOCKED_STEP_NS, bench=bench)
    with contextlib.ExitStack() as undo:
        undo.callback(emulated.close)
        vehicle = _vehicle_on_board(emulated, seed)
        if vehicle is not None:
            undo.pop_all()
            return _of_vehicle(vehicle, emulated)
        about: dict[str, Any] = {"boards": about_boards(bench_file.boards), **about_world(emulated.surroundings.world)}
        tap, operator = None, None
        machines: Mapping[str, Observed] = {}
        senses: Senses = {}
        far_end = bench_file.checker_lines.get("", "")
        if far_end in emulated.ports and "pkt-board" in bench_file.suites:
            emulated.ports[far_end].reacts = True
            tap, operator = _station(bench, emulated.ports[far_end], "documented", seed)
            machines = {"station": operator.observed}
            about |= about_pkt(operator.name, machines, "documented")
        elif far_end in bench_file.protocols:
            emulated.ports[far_end].reacts = True
            protocol = bench_file.protocols[far_end]
            tap, machines = _host_of(bench, emulated.ports[far_end], protocol, seed)
            about |= about_line(_CLIENT, protocol.name, machines)
            senses = _senses({_CLIENT: protocol.host})
        if emulated.surroundings.robot is not None:
            machines = {**machines, "robot": emulated.surroundings.robot.robot.connection}
            about["machines"] = {name: describe_machine(one) for name, one in machines.items()}
        undo.pop_all()
    return Rig(
        operator=operator,
        taps=_host(tap),
        machines=machines,
        senses=senses if operator is None else {operator.name: _SENSES},
        views=_analog(emulated),
        about=about,
        reset=lambda: _reset(emulated),
        ended=lambda: "" if emulated.end is None else str(emulated.end),
        close=emulated.close,
    )


def _vehicle_model(bench: Bench, bench_file: BenchFile, seed: int) -> Rig:
    from hilbench.systems.vehicle.live import model_vehicle

    vehicle, hands, world = model_vehicle(bench, bench_file, seed=seed)
    return _vehicle(vehicle, reset=hands.reset, close=world.close)


def _vehicle_on_board(emulated: EmulatedBench, seed: int) -> LiveVehicle | None:
    """Return the peers of a vehicle interface's firmware; None if the bench has none, or no car for it."""
    if not on_board(emulated.bench_file):
        return None
    from hilbench.systems.vehicle.live import board_vehicle

    return board_vehicle(emulated, seed=seed)


def _of_vehicle(vehicle: LiveVehicle, emulated: EmulatedBench) -> Rig:
    return _vehicle(
        vehicle,
        views=_analog(emulated),
        about={"boards": about_boards(emulated.bench_file.boards)},
        reset=lambda: _reset(emulated),
        ended=lambda: "" if emulated.end is None else str(emulated.end),
        close=emulated.close,
    )


def _vehicle(
    vehicle: LiveVehicle,
    *,
    about: Mapping[str, Any] = MappingProxyType({}),
    views: Mapping[str, Callable[[], Mapping[str, object]]] = MappingProxyType({}),
    **more: Any,
) -> Rig:
    return Rig(
        taps=vehicle.taps,
        machines=vehicle.machines,
        senses=vehicle.senses,
        views={"vehicle": vehicle.look, **views},
        about={**about, **vehicle.about},
        drive=vehicle.drive,
        **more,
    )


def _host(tap: Tap | None) -> Mapping[str, Tap]:
    return {} if tap is None else {"host": tap}


def _client(bench: Bench, port: Port, seed: int) -> tuple[Tap, PioneerOperator]:
    from hilbench.systems.pioneer.client import P2osClient
    from hilbench.systems.pioneer.operator import PioneerOperator

    tap = Tap(bench, port, "client", seed=seed)
    return tap, PioneerOperator(bench, P2osClient(bench, tap))


def _station(bench: Bench, port: Port, profile: str, seed: int) -> tuple[Tap, RoverOperator]:
    from hilbench.systems.rover.ground_station import GroundStation
    from hilbench.systems.rover.operator import RoverOperator
    from protocols.pkt import PROFILES

    tap = Tap(bench, port, "station", seed=seed)
    return tap, RoverOperator(bench, GroundStation(bench, tap, PROFILES[profile]))


def _analog(emulated: EmulatedBench) -> Mapping[str, Callable[[], Mapping[str, object]]]:
    """Return the view of what parts put on analog pins; none where no part does."""
    parts = emulated.surroundings.parts
    full_v = {name: machine.chip.pins.vdd_volts for name, machine in emulated.machines.items()}

    def look() -> Mapping[str, object]:
        return {"pins": {pin: [round(v, 4), full_v[pin.partition(".")[0]]] for pin, v in parts.volts().items()}}

    return {"volts": look} if parts.volts() else {}


def _reset(emulated: EmulatedBench) -> None:
    for machine in emulated.machines.values():
        machine.reset()
