"""Bench files with a vehicle-interface board as a model: what they mean, what is refused, at ports, and served."""

from __future__ import annotations

import signal
from contextlib import ExitStack, closing

import msgspec
import pytest
import serial

from hilbench.bench.devices import LinesActor
from hilbench.benchfile.reader import open_bench, read_bench
from hilbench.check import CheckOptions, Verdict, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.cli import main
from hilbench.errors import UsageError
from hilbench.judging.provider import CaseInfo, CaseSetup
from hilbench.links import Line, PtyDoor
from hilbench.systems.vehicle.cases import car_host_settings
from hilbench.systems.vehicle.provider import AttachedVehicleProvider
from hilbench.terminal.options import TargetChoice
from protocols.autoware import AgentOnline, encode_frame, encode_message
from protocols.autoware.decoding import decoder
from protocols.carla import BAUD
from protocols.common.decoding import NoOptions
from targets.robots.car_host import CarHostSettings
from targets.robots.vehicle_interface import SIMULATOR_LINE, STACK_LINE, VehicleInterface, VehicleSettings
from tests.hilbench.forked import PATIENCE_S

HEAD = """version = 1
[targets.board]
model = "vehicle-interface"
"""
LINES = """[[links]]
ends = ["peer.car", "board.usart2"]
[[links]]
ends = ["peer.stack", "board.usart3"]
"""


@pytest.fixture
def bench(tmp_path):
    def write(text):
        file = tmp_path / "my.toml"
        file.write_text(HEAD + text)
        return file

    return write


def run(file, select, suite="vehicle-board", targets=()):
    options = CheckOptions(bench=str(file), suites=(suite,), select=select, targets=targets)
    return run_suites(options, make_provider(options))


def test_settings(bench):
    found = read_bench(bench('[targets.board.settings]\nprofile = "v1"\ndefects = ["H2"]\n' + LINES))
    assert found.settings_of(VehicleSettings) == VehicleSettings(profile="v1", defects=("H2",))
    assert car_host_settings(found) == CarHostSettings()
    assert not found.has_world
    assert found.suites == ("vehicle-board", "vehicle-host")
    assert found.checker_lines == {"car": "board.usart2", "stack": "board.usart3"}
    assert [link.baud for link in found.links] == [BAUD, BAUD]
    assert open_bench("rover-model").settings_of(VehicleSettings) is None


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ('[targets.board.settings]\nprofil = "v1"\n', 5, "unknown key 'profil'"),
        ('[targets.board.settings]\ndefects = ["H3"]\n', 5, "defects has 'H3', which is none; there are"),
        ('[world]\nscene = "empty"\n', 4, "no target of this bench has a world"),
        ('[targets.other]\nmodel = "rover"\n', 4, "'other': more than one robot is not available"),
        (
            '[targets.car]\nmodel = "car-host"\n[[links]]\nends = ["car.board", "board.usart2"]\n',
            7,
            'a line of a model leads to the checker; write ends = ["peer.LINE", "car.board"]',
        ),
        (LINES + '[[links]]\nends = ["peer.more", "board.usart2"]\n', 8, "a second link: this bench has 2 lines"),
        (
            LINES + '[[faults]]\nkind = "drop"\nbyte = 1\nlink = 2\n',
            11,
            "no link 2: this bench has 2 lines, link 0 to 1",
        ),
        (
            LINES + '[[faults]]\nkind = "drop"\nbyte = 1\nlink = 1\ntowards = "board.usart2"\n',
            12,
            "'board.usart2' is not an end of the link",
        ),
        ('[[links]]\nends = ["peer.car", "board.host"]\n', 5, "'board.host' is not the end of a link"),
    ],
)
def test_what_is_refused(bench, capsys, text, line, message):
    file = bench(text)
    assert main(["validate", str(file)]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"hilbench: {file}:{line}: ")
    assert message in said


@pytest.mark.parametrize(
    ("targets", "message"),
    [
        (["car=serial:/dev/a"], "nothing at the line 'stack'"),
        (["serial:/dev/a"], "does not say which line, of car and stack"),
        (["car=serial:/dev/a", "car=serial:/dev/b"], "the line 'car' has a port already"),
        (["car=serial:/dev/a", "stck=serial:/dev/b"], "no line 'stck'"),
        (["car=serial:/dev/a", "stack=pioneer"], "--target stack=pioneer: each line needs a serial port"),
        (["board.v2=vehicle-model:v1"], "nothing of that name to replace"),
        (["board.v0=vehicle-model:v2"], "no profile 'v2'"),
        (["listen:tcp:0", "listen:tcp:0"], "one simulator's side at a time"),
        (
            ["vehicle-model:v1"],
            (
                "--target vehicle-model:v1: does not say which profile it replaces; "
                "write --target board.hardened=vehicle-model:v1 (or board.v0 or board.v1)"
            ),
        ),
    ],
)
def test_wrong_targets(bench, capsys, targets, message):
    words = [word for target in targets for word in ("--target", target)]
    assert main(["check", str(bench(LINES)), *words]) == 2
    assert message in capsys.readouterr().err


def test_lines_without_names_cannot_have_ports(bench):
    file = bench('[[links]]\nends = ["peer", "board.usart2"]\n')
    with pytest.raises(UsageError, match="no line of the checker, with a name, leads to usart2"):
        run(file, "VB01", targets=(TargetChoice(name="car", spec="serial:/dev/none"),))


def test_a_defect_in_the_bench_file_is_found(bench):
    report = run(bench('[targets.board.settings]\ndefects = ["H2"]\n' + LINES), "(VB25H or VB01) and hardened")
    verdicts = {case.clause_ids[0]: case.verdict for case in report.cases}
    assert verdicts == {"VB01": Verdict.PASS, "VB25H": Verdict.FAIL}


def test_a_defect_of_the_simulator_s_side_is_found(bench):
    car = '[targets.car]\nmodel = "car-host"\n[targets.car.settings]\ndefects = ["H4"]\n'
    report = run(bench(LINES + car), "(VS01 or VS12H) and hardened", "vehicle-host")
    verdicts = {case.clause_ids[0]: case.verdict for case in report.cases}
    assert verdicts == {"VS01": Verdict.PASS, "VS12H": Verdict.FAIL}


def test_faults_strike_the_simulator_s_line(bench):
    flips = LINES + '[[faults]]\nkind = "drop"\nprobability = 0.2\ntowards = "board.usart2"\n'
    (case,) = run(bench(flips), "VB19 and hardened").cases
    assert case.verdict is Verdict.FAIL
    assert any("drop" in line for line in case.evidence)


def test_faults_strike_the_line_that_is_named_first(bench):
    """A stack whose commands are lost: the simulator hears stops and then the joystick."""
    car, stack = LINES.split("[[links]]")[1:]
    lines = f"[[links]]{stack}[[links]]{car}"
    drops = lines + '[[faults]]\nkind = "drop"\nprobability = 0.5\ntowards = "board.usart3"\n'
    cases = run(bench(drops), "(VB02 or VB32H) and hardened").cases
    assert {case.clause_ids[0]: case.verdict for case in cases}["VB02"] is Verdict.FAIL


DROP = '[[faults]]\nkind = "drop"\nprobability = 0.5\n'


def drops_on(link, towards):
    return LINES + DROP + f'link = {link}\ntowards = "{towards}"\n'


LOST = '[[faults]]\nkind = "drop"\nprobability = 1\n'


def lost_on(link, towards):
    """A bench where nothing arrives at one end of a link."""
    return LINES + LOST + f'link = {link}\ntowards = "{towards}"\n'


@pytest.mark.parametrize(("link", "end", "clause"), [(0, "board.usart2", "VB24"), (1, "board.usart3", "VB12")])
def test_faults_strike_the_link_they_name(bench, link, end, clause):
    report = run(bench(lost_on(link, end)), f"{clause} and hardened")
    (case,) = report.cases
    assert case.verdict is Verdict.FAIL
    assert any("drop" in line for line in case.evidence)
    assert report.bench["faults"] == f"drop probability 1{' link 1' * link} towards {end}"


def heard_by(there, sound):
    """Whether the simulator's end and the driving stack's hear anything of statuses until one of them, sound, has."""
    there.simulator.statuses.start(20.0)
    end = (there.simulator, there.stack)[sound]
    there.bench.run_until(lambda: end.bytes_received > 0, PATIENCE_S)
    there.bench.run_for(0.1)
    heard = there.simulator.bytes_received > 0, there.stack.bytes_received > 0
    there.finish("pass", "")
    return heard


@pytest.mark.parametrize("link", [0, 1])
def test_the_other_line_is_sound(bench, link):
    file = bench(lost_on(link, ("peer.car", "peer.stack")[link]))
    provider = make_provider(CheckOptions(bench=str(file), suites=("vehicle-board",)))
    info = CaseInfo(id="both", clause_ids=(), seed=0, setup=CaseSetup(program="hardened"))
    with provider.open_case(info) as there:
        there.bench.run_for(21.0)  # without an agent the board is in MANUAL then
        heard = heard_by(there, 1 - link)
    provider.close()
    assert heard == (link == 1, link == 0)


@pytest.mark.parametrize("link", [0, 1])
def test_faults_strike_board_and_simulator_s_side_together(bench, link):
    """VS18 has both at the ends of link 0, and the checker at link 1."""
    end, car = ("board.usart2", "board.usart3")[link], '[targets.car]\nmodel = "car-host"\n'
    (case,) = run(bench(car + lost_on(link, end)), "VS18 and hardened", "vehicle-host").cases
    assert case.verdict is Verdict.FAIL
    assert any("drop" in line for line in case.evidence)


def test_the_january_firmware_judged_by_the_clauses_of_november(bench):
    """It takes a live simulator for silent: a false EMERGENCY every 1.6 s."""
    instead = (TargetChoice(name="board.v0", spec="vehicle-model:v1"),)
    (case,) = run(bench(LINES), "VB19 and v0", targets=instead).cases
    assert case.verdict is Verdict.FAIL
    assert "3 frames of EMERGENCY" in case.cause
    assert "one every 1.600 s" in case.cause


def test_suites_of_the_vehicle_mean_its_bench(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["check", "--suite", "vehicle-board", "-k", "VB12 and hardened"]) == 0
    assert "bench vehicle-model" in capsys.readouterr().out


@pytest.mark.real_time("the ports of a board that somebody else runs; a host that is late makes a case inconclusive")
@pytest.mark.slow("the board is settled in real time before and after a case")
@pytest.mark.parametrize(
    "clauses",
    [
        {"VB01"},
        pytest.param(
            {"VB01", "VB11H", "VB12"}, marks=pytest.mark.exhaustive("one clause shows that the ports are used")
        ),
    ],
    ids=["one clause", "three"],
)
def test_a_board_behind_two_ptys(tmp_path, clauses):
    """Through pseudo-terminals and pyserial, in real time: what can be seen on the lines alone is judged."""
    targets = tuple(TargetChoice(name=name, spec=f"serial:{tmp_path / name}@{BAUD}") for name in ("simulator", "stack"))
    select = " or ".join(["VB09", *sorted(clauses)])
    options = CheckOptions(bench="vehicle-model", suites=("vehicle-board",), targets=targets, select=select)
    provider = make_provider(options)
    assert isinstance(provider, AttachedVehicleProvider)
    scheduler = provider._scheduler
    with ExitStack() as stack:
        doors = {
            line: stack.enter_context(closing(PtyDoor(scheduler, str(tmp_path / name), Line(baud=BAUD), any_baud=True)))
            for line, name in ((SIMULATOR_LINE, "simulator"), (STACK_LINE, "stack"))
        }
        LinesActor(provider._bench, VehicleInterface(VehicleSettings()), doors, name="board")
        report = run_suites(options, provider)
        provider.close()
    verdicts = {case.id.partition("[")[2]: {} for case in report.cases}
    for case in report.cases:
        verdicts[case.id.partition("[")[2]][case.clause_ids[0]] = case.verdict
    assert {*verdicts["v0]"].values()} == {Verdict.NOT_APPLICABLE}
    hardened = verdicts["hardened]"]
    assert hardened.pop("VB09") is Verdict.NOT_APPLICABLE
    # A busy host may leave a deadline undecided, and accuses nobody.
    assert hardened.keys() == clauses
    assert {*hardened.values()} <= {Verdict.PASS, Verdict.INCONCLUSIVE}


@pytest.mark.real_time("the ports are real; what is lost is lost however late the host is")
@pytest.mark.slow("the board is settled in real time before and after a case")
@pytest.mark.parametrize("link", [0, 1])
def test_faults_strike_one_of_two_ports(tmp_path, bench, link):
    """The port of the link that is named, and nobody else's: all that comes from the board by it is lost."""
    file = bench(lost_on(link, ("peer.car", "peer.stack")[link]))
    names = ("car", "stack")
    targets = tuple(TargetChoice(name=name, spec=f"serial:{tmp_path / name}@{BAUD}") for name in names)
    provider = make_provider(CheckOptions(bench=str(file), suites=("vehicle-board",), targets=targets))
    with ExitStack() as stack:
        doors = {
            line: stack.enter_context(
                closing(PtyDoor(provider._scheduler, str(tmp_path / name), Line(baud=BAUD), any_baud=True))
            )
            for line, name in zip((SIMULATOR_LINE, STACK_LINE), names, strict=True)
        }
        LinesActor(provider._bench, VehicleInterface(VehicleSettings()), doors, name="board")
        info = CaseInfo(id="ports", clause_ids=(), seed=0, setup=CaseSetup(program="hardened"))
        with provider.open_case(info) as there:
            heard = heard_by(there, 1 - link)
        provider.close()
    assert heard[link] is False
    assert heard[1 - link] is True


def test_a_program_in_the_place_of_the_simulator_s_side_has_no_board(capsys):
    assert main(["check", "vehicle", "--target", "exec:python3 bridge.py {pty}"]) == 2
    said = capsys.readouterr().err
    assert "a program in the place of the simulator's side is checked without a board, not on this bench" in said
    assert "check vehicle-model --suite vehicle-host --target 'exec:python3 bridge.py {pty}'" in said


@pytest.mark.parametrize("word", ["vehicle-model", "pioneer"])
def test_a_bench_has_nothing_behind_a_colon(tmp_path, capsys, word):
    assert main(["serve", f"{word}:v1", "--pty", str(tmp_path / "x")]) == 2
    said = capsys.readouterr().err
    assert f"{word}:v1: '{word}' is a bench, with nothing behind a colon; " in said
    assert ('[targets.interface.settings] profile = "v1"' in said) is (word == "vehicle-model")


def test_a_line_that_nobody_serves_is_said(forkable, tmp_path):
    with forkable.start("serve", "vehicle-model", "--pty", tmp_path / "car") as served:
        said = served.hear("stop with").splitlines(keepends=True)
    assert said[0].startswith("serving interface.usart2 at ")
    assert said[1] == "interface.usart3 is connected to nothing; add --pty usart3=PATH or --tcp usart3=PORT\n"


@pytest.mark.real_time("a client at doors in real time, who waits for what is sent once a second")
def test_it_is_served_at_both_lines(forkable, tmp_path):
    doors = [f"--pty=usart2={tmp_path / 'car'}", f"--pty=usart3={tmp_path / 'stack'}"]
    journal = tmp_path / "served.jsonl"
    with forkable.start("serve", "vehicle-model", *doors, "--journal", journal) as served:
        said = served.hear("stop with Ctrl-C\n").splitlines(keepends=True)
        assert said[0].startswith("serving interface.usart2 at ")
        assert said[1].startswith("serving interface.usart3 at ")
        assert said[2] == "stop with Ctrl-C\n"
        with serial.Serial(str(tmp_path / "stack"), BAUD, timeout=PATIENCE_S) as port:
            ping = bytes.fromhex("7E000001008 1C060".replace(" ", ""))
            assert ping in port.read_until(ping)
            port.write(online := encode_frame(encode_message(AgentOnline())))
            board = decoder(NoOptions(), "target")
            while not {item.name for item in board.feed(port.read(1))} - {"AgentPing"}:
                pass  # the board says more as soon as it has heard that
        served.send_signal(signal.SIGINT)
        assert served.wait() == 0
    events = [msgspec.json.decode(line) for line in journal.read_text().splitlines()]
    heard = [event for event in events if event["kind"] == "rx"]
    assert b"".join(bytes.fromhex(event["data"]) for event in heard) == online
    assert {(event["source"], event["line"]) for event in heard} == {("board", "usart3")}


def test_a_door_for_a_line_that_is_not_there(tmp_path, capsys):
    assert main(["serve", "vehicle-model", "--pty", f"usart1={tmp_path / 'x'}"]) == 2
    assert "no such line" in capsys.readouterr().err
    assert main(["serve", "vehicle-model", "--tcp", "0", "--scene", "corridor"]) == 2
    assert "no target of this bench has a world" in capsys.readouterr().err
