"""What a person, a CI system and a program get to read."""

from __future__ import annotations

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import msgspec
import pytest

from hilbench.check import CheckOptions, Report, list_cases, run_check
from hilbench.check.report import junit, listing, matrix
from hilbench.check.report.schema import report_json, report_schema
from hilbench.errors import UnavailableError
from hilbench.judging.observations import EmulationNote, Observations
from hilbench.strict.schema import DATA_FOLDER, schema_text
from hilbench.terminal.console import Console

EVERYTHING = """
    @my("A1")
    def test_answers(bench):
        bench.pass_time(0.5)
        at_most(0.18, 0.2, unit="s", what="answer")

    @my("A2")
    def test_stops(peer, bench):
        peer.send("stop")
        bench.pass_time(2.31)
        at_most(2.31, 2.1, uncertainty=0.01, unit="s", what="stop")

    @my("A3", level="should")
    def test_tidy(bench):
        raise Violation("untidy \\x00 \\x1b[31m")

    @my("A4")
    def test_late(bench):
        raise Inconclusive("host was late")

    @my("A5", needs=("gravity",))
    def test_falls(bench): pass

    @my("A6")
    def test_broken(bench): 1 / 0

    @my("A7")
    def test_goes(bench): raise UnavailableError("unplugged")

    @my("A8")
    def test_never(bench): pass
    """

SNAPSHOT = Path(__file__).with_name("matrix.txt")


@pytest.fixture
def report(check):
    return msgspec.structs.replace(check(EVERYTHING), host_time_s=0.5)


def test_the_matrix_is_as_it_was(report, tmp_path):
    text = matrix.render(report, colours=False, width=None).replace(str(tmp_path), "DIR")
    text = text.replace(report.run_hash, "HASH")
    assert text == SNAPSHOT.read_text(encoding="utf-8")


def test_of_a_clause_with_several_cases_those_are_named_that_fail(check):
    report = check(
        """
        @my("A1")
        @pytest.mark.parametrize("step", ["one", "two", "three", "four"])
        def test_answers(bench, step):
            assert step in ("one", "four"), f"no answer to {step}"
        """
    )
    text = matrix.render(report, colours=False, width=None)
    assert "\n  cause      no answer to two\n" in text
    assert "\n  case       panel/answers[two] (2 of 4 cases)\n             panel/answers[three]\n  evidence " in text
    assert report.clauses[0].verdict_case_ids == ("panel/answers[two]", "panel/answers[three]")


def test_one_cause_of_many_clauses_is_told_once(check):
    clauses = "\n".join(f"""
        @my("A{number}")
        def test_{number}(bench):
            raise Violation("it is deaf" if {number} != 2 else "it is slow", ["the bytes of {number}"])
        """ for number in (1, 2, 3, 4))  # fmt: skip
    report = check(clauses)
    text = matrix.render(report, colours=False, width=None)
    assert "the same words for 3 of 4: it is deaf (first A1)\n" in text
    assert [number for number in (1, 2, 3, 4) if f"  evidence   the bytes of {number}" in text] == [1, 2, 3, 4]
    assert "\n  cause      it is deaf\n" in text
    for clause in ("A3", "A4"):
        account = text[text.index(f"FAIL {clause} ") :].partition("\n\n")[0].splitlines()
        assert account[1:2] == ["  cause      as A1: it is deaf"]
        assert account[-1].startswith("  reproduce  hilbench check ")
        assert not any(line.startswith("  source") for line in account)


def test_colours_change_nothing_but_colours(report):
    plain = matrix.render(report, colours=False, width=None)
    coloured = matrix.render(report, colours=True, width=None)
    own = re.compile(
        r"\x1b\[[0-9;]+m(pass|fail|warn|inconclusive|error|n/a|not run|[A-Z]{4,}|  clause .*|exit .*)\x1b\[0m"
    )
    assert own.sub(r"\1", coloured) == plain
    assert len(own.findall(coloured)) > 10


def test_long_titles_are_cut_to_the_width_of_a_terminal(report):
    lines = matrix.render(report, colours=False, width=60).splitlines()
    rows = lines[2 : lines.index("", 2)]
    assert max(map(len, rows)) == 60


def test_junit_says_what_the_table_in_its_docstring_says(report):
    root = ElementTree.fromstring(junit.junit_xml(report).encode())
    (suite,) = root
    found = {}
    for case in suite.findall("testcase"):
        verdict = next((child for child in case if child.tag != "properties"), None)
        found[case.get("name").split()[0]] = None if verdict is None else (verdict.tag, verdict.get("type"))
    assert found == {
        "A1": None,
        "A2": ("failure", "fail"),
        "A3": ("skipped", "fail"),
        "A4": ("error", "inconclusive"),
        "A5": ("skipped", "not-applicable"),
        "A6": ("error", "error"),
        "A7": ("error", "error"),
        "A8": ("error", "not-run"),
    }
    assert {name: suite.get(name) for name in ("tests", "failures", "errors", "skipped")} == {
        "tests": "8",
        "failures": "1",
        "errors": "4",
        "skipped": "2",
    }
    assert root.get("tests") == "8"


def test_junit_has_clause_level_source_and_cause_of_each(report):
    root = ElementTree.fromstring(junit.junit_xml(report).encode())
    case = root.find("./testsuite/testcase[2]")
    facts = {entry.get("name"): entry.get("value") for entry in case.find("properties")}
    assert facts["clause"] == "A2"
    assert facts["level"] == "must"
    assert facts["source"] == "our panel, rev. C"
    assert facts["cause"] == "stop: 2.31 ± 0.01 s, required at most 2.1 s"
    assert "-k A2 --seed 0" in facts["reproduce"]
    assert "sent stop" in case.find("failure").text


def test_junit_counts_a_failing_should_when_strict(check):
    report = check('@my("A1", level="should")\ndef test_a(bench): assert False\n', strict=True)
    root = ElementTree.fromstring(junit.junit_xml(report).encode())
    assert root.get("failures") == "1"


def test_json_is_the_report_and_can_be_read_back(report):
    assert msgspec.json.decode(report_json(report), type=Report) == report


def test_the_published_schema_is_that_of_the_report():
    published = (DATA_FOLDER / "report.schema.json").read_text()
    assert published == schema_text(report_schema()), (
        "write schema_text(report_schema()) to hilbench/data/report.schema.json"
    )


def test_every_key_of_the_report_is_explained_in_its_schema():
    for definition in report_schema()["$defs"].values():
        assert all("description" in entry or "$ref" in entry for entry in definition.get("properties", {}).values()), (
            definition["title"]
        )


def test_the_files_are_written_and_the_provider_closed(write_suite, provider, tmp_path, capsys):
    suite = write_suite(EVERYTHING)
    options = CheckOptions(suites=(str(suite),), junit=tmp_path / "r.xml", json=str(tmp_path / "r.json"))
    assert run_check(options, lambda _: provider) == 3
    assert provider.closed
    assert json.loads((tmp_path / "r.json").read_text())["exit_code"] == 3
    assert ElementTree.parse(tmp_path / "r.xml").getroot().get("tests") == "8"
    assert sorted(path.suffix for path in tmp_path.iterdir() if path.is_file()) == [".json", ".py", ".xml"]
    assert capsys.readouterr().out.startswith("hilbench 0.1.0 · bench fake")


@pytest.mark.parametrize(("body", "code"), [("pass", 3), ("raise KeyboardInterrupt", 130)])
def test_a_journal_without_room_for_its_end_is_in_the_report(write_suite, provider, tmp_path, capsys, body, code):
    def close():
        raise UnavailableError("the journal cannot be written: No space left on device", where="j")

    provider.close = close
    suite = write_suite(f'@my("A1")\ndef test_a(bench): {body}\n')
    options = CheckOptions(suites=(str(suite),), json=str(tmp_path / "r.json"))
    assert run_check(options, lambda _: provider) == code
    assert json.loads((tmp_path / "r.json").read_text())["exit_code"] == code
    out, err = capsys.readouterr()
    assert out.splitlines()[-1].startswith(f"exit {code}: ")
    ended = "1/1 pass A1 panel/a\n" if code == 3 else ""
    assert err == f"{ended}hilbench: j: the journal cannot be written: No space left on device\n"


def test_json_on_standard_output_is_alone_there(write_suite, provider, capsys):
    suite = write_suite(EVERYTHING)
    run_check(CheckOptions(suites=(str(suite),), json="-"), lambda _: provider)
    out, err = capsys.readouterr()
    assert json.loads(out)["format"] == "hilbench-report/1"
    lines = err.splitlines()
    assert lines[:2] == [
        "1/7 pass A1 panel/answers",
        "2/7 fail A2 panel/stops: stop: 2.31 ± 0.01 s, required at most 2.1 s",
    ]
    assert lines[6].startswith("hilbench 0.1.0 · bench fake")


def test_a_line_about_a_case_is_one_line_of_a_log_whatever_its_cause(write_suite, provider, capsys):
    suite = write_suite('@my("A1")\ndef test_a(bench): assert False, "\\n\\x1b[31m" + 5000 * "long "\n')
    run_check(CheckOptions(suites=(str(suite),), json="-"), lambda _: provider)
    line, *_ = capsys.readouterr().err.splitlines()
    assert line.startswith("1/1 fail A1 panel/a: ")
    assert len(line) <= 200
    assert "\x1b" not in line


def test_the_list_for_a_person(write_suite, provider):
    suite = write_suite(
        """
        @my("A1", bench_time_s=1.5, needs=("world",))
        def test_a(bench): pass

        @my("A2", bench_time_s=20, needs=("gravity",), level="should")
        def test_longer(bench): pass
        """
    )
    text = listing.as_text(list_cases(CheckOptions(suites=(str(suite),)), provider))
    assert text.splitlines() == [
        "panel",
        "  A1  must     1.5 s  a       needs world",
        "  A2  should  20.0 s  longer  not applicable: no gravity",
        "",
        "1 of 2 cases apply: 1 clause, about 1.5 s of bench time",
    ]


def test_the_list_as_json(write_suite, provider, capsys):
    suite = write_suite('@my("A1", bench_time_s=1.5, needs=("gravity",))\ndef test_a(bench): pass\n')
    options = CheckOptions(suites=(str(suite),), json="-", list_only=True)
    assert run_check(options, lambda _: provider, Console()) == 0
    (entry,) = json.loads(capsys.readouterr().out)
    assert (entry["id"], entry["levels"], entry["missing"]) == ("panel/a", ["must"], ["gravity"])
    assert provider.closed


def test_clauses_stand_in_the_order_of_their_numbers(check):
    report = check("""
        @my("X10")
        def test_a(bench): pass

        @my("X9")
        def test_b(bench): pass
        """)
    assert [clause.id for clause in report.clauses] == ["X9", "X10"]


def noted(report, *notes):
    return msgspec.structs.replace(report, observed=Observations(notes=notes))


def note(where, *, suite="panel"):
    return EmulationNote(board="brain", kind="unmodelled", where=where, text=f"{where} is not modelled", at="main",
                         case_ids=(f"{suite}/a",))  # fmt: skip


def test_notes_are_in_every_report_and_the_last_line_counts_them(report):
    without = matrix.render(report, colours=False, width=None).splitlines()
    lines = matrix.render(noted(report, note("CEC"), note("DAC")), colours=False, width=None).splitlines()
    at = lines.index("2 notes on what the firmware did:")
    assert lines[at + 1 : at + 3] == [
        "  brain: CEC: CEC is not modelled (main)",
        "  brain: DAC: DAC is not modelled (main)",
    ]
    assert lines[-1] == f"{without[-1]}; 2 notes on what the firmware did"
    assert [line for line in lines if line not in lines[at : at + 3]][:-1] == without[:-1]
    one = matrix.render(noted(report, note("CEC")), colours=False, width=None).splitlines()
    assert one[-1] == f"{without[-1]}; 1 note on what the firmware did"


def test_junit_has_the_notes_of_each_suite(report):
    told = noted(report, note("CEC"), note("DAC", suite="another"))
    (suite,) = ElementTree.fromstring(junit.junit_xml(told).encode())
    assert suite.find("system-out").text == ("1 note on what the firmware did:\nbrain: CEC: CEC is not modelled (main)")
    assert junit.junit_xml(report).count("system-out") == 0


def test_json_has_the_notes_with_their_cases(report):
    told = noted(report, note("CEC"))
    assert json.loads(report_json(told))["observed"]["notes"][0]["case_ids"] == ["panel/a"]
