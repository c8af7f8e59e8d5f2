from __future__ import annotations

import json
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

import pytest

from hilbench.bench.about import about_reading
from hilbench.errors import UsageError
from hilbench.plugins.protocol import API, ProtocolPlugin
from tests.hilbench.plugins.conftest import TINY

OWN = ["autoware", "carla", "p2os", "pkt", "xrce"]


def refusal(act, *arguments):
    with pytest.raises(UsageError) as caught:
        act(*arguments)
    return str(caught.value)


def test_names_are_known_without_an_import(plugins, package):
    package("stranger", "raise SystemError('imported')", {"strange": "stranger:P", "a": "stranger:P"})
    assert plugins.names() == [*OWN, "a", "strange"]
    assert plugins.origin("strange") == "the package stranger"
    assert plugins.origin("pkt") == "the package hilbench"


def test_what_cannot_be_imported_costs_one_line_and_the_others_are_there(plugins, package):
    package("stranger", "import nothing_of_that_name", {"strange": "stranger:P"})
    assert [one.name for one in plugins.all()] == OWN
    expected = (
        "protocol 'strange' of the package stranger: cannot be imported: "
        "ModuleNotFoundError: No module named 'nothing_of_that_name'"
    )
    assert plugins.broken == {"strange": expected}
    assert refusal(plugins.get, "strange", "--protocol") == f"--protocol: {expected}"


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("P = 3", "'stranger:P' is no ProtocolPlugin"),
        (TINY + "P = TINY", "calls itself 'tiny'; entry point and record need one name"),
        (
            TINY.replace("api=1", "api=2").replace("name='tiny'", "name='strange'") + "P = TINY",
            "was written for api 2, and this hilbench has 1; install one that fits",
        ),
    ],
)
def test_a_record_that_is_none_is_refused(plugins, package, source, said):
    package("stranger", source, {"strange": "stranger:P"})
    assert plugins.known("strange") is None
    assert plugins.broken["strange"] == f"protocol 'strange' of the package stranger: {said}"


def test_two_packages_with_one_name_are_refused(plugins, package):
    package("one", TINY, {"tiny": "one:TINY"}, "a")
    package("two", TINY, {"tiny": "two:TINY"}, "b")
    said = refusal(plugins.get, "tiny", "PROTOCOL")
    assert said.startswith("protocol 'tiny': comes from the package")
    assert "the package one" in said
    assert "the package two" in said


def test_a_name_of_ours_is_not_taken_over(plugins, package):
    package("stranger", TINY.replace('"tiny"', '"pkt"'), {"pkt": "stranger:TINY"})
    assert plugins.get("pkt", "PROTOCOL").title == "PKT!"
    assert [*plugins.broken.values()] == [
        "protocol 'pkt' of the package stranger: the name is that of one of hilbench's own; it is left out"
    ]


def test_what_is_not_there_is_refused_with_those_that_are(plugins):
    said = refusal(plugins.get, "p2so", "PROTOCOL")
    assert said == "PROTOCOL: no protocol 'p2so'; did you mean 'p2os'?"
    assert "autoware, carla, p2os, pkt, xrce" in refusal(plugins.get, "modbus", "PROTOCOL")


# --- files


def test_a_file_brings_a_protocol_once(plugins, tiny):
    plugins.add_file(tiny, "--plugin")
    plugins.add_file(tiny, "--plugin")
    assert plugins.names() == [*OWN, "tiny"]
    assert plugins.get("tiny", "PROTOCOL").title == "Tiny"
    assert plugins.origin("tiny") == str(tiny)


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("x = 1\n", "--plugin: '{path}' defines no protocol and no system; see docs/plugins.md"),
        ("x = 1\ny = (\n", "{path}:2: cannot be imported: SyntaxError: '(' was never closed ({name}, line 2)"),
        ("import json\n\njson.loads('')\n", "{path}:3: cannot be imported: JSONDecodeError: Expecting value: line 1 "),
        (TINY.replace("api=1", "api=7"), "{path}: was written for api 7, and this hilbench has 1"),
        (TINY.replace('"tiny", title', '"p2os", title'), "--plugin: '{path}' brings the protocol 'p2os', which comes"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused_with_its_line(plugins, tmp_path, source, said):
    path = tmp_path / "mine.py"
    path.write_text(source)
    assert refusal(plugins.add_file, path, "--plugin").startswith(said.format(path=path, name=path.name))


def test_a_file_that_is_not_there_and_one_of_another_kind(plugins, tmp_path):
    assert refusal(plugins.add_file, tmp_path / "no.py", "--plugin") == f"--plugin: no file '{tmp_path / 'no.py'}'"
    text = tmp_path / "notes.txt"
    text.write_text(TINY)
    assert refusal(plugins.add_file, text, "--plugin") == f"--plugin: '{text}' is no .py file"


# --- on the command line


def test_its_frames_and_its_flags(hilbench, tiny, tmp_path):
    line = tmp_path / "line.bin"
    line.write_bytes(b"one\ntwo\nthr")
    code, out, err = hilbench("decode", "tiny", line, "--plugin", tiny)
    assert (code, [row.split()[-1] for row in out.splitlines()][:2]) == (1, ["one", "two"])
    assert "no end" in out
    code, out, err = hilbench("decode", "--plugin", tiny, "--loud", "--most=2", "tiny", line)
    assert [row.split()[-1] for row in out.splitlines()][:2] == ["ON", "TW"]
    code, out, err = hilbench("decode", "pkt", line, "--plugin", tiny, "--loud")
    assert (code, out) == (2, "")
    assert "--loud" in err


def test_its_own_flag_is_refused_by_name(hilbench, tiny):
    code, out, err = hilbench("decode", "tiny", "--most", "many", "--plugin", tiny)
    assert (code, out) == (2, "")
    assert "--most" in err
    assert "many" in err


def test_help_runs_no_code_of_a_plug_in(hilbench, package):
    package("stranger", "raise SystemError('imported')", {"strange": "stranger:P"})
    for words in (["--help"], ["decode", "--help"], ["decode", "strange", "--help"], ["protocols", "--help"]):
        code, _, err = hilbench(*words)
        assert (code, err) == (0, "")


def test_the_list_has_those_of_files_and_says_of_each_where_it_is_from(hilbench, tiny, package):
    package("stranger", "raise SystemError('imported')", {"strange": "stranger:P"})
    code, out, err = hilbench("protocols", "--plugin", tiny)
    assert code == 0
    assert [row.split()[0] for row in out.splitlines()] == [*OWN, "tiny"]
    assert out.splitlines()[-1] == f"tiny      Tiny: lines of text ({tiny})"
    expected = "protocol 'strange' of the package stranger: cannot be imported: SystemError: imported"
    assert err == f"hilbench: note: {expected}\n"


def test_one_of_the_list_with_all_there_is_to_it(hilbench, tiny):
    code, out, err = hilbench("protocols", "tiny", "--plugin", tiny)
    assert (code, err) == (0, "")
    assert "clauses  1" in out
    assert "--most  tiny: letters in a line (default: 80)" in out


# --- clauses


def test_a_clause_id_that_is_taken_refuses_its_protocol(hilbench, tiny):
    from hilbench.check.catalogue import find_clause

    tiny.write_text(TINY.replace('"TINY1"', '"P01"'))
    hilbench("protocols", "--plugin", tiny)
    clause = find_clause("P01")
    assert clause is not None
    assert clause.source != "tiny.py"
    code, _, err = hilbench("protocols", "--plugin", tiny)
    assert code == 0
    said = "has a clause 'P01', and so has another catalogue; it is left out"
    assert err == f"hilbench: note: protocol 'tiny' of {tiny}: {said}\n"


def test_a_clause_of_a_file_is_found_and_needs_its_protocol(plugins, tiny):
    from hilbench.check.catalogue import find_clause

    assert find_clause("TINY1") is None
    plugins.add_file(tiny, "--plugin")
    clause = find_clause("TINY1")
    assert clause is not None
    assert clause.needs == {"Tiny"}


# --- code that fails


def test_an_error_in_its_code_is_named_with_file_and_line_and_is_no_defect_of_ours(hilbench, tiny, tmp_path):
    tiny.write_text(TINY.replace('text = found[:-1].decode("ascii", "replace")', "text = (1 / 0)"))
    number = 1 + tiny.read_text().splitlines().index("        text = (1 / 0)[: self.options.most]")
    line = tmp_path / "line.bin"
    line.write_bytes(b"one\n")
    code, _, err = hilbench("decode", "tiny", line, "--plugin", tiny)
    assert code == 2
    assert err.startswith(f"hilbench: tiny.py:{number}: ZeroDivisionError: division by zero (traceback in ")
    assert err.count("\n") == 1


@pytest.mark.parametrize("broken", ["    def find(self, data):", "def clauses():"])
def test_one_whose_code_fails_does_not_stand_in_the_way_of_others(hilbench, tiny, tmp_path, broken):
    journal = tmp_path / "run.jsonl"
    assert hilbench("check", "rover-model", "-k", "P01", "--journal", journal)[0] == 0
    tiny.write_text(TINY.replace(broken, f"{broken} raise OSError('gone')\n{broken.replace('(', '_(')}", 1))
    code, out, err = hilbench("check", "--target", f"capture:{journal}", "--plugin", tiny)
    assert code == 0, err
    assert "(pkt)" in out
    assert "OSError: gone; it is left out" in err


# --- in a bench file


def bench_with(tmp_path, *lines):
    path = tmp_path / "bench.toml"
    path.write_text("\n".join(["version = 1", *lines, ""]))
    return path


def test_a_bench_file_names_a_file_that_is_run_when_the_bench_is_opened_and_not_before(hilbench, tiny, tmp_path):
    tiny.write_text("raise SystemError('run')")
    bench = bench_with(tmp_path, 'plugins = ["tiny.py"]', "[targets.one]", 'model = "tiny"', "settings = { any = 3 }")
    assert hilbench("validate", bench) == (0, f"{bench}: ok\n", "")
    code, out, err = hilbench("check", bench)
    assert (code, out) == (2, "")
    assert err == f"hilbench: {tiny}:1: cannot be imported: SystemError: run\n"


def test_a_protocol_of_ours_is_looked_at_by_validate_too(hilbench, tmp_path):
    bench = bench_with(tmp_path, "[targets.a]", 'model = "pkt"')
    code, _, err = hilbench("validate", bench)
    assert (code, err.count("\n")) == (2, 1)
    assert "the protocol 'pkt' brings no model" in err


@pytest.mark.parametrize(
    ("lines", "line", "said"),
    [
        (['plugins = ["no.py"]', "[targets.a]", 'model = "x"'], 2, "no file '"),
        (['plugins = ["tiny.py"]', "[targets.a]", 'model = "tiny"'], 4, "the protocol 'tiny' brings no model"),
        (['plugins = ["tiny.py"]', "[targets.a]", 'model = "tinny"'], 4, "'tinny' is not a value it takes"),
        (["[targets.a]", 'model = "pkt"'], 3, "the protocol 'pkt' brings no model"),
        (
            ["[targets.a]", 'model = "rover"', "[[links]]", 'ends = ["peer", "a.host"]', 'protocol = "pkt"'],
            6,
            "only a line between 'peer' and a board has a protocol",
        ),
    ],
)
def test_what_a_bench_file_gets_wrong_is_named_with_its_line(hilbench, tiny, tmp_path, lines, line, said):
    bench = bench_with(tmp_path, *lines)
    code, out, err = hilbench("check", bench)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith(f"hilbench: {bench}:{line}: {said}")


def test_a_suite_has_bytes_at_its_peer_where_no_protocol_is_named(hilbench, tmp_path):
    image = Path(__file__).parents[3] / "targets/firmware/images/echo-irq.elf"
    tmp_path.joinpath("suite.py").write_text(
        "from hilbench.check import case\n\n\n"
        '@case("OUR1", text="It says what it hears.", level="must", source="ours")\n'
        "def test_echo(peer):\n"
        "    peer.run(0.01)\n"
        '    peer.write(b"abc")\n'
        '    assert peer.expect(bytes, 0.1) == b"a"\n'
        "    peer.run(0.1)\n"
        '    assert b"".join(got.packet for got in peer.received) == b"abc"\n'
    )
    target = ["[targets.brain]", 'board = "bluepill"', f'firmware = "{image}"']
    link = ["[[links]]", 'ends = ["peer", "brain.usart1"]']
    bench = bench_with(tmp_path, 'suites = ["suite.py"]', *target, *link)
    code, out, err = hilbench("check", bench)
    assert code == 0, out + err


def test_a_board_at_a_port_has_the_peer_of_its_protocol_as_the_emulated_one_has(plugins, tmp_path):
    from hilbench.bench.protocol_providers import AttachedPeerProvider
    from hilbench.check.bench_provider import make_provider
    from hilbench.terminal.options import CheckOptions, TargetChoice

    image = Path(__file__).parents[3] / "targets/firmware/images/echo-irq.elf"
    tmp_path.joinpath("suite.py").write_text("")
    target = ["[targets.brain]", 'board = "bluepill"', f'firmware = "{image}"']
    link = ["[[links]]", 'ends = ["peer", "brain.usart1"]', 'protocol = "pkt"']
    bench = bench_with(tmp_path, 'suites = ["suite.py"]', *target, *link)
    choice = TargetChoice(spec="serial:/dev/nothing", name="brain.usart1")
    provider = make_provider(CheckOptions(bench=str(bench), targets=(choice,)))
    assert isinstance(provider, AttachedPeerProvider)
    assert provider.capabilities == {"PKT!"}
    provider.close()


class Form(Enum):
    SHORT = "S"
    LONG = "L"


@dataclass(frozen=True)
class Reading:
    """One option of each kind."""

    form: Form = Form.SHORT
    table: Path = Path("none")
    strict: bool = True
    length: int = 3
    scale: float = 1.0
    word: str = ""


def test_how_frames_are_read_comes_back_from_the_header_of_a_journal():
    protocol = ProtocolPlugin(api=API, name="x", title="X", decoder=print, options=Reading)
    reading = Reading(form=Form.LONG, table=Path("a/b"), strict=False, length=4, scale=0.5, word="w")
    header = json.loads(json.dumps(about_reading(reading)))
    assert protocol.options_in({"protocol": "x", **header}) == reading
