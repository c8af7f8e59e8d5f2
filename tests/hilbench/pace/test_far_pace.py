"""How well the bench behind a port keeps up: what is told of it, how it is found, and what waits and times become."""

from __future__ import annotations

import fcntl
import os
import pty
import subprocess
import sys
from contextlib import ExitStack, closing

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.bench import Bench
from hilbench.clock import SLIP_THRESHOLD_NS, Scheduler
from hilbench.journal import Journal
from hilbench.pace.far_pace import FarPace, ends_of, is_local, place_of
from hilbench.pace.lateness import IN_TIME, Lateness
from hilbench.pace.notice import PaceNotice, notices
from hilbench.testing import FakeHostClock
from tests.each import each

MS = 1_000_000
BORN_NS = 1_000_000 * MS


@pytest.fixture(autouse=True)
def runtime(tmp_path, monkeypatch):
    """A runtime folder that no other bench tells anything in."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    return tmp_path / "hilbench" / "pace"


def ran_late(told, late_ns, done_ns):
    """Tell of an entry that began as late as it was done, at a moment of the host, in ns."""
    told.ran(done_ns - late_ns, done_ns, done_ns, spoke=0)


@pytest.fixture
def ptys():
    """As many pseudo-terminals as are asked for, by name."""
    with ExitStack() as stack:

        def made():
            master, slave = pty.openpty()
            stack.callback(os.close, master)
            stack.callback(os.close, slave)
            return os.ttyname(slave)

        yield made


@pytest.fixture
def notice():
    with ExitStack() as stack:
        yield lambda *doors, **more: stack.enter_context(
            PaceNotice(BORN_NS, [place_of(door) for door in doors], **more)
        )


class TestPlaces:
    def test_a_pseudo_terminal_is_one_place_whatever_it_is_called(self, ptys, tmp_path):
        one, other = ptys(), ptys()
        (tmp_path / "board").symlink_to(one)
        assert place_of(str(tmp_path / "board")) == place_of(one) == place_of(f"spy://{one}?file=x") is not None
        assert place_of(other) not in (None, place_of(one))

    @pytest.mark.parametrize(
        "where", ["socket://127.0.0.1:8101", "socket://[::1]:8101", "rfc2217://localhost:8101?ign"]
    )
    def test_a_tcp_port_of_this_host_is_a_place(self, where):
        assert place_of(where) == "tcp 8101"

    @each("where", ["/dev/null", "/dev/gone", __file__, "socket://192.0.2.1:8101", "socket://0.0.0.0:8101", "socket://127.0.0.1",
         "socket://127.0.0.1:x", "/dev/pts/0\0", "socket://[127.0.0.1]:1", "loop://", "hwgrep://0403"])  # fmt: skip
    def test_nothing_else_is(self, where):
        assert place_of(where) is None

    def test_a_name_that_nobody_knows_is_not_of_this_host(self):
        assert not is_local("no-such-host.invalid")


class TestNotices:
    def test_who_tells_nothing_is_not_late(self, ptys):
        far = FarPace(ptys())
        assert far.lateness(BORN_NS, BORN_NS + 100 * MS) == IN_TIME
        assert far.life_since(BORN_NS)(BORN_NS + 7) == 7

    @given(st.lists(st.tuples(st.integers(0, 60 * MS), st.integers(0, 1000)), max_size=20), st.integers(0, 1000))
    def test_the_latest_since_a_moment_is_never_understated_and_little_overstated(self, ran, since_ms):
        with PaceNotice(BORN_NS, ["a"]) as told:
            told.due(BORN_NS + 10_000 * MS)
            for late_ns, at_ms in sorted(ran, key=lambda one: one[1]):
                ran_late(told, late_ns, BORN_NS + at_ms * MS)
            (reader,) = notices()
            since_ns = BORN_NS + since_ms * MS
            found_ns = reader.lateness(since_ns, BORN_NS + 1000 * MS).late_ns
            # The time at which a lateness was last seen is kept for all that are about as large.
            assert found_ns >= max((late for late, at_ms in ran if at_ms >= since_ms), default=0)
            assert found_ns <= max((late for late, at_ms in ran if at_ms >= since_ms - 10), default=0) * 9 / 8 + 1

    @given(
        st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9), st.integers(0, 9)), min_size=1, max_size=30),
        st.data(),
    )
    def test_when_what_was_sent_was_due_is_among_what_is_told(self, entries, data):
        """Entries one behind the other; each is that many ticks after the last, so late, and takes so long."""
        with PaceNotice(0, ["a", "b"]) as told:
            now, runs = 0, []
            for after, late, takes in entries:
                due, began = now + after, now + after + late
                now = began + takes
                told.due(due)
                told.ran(due, began, now, spoke=1 if takes else 3)
                told.ran(now, now, now, spoke=2)  # by another door
                runs.append((due, began, now))
            told.due(now + 100)
            due, began, done = data.draw(st.sampled_from(runs))
            written = data.draw(st.integers(began, done))
            after, by = written - data.draw(st.integers(0, 20)), written + data.draw(st.integers(0, 20))
            (reader,) = notices()
            earliest, latest = reader.due_between("a", after, by)
            assert earliest <= due <= latest
            ran = [due for due, began, done in runs if began <= by and done >= after]
            assert (earliest, latest) == (min(ran), max(ran))

    def test_what_is_being_sent_right_now_counts_and_what_sent_nothing_does_not(self, ptys):
        where = ptys()
        with PaceNotice(0, [place_of(where)], step_ns=3) as told:
            told.ran(100, 110, 120, spoke=1)
            told.ran(121, 122, 130, spoke=0)
            told.due(140)
            far = FarPace(where)
            assert far.due_between(115, 130) == (97, 103)
            assert far.due_between(125, 150) == (137, 143)  # due, and not said to be done
            assert far.due_between(121, 139) is None
            for moment in range(200, 2000):
                told.ran(moment, moment, moment, spoke=1)
            assert far.due_between(115, 130) is None  # no longer remembered

    def test_of_what_one_hands_on_to_another_nobody_tells_when_it_was_due(self, ptys, notice):
        here, there, alone = ptys(), ptys(), ptys()
        for told in (notice(here, behind=[there]), notice(there), notice(alone)):
            told.ran(BORN_NS + 1, BORN_NS + 2, BORN_NS + 3, spoke=1)
            told.due(BORN_NS + 9)
        assert FarPace(alone).due_between(BORN_NS, BORN_NS + 5) == (BORN_NS + 1, BORN_NS + 1)
        assert FarPace(here).due_between(BORN_NS, BORN_NS + 5) is None

    @given(st.lists(st.tuples(st.integers(1, 900), st.integers(51, 400)), max_size=30), st.integers(0, 30_000))
    def test_all_time_that_was_lost_since_a_moment_is_told(self, slips, since_ms):
        with PaceNotice(BORN_NS, ["a"]) as told:
            now_ms, lost = 0, []
            for wait_ms, slip_ms in slips:
                now_ms += wait_ms + slip_ms
                told.slipped(slip_ms * MS, BORN_NS + now_ms * MS)
                lost.append((now_ms, slip_ms))
            told.due(BORN_NS + 1_000_000 * MS)
            (reader,) = notices()
            found = reader.lateness(BORN_NS + since_ms * MS, BORN_NS + 100_000 * MS).lost_ns
            assert found == sum(ms for at_ms, ms in lost if at_ms >= since_ms - 10) * MS

    def test_more_losses_than_are_remembered_are_all_counted(self):
        with PaceNotice(BORN_NS, ["a"]) as told:
            for number in range(600):
                told.slipped(MS, BORN_NS + number * 1000 * MS)
            (reader,) = notices()
            now_ns = BORN_NS + 599 * 1000 * MS
            assert reader.lateness(now_ns, now_ns).lost_ns == MS
            assert reader.lateness(BORN_NS + 20_000 * MS, now_ns).lost_ns == 600 * MS

    def test_who_hangs_is_late_by_that_and_lives_no_further(self, ptys, notice):
        where = ptys()
        told, far = notice(where), FarPace(where)
        told.due(BORN_NS + 5 * MS)
        life = far.life_since(BORN_NS)
        assert [life(BORN_NS + ms * MS) for ms in (0, 3, 5, 90)] == [0, 3 * MS, 5 * MS, 5 * MS]
        assert far.lateness(BORN_NS + 10 * MS, BORN_NS + 90 * MS) == Lateness(late_ns=85 * MS)

    def test_who_looks_is_not_behind_the_port_that_it_has_opened(self, ptys, notice):
        where = ptys()
        notice(behind=(where,)).due(BORN_NS)
        assert FarPace(where).lateness(BORN_NS, BORN_NS + 90 * MS) == Lateness(late_ns=90 * MS)
        assert FarPace(where, but_of=os.getpid()).lateness(BORN_NS, BORN_NS + 90 * MS) == IN_TIME

    def test_lost_time_is_no_life(self, ptys, notice):
        where = ptys()
        told, far = notice(where), FarPace(where)
        told.due(BORN_NS + 5 * MS)
        life = far.life_since(BORN_NS)
        told.slipped(300 * MS, BORN_NS + 305 * MS)
        assert life(BORN_NS + 305 * MS) == 5 * MS
        told.due(BORN_NS + 310 * MS)
        assert life(BORN_NS + 310 * MS) == 10 * MS

    def test_before_it_runs_nobody_is_there(self, ptys, notice):
        where = ptys()
        notice(where).due(BORN_NS + 1000 * MS)
        assert FarPace(where).lateness(BORN_NS - 500 * MS, BORN_NS).lost_ns == 500 * MS

    def test_how_far_it_runs_ahead_counts(self, ptys, notice):
        where = ptys()
        notice(where, step_ns=MS).due(BORN_NS + 1000 * MS)
        assert FarPace(where).lateness(BORN_NS + 10 * MS, BORN_NS + 20 * MS) == Lateness(late_ns=MS)

    def test_one_that_has_ended_is_looked_for_again(self, ptys, notice):
        where, far = ptys(), None
        with PaceNotice(BORN_NS, [place_of(where)]):
            far = FarPace(where)
            life = far.life_since(BORN_NS)
            assert far.lateness(BORN_NS + 10 * MS, BORN_NS + 50 * MS).late_ns == 50 * MS
        assert far.lateness(BORN_NS + 10 * MS, BORN_NS + 50 * MS) == IN_TIME
        assert life(BORN_NS + 50 * MS) == 50 * MS  # nothing is waited for that will not come
        notice(where)
        assert far.lateness(BORN_NS + 10 * MS, BORN_NS + 50 * MS).late_ns == 50 * MS

    def test_one_that_is_killed_is_believed_no_longer_and_the_next_is_found(self, ptys, notice):
        where = ptys()
        program = (
            "import sys; from hilbench.pace.notice import PaceNotice; from hilbench.pace.far_pace import place_of;"
            f"told = PaceNotice({BORN_NS}, [place_of(sys.argv[1])]); print(flush=True); sys.stdin.read()"
        )
        command = [sys.executable, "-c", program, where]
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as bench:
            bench.stdout.readline()
            far = FarPace(where)
            life = far.life_since(BORN_NS)
            assert far.lateness(BORN_NS + 10 * MS, BORN_NS + 900 * MS).late_ns == 900 * MS  # it hangs, but is there
            assert life(BORN_NS + 900 * MS) == 0
            bench.kill()
        assert life(BORN_NS + 900 * MS) == 900 * MS  # nothing is waited for that will not come
        assert far.lateness(BORN_NS + 10 * MS, BORN_NS + 900 * MS) == IN_TIME
        notice(where).due(BORN_NS + 1000 * MS)
        assert far.lateness(BORN_NS + 10 * MS, BORN_NS + 900 * MS) == IN_TIME
        assert far.life_since(BORN_NS + 900 * MS)(BORN_NS + 1200 * MS) == 100 * MS

    def test_what_no_longer_is_looked_at_is_closed(self, notice, ptys):
        notice(ptys())
        before = os.listdir("/proc/self/fd")
        for _ in range(5):
            assert len([*notices()]) == 1
        assert len(os.listdir("/proc/self/fd")) == len(before)

    def test_what_somebody_left_behind_who_was_killed_is_removed(self, ptys, runtime):
        where = ptys()
        program = (
            "import os, sys; from hilbench.pace.notice import PaceNotice; from hilbench.pace.far_pace import place_of;"
            f"PaceNotice({BORN_NS}, [place_of(sys.argv[1])]); os.kill(os.getpid(), 9)"
        )
        assert subprocess.run([sys.executable, "-c", program, where], check=False).returncode == -9
        assert len([*runtime.iterdir()]) == 1
        assert FarPace(where).lateness(BORN_NS + 10 * MS, BORN_NS + 50 * MS) == IN_TIME
        assert not [*runtime.iterdir()]

    def test_what_is_no_notice_is_passed_over(self, ptys, notice, runtime):
        where = ptys()
        notice(where)
        with (runtime / "1-x").open("w") as file:
            file.write("{}")
            file.flush()
            fcntl.flock(file, fcntl.LOCK_EX)
            assert [reader.doors for reader in notices()] == [(place_of(where),)]

    def test_what_is_no_file_is_passed_over_and_not_waited_for(self, ptys, notice, runtime):
        where = ptys()
        told = notice(where)
        (runtime / "1-link").symlink_to(told.path)
        (runtime / "1-folder").mkdir()
        os.mkfifo(runtime / "1-pipe")
        with os.fdopen(os.open(runtime / "1-pipe", os.O_RDWR)):  # who opens it to read waits for nobody
            assert [reader.name for reader in notices()] == [told.path.name]

    def test_what_was_never_finished_is_removed_once_it_is_old_and_nobody_has_it(self, ptys, notice, runtime):
        made = notice(ptys()).path.stat().st_mtime
        for name, age_s in ((".old", 61), (".held", 61), (".new", 0)):
            (runtime / name).touch()
            os.utime(runtime / name, (made - age_s, made - age_s))
        with (runtime / ".held").open() as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            notice(ptys())
        assert {path.name for path in runtime.iterdir() if path.name.startswith(".")} == {".held", ".new"}

    def test_a_folder_that_others_can_look_into_is_not_believed(self, ptys, notice, runtime):
        where = ptys()
        notice(where)
        runtime.chmod(0o755)
        assert not [*notices()]


class TestChains:
    def test_a_proxy_hands_on_what_is_behind_it(self, ptys, notice, tmp_path):
        here, there = ptys(), ptys()
        (tmp_path / "there").symlink_to(there)
        for told, late_ms in ((notice(here, behind=[str(tmp_path / "there")]), 3), (notice(there), 20)):
            told.due(BORN_NS + 1000 * MS)
            ran_late(told, late_ms * MS, BORN_NS + 100 * MS)
        late_ns = FarPace(here).lateness(BORN_NS + 50 * MS, BORN_NS + 200 * MS).late_ns
        assert 23 * MS <= late_ns <= 26 * MS
        assert 20 * MS <= FarPace(there).lateness(BORN_NS + 50 * MS, BORN_NS + 200 * MS).late_ns <= 26 * MS

    def test_a_bench_that_starts_behind_a_proxy_is_found_and_so_is_the_next(self, ptys, notice):
        here, there = ptys(), ptys()
        notice(here, behind=[there, "/dev/ttyUSB7"]).due(BORN_NS + 9000 * MS)
        far, since_ns = FarPace(here), BORN_NS + 100 * MS
        assert far.lateness(since_ns, since_ns) == IN_TIME
        for _ in range(2):
            with PaceNotice(BORN_NS, [place_of(there)]) as bench:
                bench.slipped(300 * MS, since_ns)
                assert far.lateness(since_ns, since_ns).lost_ns == 300 * MS
            assert far.lateness(since_ns, since_ns) == IN_TIME

    def test_who_comes_to_a_port_that_somebody_stands_behind_is_found_within_a_second(self, ptys, notice):
        where = ptys()
        notice(where).due(BORN_NS + 9000 * MS)
        far, now_ns = FarPace(where), BORN_NS + 100 * MS
        assert far.lateness(now_ns, now_ns) == IN_TIME
        notice(ptys(), behind=[where]).due(now_ns)
        assert far.lateness(now_ns, now_ns + 1000 * MS).late_ns == 1000 * MS

    def test_who_has_opened_our_door_counts_as_well_as_whoever_serves_one(self, ptys, notice):
        ours, theirs = ptys(), ptys()
        notice(theirs, behind=[ours])
        assert FarPace(ours).lateness(BORN_NS + 10 * MS, BORN_NS + 50 * MS).late_ns == 50 * MS

    def test_where_a_port_leads_at_last(self, ptys, notice):
        here, there, behind = ptys(), ptys(), "/dev/ttyUSB7"
        assert ends_of(here) == [here]
        assert ends_of(behind) == [behind]
        notice(here, behind=[there])
        notice(there, behind=[behind])
        assert ends_of(here) == ends_of(there) == [behind]

    def test_a_circle_has_an_end(self, ptys, notice):
        one, other = ptys(), ptys()
        notice(one, behind=[other])
        notice(other, behind=[one])
        assert FarPace(one).lateness(BORN_NS + 10 * MS, BORN_NS + 50 * MS).late_ns == 100 * MS


class Rig:
    """Two benches with one host clock: the far one tells the near one how it keeps up."""

    def __init__(self, where):
        self.clock = FakeHostClock()
        self.near, self.far = Bench(Scheduler(), Journal()), Scheduler()
        self.notice = PaceNotice(self.clock.monotonic_ns(), [place_of(where)])
        self.far.lock(self.clock, listener=self.notice)
        self.near.scheduler.lock(self.clock)
        self.near.port_floor_s = 0.0
        self.near.far.append(FarPace(where))

    def close(self):
        self.notice.close()


@pytest.fixture
def rig(ptys):
    with closing(Rig(ptys())) as rig:
        yield rig


class TestTimes:
    def test_a_scheduler_tells_what_its_lateness_is(self, rig):
        rig.clock.stall(rig.clock.monotonic_ns() + 10 * MS, 27 * MS)
        rig.far.run_for(100 * MS)
        assert rig.far.lateness_max_ns(0) <= rig.near.far_lateness(0).late_ns <= 31 * MS
        assert rig.near.far_lateness(0).lost_ns == 0

    def test_a_scheduler_tells_when_its_time_stood_still(self, rig):
        rig.clock.stall(rig.clock.monotonic_ns() + 10 * MS, 300 * MS)
        rig.far.run_for(100 * MS)
        assert rig.near.far_lateness(0).lost_ns == rig.far.slipped_ns > SLIP_THRESHOLD_NS

    def test_what_the_far_bench_was_late_by_makes_a_time_less_certain(self, rig):
        rig.near.scheduler.run_for(200 * MS)
        rig.far.run_for(10 * MS)
        since_ns = rig.near.now_ns
        before_s = rig.near.uncertainty_s(since_ns)
        ran_late(rig.notice, 27 * MS, rig.clock.monotonic_ns())
        assert 0.027 <= rig.near.uncertainty_s(since_ns) - before_s <= 0.031

    def test_of_several_ports_the_latest_counts(self, rig, ptys, notice):
        where = ptys()
        told = notice(where)
        told.due(rig.clock.monotonic_ns() + 1000 * MS)
        ran_late(told, 40 * MS, rig.clock.monotonic_ns())
        rig.near.far.append(FarPace(where))
        assert 40 * MS <= rig.near.far_lateness(0).late_ns <= 45 * MS


class Slow:
    """A far bench for which only a part of the host's time passes."""

    def __init__(self, share):
        self.share = share

    def lateness(self, since_ns, now_ns):
        return Lateness(lost_ns=round((now_ns - since_ns) * (1 - self.share)))

    def life_since(self, begin_ns):
        return lambda now_ns: round((now_ns - begin_ns) * self.share)


def slow_bench(share):
    bench = Bench(Scheduler(), Journal())
    bench.scheduler.lock(FakeHostClock())
    bench.far.append(Slow(share))
    return bench


class TestWaits:
    @given(st.floats(0.1, 1), st.lists(st.tuples(st.floats(0.01, 1), st.floats(0, 9)), min_size=1, max_size=8))
    def test_as_much_time_passes_for_a_slow_bench_as_is_waited(self, share, waits_s):
        bench = slow_bench(share)
        for wait_s, limit_s in waits_s:
            bench.run_for(wait_s)
            assert bench.run_until(lambda: True, limit_s)  # which takes no time
        waits_s = [wait_s for wait_s, _ in waits_s]
        assert sum(waits_s) - 0.001 <= bench.now_s * share <= sum(waits_s) + 0.001
        assert bench.far_lived(0)

    def test_it_may_answer_late(self):
        bench = slow_bench(0.25)
        assert bench.run_until(lambda: bench.now_s >= 0.7, 0.2)
        assert not bench.run_until(lambda: False, 0.2)
        assert bench.now_s == pytest.approx(0.7 + 0.8, abs=0.005)

    def test_one_that_stands_still_is_not_waited_for_for_ever_and_it_is_told(self):
        bench = slow_bench(0.0)
        bench.run_for(0.1)
        assert bench.now_s <= 2.0
        assert not bench.far_lived(0)
        assert bench.far_lived(bench.now_ns)  # the next case begins at that very moment

    @pytest.mark.parametrize("share", [0.0, 0.04])
    @pytest.mark.parametrize(("wait_s", "most_s"), [(0.1, 1.1), (1.0, 1.0), (11.0, 11.0)])
    def test_who_does_not_get_on_is_given_up_behind_one_whole_wait(self, share, wait_s, most_s):
        bench = slow_bench(share)
        for waits in (1, 2):
            began_ns = bench.now_ns
            bench.run_for(wait_s)
            assert bench.now_s <= waits * most_s
            assert not bench.far_lived(began_ns)

    def test_who_pauses_for_less_than_a_second_is_waited_for(self):
        bench = slow_bench(1.0)
        bench.far[0].life_since = lambda begin_ns: lambda now_ns: max(0, now_ns - begin_ns - 900 * MS)
        bench.run_for(0.1)
        assert bench.now_s == pytest.approx(1.0, abs=0.001)
        assert bench.far_lived(0)

    def test_without_a_far_bench_a_wait_is_as_long_as_asked(self):
        bench = Bench(Scheduler(), Journal())
        bench.run_for(0.1)
        assert not bench.run_until(lambda: False, 0.1)
        assert (bench.now_s, bench.far_lived(0)) == (0.2, True)
