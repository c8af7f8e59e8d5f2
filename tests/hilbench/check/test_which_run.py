"""Which cases run: up to some failures, those that did not pass last time, those that were inconclusive once more."""

from __future__ import annotations

import itertools
import threading

import pytest

from hilbench.check import CheckOptions, Verdict, run_check, run_suites
from hilbench.check.heartbeat import Heartbeat
from hilbench.check.report import footer, junit
from hilbench.terminal.console import Console

BODY = """
    @my("A1")
    def test_a(): pass

    @my("A2", level="should")
    def test_b(): raise Violation("untidy")

    @my("A3")
    def test_c(): raise Violation("c")

    @my("A4")
    def test_d(): raise UnavailableError("x") if 0 else Violation("d")

    @my("A5")
    def test_e(): pass
    """


class TestALog:
    def beating(self, wanted):
        """A heartbeat, the lines it says, and an event for so many of them."""
        lines, enough = [], threading.Event()

        def say(line):
            lines.append(line)
            if len(lines) == wanted:
                enough.set()

        return Heartbeat(say, every_s=0.001), lines, enough

    def test_that_stands_still_gets_a_line(self):
        heartbeat, lines, enough = self.beating(3)
        with heartbeat:
            heartbeat.show("1/9 S1 a")
            assert enough.wait(60)
        assert set(lines) == {"running 1/9 S1 a"}

    def test_in_which_something_is_said_gets_none(self):
        heartbeat, lines, _ = self.beating(1)
        heartbeat.show("1/9 S1 a")
        waits = iter([False] * 5 + [True])
        heartbeat._over.wait = lambda _every_s: heartbeat.spoke() or next(waits)
        heartbeat._beat()
        assert not lines


class TestFailures:
    @pytest.mark.parametrize(
        ("most", "strict", "run"), [(0, False, 5), (1, False, 3), (2, False, 4), (3, False, 5), (1, True, 2)]
    )
    def test_end_the_run(self, check, most, strict, run):
        report = check(BODY, max_failures=most, strict=strict)
        assert sum(case.verdict is not Verdict.NOT_RUN for case in report.cases) == run
        assert bool(report.stopped) is (run < 5)
        assert report.exit_code == 1

    def test_of_a_should_alone_do_not(self, check):
        body = '@my("A1", level="should")\ndef test_a(): raise Violation("x")\n\n@my("A2")\ndef test_b(): pass\n'
        assert check(body, max_failures=1).stopped == ""


class TestLastFailed:
    @pytest.fixture(autouse=True)
    def cache(self, monkeypatch, tmp_path):
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
        return tmp_path / "cache" / "hilbench" / "last-failed"

    @pytest.fixture
    def run(self, write_suite, provider, capsys, tmp_path):
        """Run a suite as the command does; return what was said."""
        made = itertools.count()

        def run(body=BODY, **options):
            folder = tmp_path / str(next(made))
            folder.mkdir()
            suite = write_suite(body, f"{folder.name}/test_panel.py")
            options = CheckOptions(suites=(str(suite),), json=str(folder / "report.json"), **options)
            run_check(options, lambda _options: provider, Console())
            return capsys.readouterr().err

        return run

    def test_runs_what_did_not_pass(self, run):
        run()
        said = run(last_failed=True)
        assert "--last-failed: 3 of 5 cases did not pass last time" in said
        assert [number for number in "12345" if "/3 " in said and f"A{number} " in said] == ["2", "3", "4"]

    def test_one_of_a_class_and_of_parameters_is_found_again(self, run):
        body = """
            import pytest

            class TestOpen:
                @my("A1")
                @pytest.mark.parametrize("way", ["a/b.c", "d"])
                def test_opened(self, way):
                    if way != "d": raise Violation(way)

                @my("A2")
                def test_closed(self): pass
            """
        run(body)
        assert "1/1 fail A1 panel/TestOpen.opened[a/b.c]" in run(body, last_failed=True)

    def test_a_case_that_has_passed_since_is_not_among_them(self, run):
        run()
        run(BODY.replace('raise Violation("c")', "pass"), last_failed=True)
        assert "2 of 5" in run(last_failed=True)

    def test_of_another_bench_or_target_nothing_is_known(self, run):
        run()
        assert "no case is known to have failed here; 5 are run" in run(last_failed=True, bench="rover")

    def test_a_selection_is_kept_to(self, run):
        run()
        assert "1 of 1" in run(last_failed=True, select="A3")
        assert "no case is known to have failed here; 1 are run" in run(last_failed=True, select="A1")

    def test_what_was_not_reached_stays_known(self, run):
        run()
        run(max_failures=1, last_failed=True)
        assert "3 of 5" in run(last_failed=True)

    def test_a_cache_of_junk_is_none(self, run, cache):
        run()
        (file,) = cache.iterdir()
        for junk in ("", "{", "[]", '{"cases": 1}', "\0"):
            file.write_text(junk)
            assert "no case is known" in run(last_failed=True)

    def test_a_cache_that_cannot_be_written_is_no_error(self, run, cache):
        cache.parent.mkdir(parents=True)
        cache.write_text("")
        run()
        assert "no case is known" in run(last_failed=True)


AGAIN = """
    tries = []

    @my("A1")
    def test_late(bench):
        tries.append(bench)
        if len(tries) < {passes}: raise Inconclusive(f"late {{len(tries)}}")
        {then}

    @my("A2")
    def test_fails(bench): raise Violation("x")
    """


class TestInconclusive:
    @pytest.fixture
    def run(self, write_suite, make_provider, late):
        real = make_provider(bench=type("RealBench", (late.bench,), {"case_hash": lambda _self: ""}))

        def run(passes, again, then="pass", provider=real):
            provider.opened.clear()
            file = write_suite(AGAIN.format(passes=passes, then=then))
            options = CheckOptions(suites=(str(file),), rerun_inconclusive=again)
            return run_suites(options, provider), len(provider.opened)

        return run

    def test_is_run_again_until_it_is_judged_and_that_is_seen(self, run):
        report, opened = run(3, 5)
        assert [case.verdict for case in report.cases] == [Verdict.PASS, Verdict.FAIL]
        assert report.cases[0].reruns == ("late 1", "late 2")
        assert opened == 4
        assert footer.lines(report)[-1] == "run again, as they were inconclusive: panel/late 2 times: late 2"
        assert '<property name="reruns" value="2" />' in junit.junit_xml(report)

    def test_stays_inconclusive_after_so_many(self, run):
        report, opened = run(9, 2)
        assert report.cases[0].verdict is Verdict.INCONCLUSIVE
        assert (report.cases[0].reruns, opened) == (("late 1", "late 2"), 4)

    def test_that_fails_then_has_failed(self, run):
        report, _ = run(2, 5, then='raise Violation("wrong")')
        assert (report.cases[0].verdict, report.exit_code) == (Verdict.FAIL, 1)

    def test_in_virtual_time_is_not_run_again(self, run, provider):
        report, opened = run(2, 5, provider=provider)
        assert report.cases[0].verdict is Verdict.INCONCLUSIVE
        assert (report.cases[0].reruns, opened) == ((), 2)
