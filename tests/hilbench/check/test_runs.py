"""A run as a whole: order, seeds, hashes, selection, suites, what is refused."""

from __future__ import annotations

import gc
import os
import weakref

import pytest

from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from hilbench.errors import UsageError

TWO = """
    @my("A1")
    def test_first(peer): peer.send(1)

    @pytest.mark.parametrize("n", [1, 2])
    @my("A2")
    def test_second(peer, n): peer.send(n)
    """


def hashes(report):
    return {case.id: case.case_hash for case in report.cases}


def test_equal_runs_have_equal_hashes_and_another_seed_another(check):
    first, again, other = check(TWO), check(TWO), check(TWO, seed=1)
    assert first.run_hash == again.run_hash != other.run_hash
    assert [case.seed for case in first.cases] == [case.seed for case in again.cases]
    assert len({case.seed for case in first.cases}) == 3


def test_selection_does_not_change_the_hash_of_a_case(check):
    whole, part = check(TWO), check(TWO, select="A2")
    assert [case.id for case in part.cases] == ["panel/second[1]", "panel/second[2]"]
    assert hashes(part).items() <= hashes(whole).items()
    assert part.run_hash != whole.run_hash


def test_the_run_hash_is_what_the_documentation_says(check):
    import hashlib

    report = check(TWO)
    lines = "".join(f"{name}:{value}\n" for name, value in sorted(hashes(report).items()))
    assert report.run_hash == hashlib.sha256(lines.encode()).hexdigest()


def test_seeds_of_cases_do_not_depend_on_anything_but_run_seed_and_id():
    from hilbench.judging.provider import case_seed

    # printf '0\npanel/first' | sha256sum; the first 16 digits, halved
    assert case_seed(0, "panel/first") == 5585696330953208524


def test_the_command_that_reproduces_a_clause_finds_it_again(check, provider, write_suite):
    report = check(TWO, bench="my bench", seed=7, timeout_scale=2.0)
    suite = write_suite(TWO)
    expected = f"hilbench check 'my bench' --suite {suite} -k A1 --seed 7 --timeout-scale 2"
    assert report.clauses[0].reproduce == expected


def test_nothing_selected_is_wrong_usage(check):
    with pytest.raises(UsageError, match="nothing is selected"):
        check(TWO, select="A9")


def test_a_list_runs_nothing(write_suite, provider):
    suite = write_suite('@my("A1", bench_time_s=1.5, needs=("gravity",))\ndef test_a(bench): assert False\n')
    (planned,) = list_cases(CheckOptions(suites=(str(suite),)), provider)
    assert (planned.id, planned.bench_time_s, planned.missing) == ("panel/a", 1.5, ("gravity",))
    assert provider.opened == []


def test_a_folder_is_a_suite_of_its_test_files(write_suite, tmp_path, provider):
    write_suite('@my("A1")\ndef test_a(bench): pass\n', "test_one.py")
    write_suite('@my("B1")\ndef test_a(bench): pass\n', "test_two.py")
    write_suite("raise RuntimeError('not a suite')\n", "helper.py")
    report = run_suites(CheckOptions(suites=(str(tmp_path),)), provider)
    assert [clause.suite for clause in report.clauses] == ["one", "two"]


def test_two_suites_of_one_name_are_refused(write_suite, tmp_path, provider):
    (tmp_path / "other").mkdir()
    for name in ("test_one.py", "other/test_one.py"):
        write_suite('@my("A1")\ndef test_a(bench): pass\n', name)
    with pytest.raises(UsageError, match="rename one suite"):
        run_suites(CheckOptions(suites=(str(tmp_path),)), provider)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("def test_a(bench): pass\n", "has no @case"),
        ('@case("NOSUCH1")\ndef test_a(bench): pass\n', "'NOSUCH1', which no catalogue holds"),
        ("import no_such_module\n", "cannot be read: .*no_such_module"),
        ("def broken(:\n", "cannot be read: .*SyntaxError"),
        ("@case()\ndef test_a(bench): pass\n", "at least one clause"),
        ('@case("A", "B", text="x")\ndef test_a(bench): pass\n', "text= defines one clause"),
        ('@case("A", text="x", needs="world")\ndef test_a(bench): pass\n', "is a collection"),
    ],
)
def test_a_suite_that_is_wrong_is_wrong_usage_in_one_line(check, body, message):
    with pytest.raises(UsageError, match=message) as raised:
        check(body)
    assert "\n" not in str(raised.value)
    assert "test_panel.py" in str(raised.value) or "panel/" in str(raised.value)


def test_the_title_of_a_clause_defined_in_place_is_its_first_sentence(check):
    report = check('@case("A1", text="It is lit. Always.", source="rev. C")\ndef test_a(bench): pass\n')
    assert (report.clauses[0].title, report.clauses[0].text) == ("It is lit", "It is lit. Always.")


def test_surroundings_do_not_reach_the_engine(check, monkeypatch, tmp_path):
    (tmp_path / "conftest.py").write_text("raise RuntimeError('conftest was read')\n")
    (tmp_path / "pytest.ini").write_text("[pytest]\naddopts = --no-such-option\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTEST_ADDOPTS", "--no-such-option")
    monkeypatch.setenv("PYTEST_PLUGINS", "no_such_plugin")
    report = check(TWO)
    assert report.exit_code == 0
    assert os.environ["PYTEST_ADDOPTS"] == "--no-such-option"


def test_progress_names_each_case_before_it_runs(write_suite, provider):
    told = []
    suite = write_suite(TWO)
    run_suites(
        CheckOptions(suites=(str(suite),)),
        provider,
        on_case=lambda case, number, total: told.append((case.id, number, total)),
    )
    assert told == [("panel/first", 1, 3), ("panel/second[1]", 2, 3), ("panel/second[2]", 3, 3)]


def test_the_worst_margin_is_the_one_nearest_to_its_limit(check):
    report = check(
        """
        @my("A1")
        def test_first(bench):
            at_most(0.1, 0.2, unit="s", what="answer")
            at_most(90.0, 100.0, unit="mm", what="distance")
            record_measure("speed", 3.0, "mm/s")
        """
    )
    assert report.clauses[0].worst_margin.name == "distance"
    assert [measure.margin for measure in report.cases[0].measures] == [0.1, 10.0, None]
    assert report.clauses[0].verdict is Verdict.PASS


def test_a_clause_that_two_suites_check_counts_once(write_suite, tmp_path, provider):
    write_suite('@my("A1")\ndef test_a(bench): pass\n', "test_one.py")
    write_suite('@my("A1")\ndef test_b(bench): assert False\n@my("A2")\ndef test_c(bench): pass\n', "test_two.py")
    report = run_suites(CheckOptions(suites=(str(tmp_path),)), provider)
    assert [(clause.id, clause.suite, clause.verdict.value) for clause in report.clauses] == [
        ("A1", "one", "fail"),
        ("A2", "two", "pass"),
    ]
    assert report.clauses[0].reproduce.count("--suite") == 2


def test_one_id_for_two_clauses_is_refused(check):
    with pytest.raises(UsageError, match="defines the clause 'A1', which is already"):
        check('@my("A1")\ndef test_a(bench): pass\n@my("A1", level="should")\ndef test_b(bench): pass\n')


@pytest.mark.parametrize("option", ["junit", "json", "journal"])
def test_a_file_that_cannot_be_written_is_found_out_before_the_run(write_suite, provider, tmp_path, option):
    from hilbench.check import run_check

    suite = write_suite('@my("A1")\ndef test_a(bench): pass\n')
    file = tmp_path / "none" / "file"
    options = CheckOptions(suites=(str(suite),), **{option: str(file) if option == "json" else file})
    with pytest.raises(UsageError, match=f"^--{option} {file}: there is no folder"):
        run_check(options, lambda _: provider)
    assert provider.opened == []


def test_a_case_on_several_benches_is_a_case_on_each(check, make_provider):
    provider = make_provider(["program 'slow'"])
    report = check(
        """
        @my("A1", setups={"slow": CaseSetup(program="slow"), "fast": CaseSetup(program="fast")})
        def test_both(bench):
            bench.pass_time(0.1)
        """,
        provider=provider,
    )
    verdicts = {case.id: (case.verdict.value, case.cause) for case in report.cases}
    assert verdicts["panel/both[slow]"][0] == "pass"
    assert verdicts["panel/both[fast]"][0] == "not-applicable"
    assert [bench.case.setup.program for bench in provider.opened] == ["slow"]
    (clause,) = report.clauses
    assert clause.verdict.value == "pass"


def test_no_bench_is_kept_when_its_case_is_over(check, make_provider):
    provider = make_provider()
    alive = weakref.WeakSet()
    counts = []

    class Counted(list):
        def append(self, bench):
            gc.collect()
            counts.append(len(alive))
            alive.add(bench)

    provider.opened = Counted()
    gc.freeze()  # what there is already need not be looked through each time
    try:
        report = check(TWO + '\n    @my("A3")\n    def test_wrong(peer): assert False\n', provider=provider)
    finally:
        gc.unfreeze()
    assert [case.verdict for case in report.cases].count(Verdict.FAIL) == 1
    assert counts == [0, 0, 0, 0]
