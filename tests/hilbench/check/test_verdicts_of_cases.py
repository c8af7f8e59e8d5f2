"""What a case does, and what the report then says."""

from __future__ import annotations

import sys
from xml.etree import ElementTree

import pytest
from _pytest._code import TracebackEntry

from hilbench.check import CheckOptions, Verdict, run_suites
from hilbench.check.report import junit, matrix


def only(report):
    (clause,) = report.clauses
    return clause


def test_a_case_that_returns_passes(check, provider):
    report = check(
        """
        @my("A1")
        def test_it(bench, peer):
            peer.send(3)
            bench.pass_time(0.25)
        """
    )
    assert only(report).verdict is Verdict.PASS
    assert only(report).bench_time_s == 0.25
    assert report.exit_code == 0
    assert provider.opened[0].verdicts == [("pass", "")]
    assert provider.closed_cases == 1


def test_an_assertion_is_a_violation_and_says_what_was_compared(check, provider):
    report = check(
        """
        @my("A1")
        def test_it(peer):
            peer.send("hello")
            answer = [1, 2, 3]
            assert answer == [1, 2, 4]
        """
    )
    clause = only(report)
    assert (clause.verdict, report.exit_code) == (Verdict.FAIL, 1)
    assert clause.cause == "assert [1, 2, 3] == [1, 2, 4]"
    assert any("At index 2 diff" in line for line in clause.evidence)
    assert any(line.startswith("test_panel.py:") for line in clause.evidence)
    assert clause.evidence[-1] == "sent hello"
    assert provider.opened[0].verdicts == [("fail", clause.cause)]


def test_the_evidence_has_figures_and_no_insides_of_python(check):
    report = check(
        """
        @my("A1")
        def test_any():
            assert any(map(bool, [0, 0])), "nothing is there"

        @my("A2")
        def test_figures():
            assert max(3, 4) == 5, "not five"

        @my("A3")
        def test_bare_values():
            frames = []
            assert frames, "no frame came"
        """
    )
    found, figures, bare = report.clauses
    assert bare.evidence[0].startswith("test_panel.py:")
    assert (found.cause, found.evidence) == (
        "nothing is there", ('test_panel.py:11: assert any(map(bool, [0, 0])), "nothing is there"',)
    )  # fmt: skip
    assert figures.evidence[:2] == ("assert 4 == 5", " +  where 4 = max(3, 4)")


@pytest.mark.parametrize(
    ("statement", "verdict", "code", "cause"),
    [
        ("raise Violation('too late', ['at 3 s'])", Verdict.FAIL, 1, "too late"),
        ("raise Inconclusive('host was late')", Verdict.INCONCLUSIVE, 4, "host was late"),
        ("raise NotApplicable('no bumpers')", Verdict.NOT_APPLICABLE, 4, "no bumpers"),
        ("pytest.skip('no bumpers')", Verdict.NOT_APPLICABLE, 4, "no bumpers"),
        ("pytest.fail('no')", Verdict.FAIL, 1, "no"),
        ("pytest.xfail('no')", Verdict.FAIL, 1, "no"),
        ("1 / 0", Verdict.ERROR, 2, "test_panel.py:11: ZeroDivisionError: division by zero"),
        ("raise SystemExit(0)", Verdict.ERROR, 2, "test_panel.py:11: SystemExit: 0"),
        ("raise UnavailableError('gone', where='/dev/ttyX')", Verdict.ERROR, 3, "/dev/ttyX: gone"),
    ],
)
def test_what_a_case_raises(check, statement, verdict, code, cause):
    report = check(
        f"""
        @my("A1")
        def test_it(bench):
            {statement}
        """
    )
    assert (only(report).verdict, report.exit_code, only(report).cause) == (verdict, code, cause)


def test_what_a_suite_of_one_s_own_calls_wrongly_is_its_error_too(check, tmp_path):
    """By file and line of what is the user's, however deep in hilbench it shows; beside a violation it comes first."""
    (tmp_path / "neighbour.py").write_text(
        "from hilbench.errors import UsageError\ndef ask(): raise UsageError('no lamp')\n"
    )
    report = check(
        """
        import neighbour

        @my("A1")
        def test_a(bench):
            neighbour.ask()

        @my("A2")
        def test_b(bench):
            bench.pass_time("long")

        @my("A3")
        def test_c(bench):
            assert False, "wrong"
        """
    )
    first, second, third = report.cases
    assert first.cause == "neighbour.py:2: no lamp"
    assert second.cause.startswith("test_panel.py:17: TypeError: ")
    assert (first.suite_error, second.suite_error, first.defect, second.defect) == (True, True, False, False)
    assert third.verdict is Verdict.FAIL
    assert (report.exit_code, report.exit_meaning) == (2, "an error in a suite or plug-in of your own")


def test_a_suite_imports_its_neighbours_and_each_its_own(write_suite, provider, tmp_path):
    suites = []
    for number in (1, 2):
        folder = tmp_path / f"s{number}"
        (folder / "package").mkdir(parents=True)
        (folder / "package" / "__init__.py").write_text(f"NUMBER = {number}\n")
        (folder / "shared.py").write_text(f"NUMBER = {number}\n")
        (folder / "json.py").write_text("raise RuntimeError('in the place of the standard library')\n")
        body = "\n    ".join(("import json, package, shared", f"assert package.NUMBER == shared.NUMBER == {number}"))
        name = f"s{number}/test_it{number}.py"
        suites.append(str(write_suite(f'import shared\n@my("A{number}")\ndef test_a(bench):\n    {body}\n', name)))
    report = run_suites(CheckOptions(suites=tuple(suites)), provider)
    assert (report.exit_code, [case.cause for case in report.cases]) == (0, ["", ""])
    assert not {"shared", "package"} & {*sys.modules}
    assert not {str(tmp_path / "s1"), str(tmp_path / "s2")} & {*sys.path}


def test_an_error_of_ours_in_what_a_suite_calls_is_a_defect_still(check):
    report = check(
        """
        @my("A1")
        def test_a(bench):
            type(bench).pass_time(bench, None and 1)

        @my("A2")
        def test_b(bench):
            import json
            json.scanner.py_make_scanner(object())

        @my("A3")
        def test_c(nosuch):
            pass
        """
    )
    first, second, third = report.cases
    assert first.cause.startswith("test_panel.py:11: TypeError: ")
    assert (second.defect, second.cause.partition(":")[0]) == (True, "defect")
    assert third.cause.startswith("test_panel.py: no fixture 'nosuch'; a case has bench, peer, ")
    assert (third.suite_error, report.exit_code) == (True, 5)


def test_a_should_that_fails_warns_and_fails_when_strict(check):
    body = """
        @my("A1", level="should")
        def test_it(bench):
            assert False, "untidy"

        @my("A2")
        def test_other(bench):
            pass
        """
    lenient, strict = check(body), check(body, strict=True)
    assert (lenient.exit_code, lenient.counts.warned, lenient.counts.failed) == (0, 1, 0)
    assert (strict.exit_code, strict.counts.warned, strict.counts.failed) == (1, 0, 1)


def test_an_inconclusive_should_counts_only_when_strict(check):
    body = """
        @my("A1", level="should")
        def test_it(bench):
            raise Inconclusive("host was late")

        @my("A2")
        def test_other(bench):
            pass
        """
    assert check(body).exit_code == 0
    assert check(body, strict=True).exit_code == 4


def test_what_the_bench_lacks_is_not_applicable_and_named(check, make_provider):
    provider = make_provider(capabilities=())
    report = check(
        """
        @my("A1", needs=("world", "gravity"))
        def test_it(bench):
            assert False

        @my("A2")
        def test_other(bench):
            pass
        """,
        provider=provider,
    )
    first, second = report.clauses
    assert (first.verdict, first.cause) == (Verdict.NOT_APPLICABLE, "the bench has no gravity and no world")
    assert report.cases[0].missing == ("gravity", "world")
    assert second.verdict is Verdict.PASS
    assert report.exit_code == 0
    assert len(provider.opened) == 1


@pytest.mark.parametrize(("level", "strict", "code"), [("must", False, 0), ("must", True, 4), ("should", True, 0)])
def test_what_a_target_must_do_and_nobody_saw_is_said_in_the_last_line(check, make_provider, level, strict, code):
    body = f"""
        @my("A1", level={level!r}, needs=("world",))
        def test_it(bench):
            pass

        @my("A2")
        def test_other(bench):
            pass
        """
    report = check(body, provider=make_provider(capabilities=()), strict=strict)
    said = {0: "all checks passed", 4: "inconclusive"}[code]
    missing = "; 1 must clause not shown here: A1" if level == "must" else ""
    assert (report.exit_code, report.exit_meaning) == (code, said + missing)


OWN_REPORT = """
    @case("P24D")
    def test_it(bench):
        assert {holds}, "the motors run on"
    """
OF_A_ROVER = ("PKT!", "server")


@pytest.mark.parametrize("strict", [False, True])
def test_what_the_target_says_of_itself_is_marked_and_no_longer_missing(check, make_provider, strict):
    provider = make_provider(capabilities=(*OF_A_ROVER, "motion reports"))
    report = check(OWN_REPORT.format(holds=True), provider=provider, strict=strict)
    (clause,), (case,) = report.clauses, report.cases
    assert (clause.verdict, clause.by_own_report, case.by_own_report) == (Verdict.PASS, ("duty",), ("duty",))
    shown = "1 must clause shown by the target's own report alone: P24D"
    assert (report.exit_code, report.exit_meaning) == (0, f"all checks passed; {shown}")
    text = matrix.render(report, colours=False, width=None)
    assert "by its own report: A lost link stops the motors\n" in text
    assert "1 clause: 1 pass (1 by its own report)\n" in text
    assert (report.counts.passed, report.counts.by_own_report) == (1, 1)
    (test,) = ElementTree.fromstring(junit.junit_xml(report)).iter("testcase")
    assert test.find("properties/property[@name='by_own_report']").get("value") == "duty"
    assert test.find("system-out").text == "by its own report: nobody saw duty"
    assert provider.opened[0].verdicts == [("pass", "by its own report")]


def test_what_is_wrong_by_the_targets_own_report_is_marked(check, make_provider):
    provider = make_provider(capabilities=(*OF_A_ROVER, "motion reports"))
    report = check(OWN_REPORT.format(holds=False), provider=provider)
    assert report.exit_code == 1
    text = matrix.render(report, colours=False, width=None)
    assert "  cause      by its own report: the motors run on\n" in text
    assert "  not seen   duty\n" in text
    (failure,) = ElementTree.fromstring(junit.junit_xml(report)).iter("failure")
    assert failure.get("message") == "by its own report: the motors run on"


@pytest.mark.parametrize(
    ("more", "missing", "code"), [((), ("duty",), 4), (("duty",), (), 0), (("duty", "motion reports"), (), 0)]
)
def test_nothing_stands_in_for_what_is_seen_or_not_said(check, make_provider, more, missing, code):
    report = check(OWN_REPORT.format(holds=True), provider=make_provider(capabilities=(*OF_A_ROVER, *more)))
    assert (report.cases[0].missing, report.cases[0].by_own_report) == (missing, ())
    assert "own report" not in matrix.render(report, colours=False, width=None) + report.exit_meaning
    assert report.exit_code == code


def test_a_violation_is_not_hidden_behind_what_nobody_saw(check, make_provider):
    body = """
        @my("A1", needs=("world",))
        def test_it(bench):
            pass

        @my("A2")
        def test_other(bench):
            assert False
        """
    report = check(body, provider=make_provider(capabilities=()), strict=True)
    assert (report.exit_code, report.exit_meaning) == (1, "the target violates a clause")


def test_nothing_that_applies_is_not_a_pass(check, make_provider):
    report = check('@my("A1", needs=("gravity",))\ndef test_it(bench): pass\n', provider=make_provider())
    assert report.exit_code == 4
    assert "nothing that was selected applies" in report.exit_meaning


def test_a_clause_counts_once_however_many_parameters_it_sweeps(check):
    report = check(
        """
        @pytest.mark.parametrize("speed", [1, 2, 3])
        @my("A1")
        def test_it(bench, speed):
            assert speed != 2
        """
    )
    assert report.counts.clauses == 1
    assert only(report).verdict is Verdict.FAIL
    assert only(report).case_ids == ("panel/it[1]", "panel/it[2]", "panel/it[3]")
    assert [case.verdict for case in report.cases] == [Verdict.PASS, Verdict.FAIL, Verdict.PASS]


def test_a_case_that_names_the_clause_it_failed_leaves_the_others_open(check, monkeypatch):
    clauses = {
        name: type("C", (), {"id": name, "suite": "p", "level": "must", "title": name, "text": name, "source": "s"})()
        for name in ("B1", "B2")
    }
    monkeypatch.setattr("hilbench.check.planning.find_clause", lambda clause_id: _clause(clauses[clause_id]))
    report = check(
        """
        @case("B1", "B2")
        def test_it(bench):
            raise Violation("wrong", clause="B2")
        """
    )
    assert [clause.verdict for clause in report.clauses] == [Verdict.INCONCLUSIVE, Verdict.FAIL]


def _clause(like):
    from hilbench.check.catalogue import Clause

    return Clause(id=like.id, suite="p", level="must", title=like.id, text=like.id, source="s")


def test_a_lost_target_ends_the_run_and_lists_what_was_not_run(check, provider):
    report = check(
        """
        @my("A1")
        def test_a(bench): pass

        @my("A2")
        def test_b(bench): raise UnavailableError("unplugged", where="/dev/ttyX")

        @my("A3")
        def test_c(bench): pass

        @my("A4", needs=("gravity",))
        def test_d(bench): pass
        """
    )
    assert [case.verdict.value for case in report.cases] == ["pass", "error", "not-run", "not-applicable"]
    assert report.exit_code == 3
    assert report.stopped == "target lost: /dev/ttyX: unplugged"
    assert report.cases[2].cause == "not run: target lost: /dev/ttyX: unplugged"
    assert len(provider.opened) == 2


def test_a_target_that_may_come_back_costs_its_case_and_no_other(check):
    report = check(
        """
        from hilbench.errors import AwayError

        @my("A1")
        def test_a(bench): raise AwayError("the target closed the line", where="/dev/ttyX")

        @my("A2")
        def test_b(bench): pass
        """
    )
    assert [case.verdict.value for case in report.cases] == ["error", "pass"]
    assert (report.exit_code, report.stopped) == (3, "")


def test_a_target_that_cannot_be_opened_is_lost(check, make_provider):
    from hilbench.errors import UnavailableError

    report = check('@my("A1")\ndef test_a(bench): pass\n', provider=make_provider(fail_open=UnavailableError("busy")))
    assert (report.exit_code, report.stopped) == (3, "target lost: busy")


def test_an_interruption_keeps_what_was_run(check, provider):
    report = check(
        """
        @my("A1")
        def test_a(bench): assert False

        @my("A2")
        def test_b(bench): raise KeyboardInterrupt

        @my("A3")
        def test_c(bench): pass
        """
    )
    assert [case.verdict.value for case in report.cases] == ["fail", "not-run", "not-run"]
    assert (report.exit_code, report.stopped) == (130, "interrupted")
    assert provider.closed_cases == 2


def test_an_interruption_between_two_lines_is_one(check, monkeypatch):
    """CPython may have no line number for a frame that a signal has interrupted, and pytest cannot draw it then."""
    usual = TracebackEntry.lineno.fget

    def lineno(entry):
        if entry.frame.code.name == "test_a":
            raise TypeError("unsupported operand type(s) for -: 'NoneType' and 'int'")
        return usual(entry)

    monkeypatch.setattr(TracebackEntry, "lineno", property(lineno))
    report = check('@my("A1")\ndef test_a(bench): raise KeyboardInterrupt\n')
    assert (report.exit_code, report.stopped) == (130, "interrupted")


def test_a_bench_that_breaks_is_a_defect_and_does_not_hide_the_cause(check):
    report = check(
        """
        @my("A1")
        def test_a(bench):
            bench.finish = lambda verdict, cause: 1 / 0
            assert False, "wrong"
        """
    )
    clause = only(report)
    assert (clause.verdict, report.exit_code) == (Verdict.ERROR, 5)
    assert clause.cause == "defect: ZeroDivisionError: division by zero"
    assert "before that: wrong" in " ".join(clause.evidence)


@pytest.mark.parametrize(
    ("body", "shown", "code"),
    [
        ("return ['it came late']", "it came late", 1),
        ("1 / 0", "looking on failed: ZeroDivisionError: division by zero", 1),
        ("raise KeyboardInterrupt", "assert False", 130),
    ],
)
def test_whatever_happens_after_a_failure_the_verdict_stands(check, body, shown, code):
    report = check(
        f"""
        @my("A1")
        def test_a(bench):
            def afterwards(): {body}
            bench.afterwards = afterwards
            assert False, "wrong"

        @my("A2")
        def test_b(bench): pass
        """
    )
    first, second = report.clauses
    assert (first.verdict, first.cause, report.exit_code) == (Verdict.FAIL, "wrong", code)
    assert shown in first.evidence[-1]
    assert second.verdict is (Verdict.NOT_RUN if code == 130 else Verdict.PASS)


def test_a_case_that_ends_the_run_is_a_defect(check):
    report = check('@my("A1")\ndef test_a(bench): pytest.exit("enough")\n')
    assert (report.exit_code, report.stopped) == (5, "a case ended the run: enough")


def test_what_a_case_prints_stays_out_of_the_way(check, capfd):
    check('@my("A1")\ndef test_a(bench):\n    import os\n    print("chatter")\n    os.write(1, b"C chatter")\n')
    assert capfd.readouterr() == ("", "")
