"""Writes the pages of the documentation that are made from the code, or checks that they are up to date.

``python docs/generate.py`` writes them; with ``--check`` it writes nothing and exits 1 if a page differs.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import autoware_pages
import carla_pages
import manual_page
import reference_pages
import xrce_pages

from hilbench.check.catalogue import Clause
from hilbench.mcu.ledger import LedgerPeripheral, ledger_of
from hilbench.plugins.discovery import PLUGINS
from hilbench.systems.bluepill import dodge_clauses as _dodge_clauses
from hilbench.systems.bluepill import pins_clauses as _bluepill_clauses
from hilbench.systems.rover import motion_clauses as _rover_motion_clauses
from hilbench.systems.vehicle import drive_clauses as _vehicle_drive_clauses
from protocols.p2os.clauses import CLAUSES
from protocols.p2os.command_table import COMMANDS
from protocols.p2os.states import CLIENT_TABLE, SERVER_TABLE, State, Table
from protocols.pkt import commands as pkt_commands
from protocols.pkt import profiles as pkt_profiles
from protocols.pkt import reports as pkt_reports
from protocols.pkt import states as pkt_states
from protocols.pkt.clauses import CLAUSES as PKT_CLAUSES
from protocols.pkt.clauses import Clause as PktClause
from protocols.pkt.framing import encode_frame
from protocols.pkt.options import Framing, FramingOptions, Schema
from targets.mcu.fidelity import Fidelity
from targets.parts import PARTS, Direction, Part, Quantity, part_class
from targets.parts import settings as part_settings
from targets.robots.pioneer.ledger import LEDGER
from targets.robots.pioneer.settings import RobotSettings, describe
from targets.robots.rover import DEFECTS, STEADY_RPM, RoverSettings
from worlds.vehicles.pioneer_2dx import vehicle

FOLDER = Path(__file__).parent
CHIPS = {
    "mcu-registers.md": "STM32F103C8",
    "mcu-registers-f103ze.md": "STM32F103ZE",
    "mcu-registers-f100rb.md": "STM32F100RB",
    "mcu-registers-f100ze.md": "STM32F100ZE",
    "mcu-registers-f767.md": "STM32F767ZI",
    "mcu-registers-h753.md": "STM32H753ZI",
}
MANY_NAMES = 8
MADE = "Made from the code by docs/generate.py; change the code, then run `make docs`."
NOTES = {".md": f"<!-- {MADE} -->\n\n", ".1": f'.\\" {MADE}\n'}


def pages() -> Mapping[str, str]:
    """Return every generated page: file name below ``docs`` to text."""
    return {
        "p2os/states.md": states_page(),
        "p2os/commands.md": commands_page(),
        "p2os/clauses.md": clauses_page(),
        "pkt/states.md": pkt_states_page(),
        "pkt/messages.md": pkt_messages_page(),
        "pkt/frames.md": pkt_frames_page(),
        "pkt/clauses.md": pkt_clauses_page(),
        "autoware/messages.md": autoware_pages.messages_page(_table),
        "autoware/stand-in-link.md": autoware_pages.stand_in_page(_table, _machine),
        "carla/states.md": carla_pages.states_page(_table, _machine),
        "carla/frames.md": carla_pages.frames_page(_table),
        "carla/clauses.md": carla_pages.clauses_page(_table),
        "xrce/states.md": xrce_pages.states_page(_machine),
        "xrce/submessages.md": xrce_pages.submessages_page(_table),
        "xrce/clauses.md": xrce_pages.clauses_page(_suites),
        "fidelity.md": fidelity_page(),
        **{page: registers_page(chip) for page, chip in CHIPS.items()},
        "bluepill-clauses.md": bluepill_page(),
        "rover-clauses.md": rover_page(),
        "vehicle-drive-clauses.md": vehicle_drive_page(),
        "rover-model.md": rover_model_page(),
        "parts.md": parts_page(),
        "vehicles.md": vehicles_page(),
        "reference/command-line.md": reference_pages.command_line_page(_table),
        "reference/bench-file.md": reference_pages.bench_file_page(_table),
        "hilbench.1": manual_page.manual_page(),
    }


def states_page() -> str:
    """The state machines of both roles, as diagrams and as tables."""
    return (
        "# The state machines of P2OS\n\n"
        "Both are data in `protocols/p2os/states.py`; these diagrams, the coverage figures and the generated "
        "mutants are made from it. A pair of state and trigger without an edge changes nothing and answers nothing.\n\n"
        + _machine("The server: the robot's controller", SERVER_TABLE)
        + "\n"
        + _machine("The client: the computer", CLIENT_TABLE)
    )


def _machine(title: str, table: Table) -> str:
    return f"## {title}\n\n{_diagram(table)}\n{_states(table)}\n{_edges(table)}"


def _diagram(table: Table) -> str:
    labels: dict[tuple[State, State], list[str]] = {}
    for (state, trigger), transition in table.items():
        labels.setdefault((state, transition.next_state), []).append(trigger.name)
    lines = [f"    {a.name} --> {b.name}: {', '.join(names)}" for (a, b), names in labels.items()]
    return "\n".join(["```mermaid", "stateDiagram-v2", f"    [*] --> {next(iter(table))[0].name}", *lines, "```", ""])


def _states(table: Table) -> str:
    kind = type(next(iter(table))[0])
    used = {state for state, _ in table} | {transition.next_state for transition in table.values()}
    return _table(("State", "Meaning"), [(f"`{state.name}`", state.value) for state in kind if state in used])


def _edges(table: Table) -> str:
    rows = [
        (
            f"`{state.name}`",
            f"`{trigger.name}`: {trigger.value}",
            "; ".join(action.value for action in transition.actions) or "nothing",
            f"`{transition.next_state.name}`",
        )
        for (state, trigger), transition in table.items()
    ]
    return _table(("State", "Trigger", "What is done", "Next"), rows)


def commands_page() -> str:
    """Every command of the protocol."""
    rows = [
        (str(int(spec.number)), spec.name, spec.argument.value, spec.unit or "", spec.since, spec.summary, spec.source)
        for spec in COMMANDS.values()
    ]
    head = ("#", "Name", "Argument", "Unit", "Since", "Meaning", "Source")
    return "# The commands of P2OS\n\nEvery command that the stack knows, with where the fact is written.\n\n" + _table(
        head, rows
    )


def clauses_page() -> str:
    """Every clause that the shipped suites check."""
    text = (
        "# What the shipped suites check\n\n"
        "A *must* that fails makes `hilbench check` exit 1; a *should* warns, and fails with `--strict`. A clause that "
        "needs something a bench does not have is not applicable there.\n\n"
    )
    for suite in dict.fromkeys(clause.suite for clause in CLAUSES):
        rows = [
            (clause.id, clause.level, clause.text, ", ".join(clause.needs), clause.source)
            for clause in CLAUSES
            if clause.suite == suite
        ]
        text += f"## {suite}: {len(rows)} clauses\n\n" + _table(("Id", "Level", "Text", "Needs", "Source"), rows) + "\n"
    return text


def pkt_states_page() -> str:
    """The decoder's two machines and those of both roles."""
    return (
        "# The state machines of PKT!\n\n"
        "All are data in `protocols/pkt/states.py`. A pair of state and trigger without an edge changes nothing. The "
        "decoders are those of the firmware and of the seed document; `frame_table` makes those that resynchronise.\n\n"
        + _machine("The decoder with a length byte (all firmware)", pkt_states.LEN_TABLE)
        + "\n"
        + _machine("The decoder without one (the seed document)", pkt_states.TERM_TABLE)
        + "\n"
        + _machine("The server: the rover", pkt_states.SERVER_TABLE)
        + "\n"
        + _machine("The client: the ground station", pkt_states.CLIENT_TABLE)
    )


def pkt_messages_page() -> str:
    """Every command and report in every schema."""
    text = (
        "# What is said in PKT!\n\n"
        "A payload is one byte, the opcode or the id of the report, and what the tables have. Offsets follow from the "
        "order; floats have 32 bits.\n"
    )
    for schema in Schema:
        commands = [
            (f"`{spec.opcode:02X}`", spec.name, str(1 + spec.size), spec.text, spec.source)
            for spec in pkt_commands.COMMANDS[schema].values()
        ]
        reports = [
            (f"`{spec.report:02X}`", spec.kind.__name__, str(spec.size), spec.text, spec.source)
            for spec in pkt_reports.REPORTS[schema]
        ]
        text += f"\n## Schema {schema.name}: {schema.value}\n\n"
        text += _table(("Opcode", "Command", "Bytes", "Meaning and parameters", "Source"), commands) + "\n"
        text += _table(("Id", "Report", "Bytes", "Fields", "Source"), reports)
    return text


def pkt_frames_page() -> str:
    """Worked examples of frames, in both framings."""
    term = FramingOptions(framing=Framing.TERM)
    v1, v2 = Schema.V1, Schema.V2
    commands = [
        (pkt_commands.RequestTelemetry(), v1),
        (pkt_commands.LedOn(), v1),
        (pkt_commands.LedOff(), v1),
        (pkt_commands.MotorSpeeds(a=100, b=-100), v1),
        (pkt_commands.MotorThrottles(a=0.5, b=-0.25), v2),
        (pkt_commands.SpeedSetpoints(a_rpm=30.0, b_rpm=30.0), v2),
        (pkt_commands.PidGains(kp=0.01, kd=0.0001, ki=0.0001), v2),
    ]
    reports = [
        (pkt_reports.GeneralReport(), v2),
        (pkt_reports.GeneralReport(accepted=1, last_opcode=1, status=None), v1),
        (pkt_reports.ExecutionReport(opcode=1), v1),
        (pkt_reports.GpsReport(first_deg=-58.3683, second_deg=-34.6175), v2),
    ]
    messages = [(f"`{one}`", schema, pkt_commands.encode_command(one, schema)) for one, schema in commands]
    messages += [(f"`{one}`", schema, pkt_reports.encode_report(one, schema)) for one, schema in reports]
    rows = [
        (text, schema.name, f"`{_hex(encode_frame(payload))}`", f"`{_hex(encode_frame(payload, term))}`")
        for text, schema, payload in messages
    ]
    return (
        "# Frames of PKT!, worked out\n\n"
        "`PKT!`, the length (or none), the payload, the CRC-16/IBM-3740 of the payload with its high byte first, a "
        "newline. Without a length byte a newline in payload or CRC, `0A`, ends a frame too early.\n\n"
        + _table(("Message", "Schema", "With a length byte", "Without"), rows)
        + "\n## Profiles\n\n"
        + _table(("Name", "What it is"), [(one.name, one.text) for one in pkt_profiles.PROFILES.values()])
    )


def _hex(data: bytes) -> str:
    return data.hex(" ").upper()


def pkt_clauses_page() -> str:
    """Every clause of the rover's protocol, with its profiles."""
    text = (
        "# What a rover and its host must do\n\n"
        "A clause belongs to profiles: *documented* is what seed document and manual promise, *term-doc* the document "
        "to the letter, *g0* and *g2* what was shipped. Where shipped behaviour is a defect, its twin says what was "
        "promised. At a port nobody sees the motors: what needs `duty` is judged there by the throttles and setpoints "
        "that the rover shows in 0x83, if it does, and the verdict says *by its own report*. *By hand* somebody there "
        "does or sees what is needed, with `--operator`.\n\n"
    )
    for suite in dict.fromkeys(clause.suite for clause in PKT_CLAUSES):
        rows = [
            (one.id, one.level, ", ".join(one.profiles), one.text, one.twin or "", _needs(one), one.source)
            for one in PKT_CLAUSES
            if one.suite == suite
        ]
        head = ("Id", "Level", "Profiles", "Text", "Twin", "Needs", "Source")
        text += f"## {suite}: {len(rows)} clauses\n\n" + _table(head, rows) + "\n"
    return text


def _needs(clause: PktClause) -> str:
    """What a clause needs, and with what it can be judged by the rover's own reports, or somebody's hand, instead."""
    instead = f"; or {', '.join(clause.stand_ins)}, by its own report" if clause.stand_ins else ""
    return ", ".join(clause.needs) + instead + ("; by hand" if clause.by_hand else "")


def rover_model_page() -> str:
    """The behavioural rover: what it is set to, and the defects that can be put into it."""
    text = (
        "# The behavioural rover\n\n"
        "`hilbench check rover-model` and `hilbench serve rover-model` have a rover without a microcontroller: its "
        "control board as the host sees it, four wheels in the air, an IMU that lies level and still, a GPS receiver "
        'with a fix. In a bench file, `[targets.NAME]` with `model = "rover"`, and `[targets.NAME.settings]`:\n\n'
    )
    rows = [
        (item.name, _plain(item.default), item.metadata["unit"], item.metadata["source"])
        for item in dataclasses.fields(RoverSettings)
    ]
    text += _table(("Setting", "Default", "Unit", "Source"), rows)
    text += (
        "\n`profile` says what was promised or shipped ([pkt/frames.md](pkt/frames.md)), `defects` puts single defects "
        "of the published firmwares into it; which clauses find them: [rover-defects.md](rover-defects.md).\n\n"
    )
    text += _table(("Defect", "What it does", "Source"), [(one.name, one.text, one.source) for one in DEFECTS.values()])
    points = ", ".join(f"{rpm:g} rpm at {throttle:g}" for throttle, rpm in STEADY_RPM)
    return text + (
        f"\nThe wheels come to these steady speeds, with straight lines between them: {points}; the first and the last "
        "are assumed, the others those of the published bench test (nhorro/ceai2020, RoverBasicBenchTest.ipynb). They "
        "begin to turn at 0.23 and stop below 0.195.\n\n"
        "Not modelled: battery, currents, loads, the floor; noise of any sensor; a GPS receiver that looks for its "
        "satellites; the 0x85 report, which nothing asks for. The bench `rover` has all but the last.\n"
    )


def _plain(value: object) -> str:
    return "none" if value is None else ", ".join(map(str, value)) if isinstance(value, tuple) else str(value)


def bluepill_page() -> str:
    """Every clause of the suites for the Blue Pill at the robot's connector."""
    text = (
        "# What the suites of the Blue Pill bench check\n\n"
        "`hilbench check bluepill` runs both suites; [bluepill.md](bluepill.md) says what the bench is. G01 to G25 are "
        "the experiments of the bachelor's thesis, with figures; D01 to D07 say in figures what "
        "finding one's way is.\n\n"
    )
    return text + _suites([*_bluepill_clauses.CLAUSES, *_dodge_clauses.CLAUSES])


def rover_page() -> str:
    """Every clause about how the rover drives."""
    text = (
        "# What the suite of the rover's motion checks\n\n"
        "`hilbench check rover` runs it beside `pkt-board` ([pkt/clauses.md](pkt/clauses.md)): the documented program "
        "on an emulated board, with motors, tachometers, inertial sensor and GPS receiver around it. "
        "[rover-motion.md](rover-motion.md) has pictures of what R01 to R08 are about.\n\n"
    )
    return text + _suites(_rover_motion_clauses.CLAUSES)


def vehicle_drive_page() -> str:
    """Every clause about how a car drives through a vehicle-interface board."""
    text = (
        "# What the suite of the car's drives checks\n\n"
        "`hilbench check vehicle` runs it beside `vehicle-board` ([carla/clauses.md](carla/clauses.md)): the hardened "
        "program on an emulated board, a car on the test track, a driving stack that follows its lane. "
        "[vehicle-drive.md](vehicle-drive.md) has a lap and an emergency stop with their figures.\n\n"
    )
    return text + _suites(_vehicle_drive_clauses.CLAUSES)


def _suites(clauses: Sequence[Clause]) -> str:
    text = ""
    for suite in dict.fromkeys(clause.suite for clause in clauses):
        rows = [(clause.id, clause.level, clause.text, clause.source) for clause in clauses if clause.suite == suite]
        text += f"## {suite}: {len(rows)} clauses\n\n" + _table(("Id", "Level", "Text", "Source"), rows) + "\n"
    return text


def parts_page() -> str:
    """Every kind of part with what it is joined by and what can be set."""
    return (
        "# Parts: what stands between a board and the world\n\n"
        + _table(("Part", "What it is"), [(f"[{kind}](#{kind})", _idea(part_class(kind))) for kind in PARTS])
        + "\nA part of your own: [python/plugins.md](python/plugins.md#a-part).\n\n"
        "```toml\n"
        "# near.toml: PA8 is high while something is less than half a metre away, ahead and 10 degrees to the left\n"
        "version = 1\n\n"
        "[targets.brain]\n"
        'board = "bluepill"\n'
        'firmware = "firmware.elf"\n\n'
        "[world]\n"
        'scene = "room-with-boxes"\n'
        'vehicle = "pioneer-2dx"\n\n'
        "[parts.front]\n"
        'kind = "distance-switch"\n'
        'pins = { out = "brain.PA8" }\n'
        'signals = { range = "world.ray_4" }\n'
        "settings = { threshold_m = 0.5 }\n"
        "```\n\n"
        "In a bench file, `[parts.NAME]` with `kind`; `pins` joins terminals to pins (`brain.PB7`), other parts' "
        "terminals, `3v3` or `gnd`; `signals` joins quantities to those of the world (`world.ray_1`, see "
        "[vehicles.md](vehicles.md)) or to what another part gives (`driver.out_a`); `buses` joins an I2C slave to an "
        "interface of a board (`brain.I2C1`) or to two pins, where the program may move them by itself too "
        '(`{ scl = "brain.PB6", sda = "brain.PB7" }`), `[[links]]` a serial end to a USART (`brain.usart2`) or to a '
        "robot; `settings` changes what the tables have. Quirks of the originals are settings, each with the source "
        "that has it. *One step late* marks feedback: what the other part gave for the physics step before. How "
        "the two sensors work: [sensors.md](sensors.md).\n\n"
        "Without a bench file, `hilbench run bluepill:my.elf --part display=ssd1306@I2C1` solders a part to the board: "
        "behind `@` its bus (or `PB6/PB7`), then terminals and settings by commas, as in "
        "`--part flash=w25q@SPI1,cs=PA4,megabits=32`. What a display shows at the end is saved by `--picture "
        "display=shown.png`. Parts that feel a world need a bench file.\n\n"
        "Not modelled: a part at two pins stays in the middle of a byte, and may hold SDA low, only where the program "
        "has moved the pins by itself. One that an I2C interface at these pins leaves there lets go; joined to the "
        "interface (`brain.I2C1`) it stays, too. Two parts at one address of a bus are refused; one at an interface "
        "and one at the pins that it comes to are not, as a program may route it elsewhere: both answer.\n\n"
        + "\n".join(_part(kind, part_class(kind)) for kind in PARTS)
    )


def _idea(part: type[Part]) -> str:
    """The first sentence of its module."""
    return " ".join((sys.modules[part.__module__].__doc__ or "").split("\n\n")[0].split())


def _part(kind: str, part: type[Part]) -> str:
    joined = [
        (one.name, f"{'analog ' if one.analog else ''}wire {one.direction.value}", _needed(one.text, one.needed))
        for one in part.TERMINALS
    ]
    joined += [
        (one.name, f"quantity {one.direction.value}, {one.unit}", _needed(_late(one), one.needed))
        for one in part.QUANTITIES
    ]
    joined += [(one.name, f"control, {one.least:g} to {one.greatest:g}", one.text) for one in part.CONTROLS]
    joined += [(name, "serial end", "for `[[links]]`") for name in part.SERIAL]
    joined += [(name, "I2C slave", "for `buses`") for name in part.BUSES]
    joined += [(name, "SPI slave", "for `buses`") for name in part.SPI_BUSES]
    rows = [(row.name, _value(row.value), row.unit, row.source) for row in part_settings.describe(part.Settings())]
    settings = "\n" + _table(("Setting", "Default", "Unit", "Source"), rows) if rows else ""
    absent = f"\nNot modelled: {'; '.join(part.ABSENT)}.\n" if part.ABSENT else ""
    return f"## {kind}\n\n" + _table(("Name", "What", "Remark"), joined) + settings + absent


def _late(quantity: Quantity) -> str:
    return f"{quantity.text}; one step late" if quantity.late else quantity.text


def _needed(text: str, needed: bool) -> str:
    return "; ".join(word for word in (text, "has to be joined" if needed else "") if word)


def _value(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return "none" if value is None else f"{value:g}" if isinstance(value, float) else str(value)


def vehicles_page() -> str:
    """What the vehicle of every world gives to parts and takes from them, and the figures it is made from."""
    text = (
        "# Vehicles and their signals\n\n"
        "`[world]` names the vehicle and the scene it stands in. What a part's quantity is joined to is written "
        '`world.NAME`, as in `signals = { angle = "world.wheel_lf_angle" }`. *Given* is what the world gives, *taken* '
        "what one part may drive.\n"
    )
    for name in PLUGINS.systems.vehicle_names():
        kind = PLUGINS.systems.vehicle(name)
        joined = [
            (f"`{one.name}`", "given" if one.direction is Direction.IN else "taken", one.unit, one.text)
            for one in kind.signals.values()
        ]
        figures = [(row.name, f"{row.value:g}", row.unit, row.source) for row in kind.vehicle().parameters]
        text += (
            f"\n## {name}\n\n"
            + _table(("Signal", "", "Unit", "What"), joined)
            + "\n"
            + _table(("Figure", "Value", "Unit", "Source"), figures)
        )
    return text


def fidelity_page() -> str:
    """What is modelled and what every figure rests on."""
    ledger = [
        (entry.feature, ", ".join(map(str, entry.commands)), entry.fidelity.value, entry.note) for entry in LEDGER
    ]
    settings = [(row.name, str(row.value), row.unit, row.source) for row in describe(RobotSettings())]
    figures = [(row.name, f"{row.value:g}", row.unit, row.source) for row in vehicle().parameters]
    head = ("Name", "Value", "Unit", "Source")
    return (
        "# What the virtual Pioneer is, and is not\n\n"
        "Nothing here was measured on a robot of ours. *Assumed* marks a physical value nobody published, *choice* a "
        "decision of this model; change them in the bench file, under `[targets.NAME.settings]`.\n\n"
        "## The controller: what is modelled\n\n"
        + _table(("Feature", "Commands", "Modelled", "Note"), ledger)
        + "\n## The controller: what is in its FLASH\n\n"
        + _table(head, settings)
        + "\n## The body\n\n"
        + _table(head, figures)
    )


def registers_page(chip: str) -> str:
    """The fidelity ledger of an emulated microcontroller."""
    ledger = ledger_of(chip)
    rows = [(f"`{part.name}`", f"0x{part.base:08X}", *_counts(part)) for part in ledger]
    total = [str(sum(int(row[column]) for row in rows)) for column in (2, 3, 4)]
    head = ("Peripheral", "Base", *(fidelity.value.capitalize() for fidelity in Fidelity))
    remarks = [row for part in ledger for row in _remarks(part)]
    return (
        f"# The registers of the emulated {chip}\n\n"
        f"What `hilbench doctor --fidelity {chip}` prints, shortened. [mcu.md](mcu.md) says what the words mean.\n\n"
        + _table(head, [*rows, ("all", "", *total)])
        + "\n## What to know of them\n\nRegisters that are not named here are modelled, without a remark.\n\n"
        + _table(("Registers", "How far", "Bits without effect", "Remark"), remarks)
    )


def _counts(part: LedgerPeripheral) -> list[str]:
    return [str(part.counts()[fidelity.value]) for fidelity in Fidelity]


def _remarks(part: LedgerPeripheral) -> Iterable[Sequence[str]]:
    """Return one row for all registers of a peripheral of which the same is to be said."""
    alike: dict[tuple[str, str, str], list[str]] = {}
    for register in part.registers:
        ignored = f"0x{register.ignored:X}" if register.ignored else ""
        if register.fidelity is not Fidelity.MODELLED or ignored or register.note:
            alike.setdefault((register.fidelity.value, ignored, register.note), []).append(register.name)
    for (fidelity, ignored, note), names in alike.items():
        yield (
            f"`{part.name}`: " + ("all" if len(names) == len(part.registers) else _shortened(names)),
            fidelity,
            ignored,
            note,
        )


def _shortened(names: Sequence[str]) -> str:
    return ", ".join(names) if len(names) <= MANY_NAMES else f"{names[0]} to {names[-1]} ({len(names)})"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "".join("| " + " | ".join(_cell(cell) for cell in line) + " |\n" for line in lines)


def _cell(text: str) -> str:
    return " ".join(text.replace("|", "\\|").split())


def main(words: Sequence[str] | None = None) -> int:
    """Write or check the pages; return 1 if ``--check`` found a difference."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if a page is out of date")
    check = parser.parse_args(words).check
    made = {name: NOTES[Path(name).suffix] + text for name, text in pages().items()}
    stale = [name for name, text in made.items() if _read(FOLDER / name) != text]
    for name in stale:
        if check:
            sys.stderr.write(f"docs/{name} is out of date: run make docs\n")
        else:
            (FOLDER / name).parent.mkdir(parents=True, exist_ok=True)
            (FOLDER / name).write_text(made[name], encoding="utf-8")
    return 1 if check and stale else 0


def _read(path: Path) -> str:
    return path.read_text(encoding="utf-8") if path.is_file() else ""


if __name__ == "__main__":
    sys.exit(main())
