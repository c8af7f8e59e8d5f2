"""What dead dashboards and benches leave behind is cleared away by the next start, and nothing else is."""

from __future__ import annotations

import os

import pytest

from hilbench.driving.local_socket import listen_at
from hilbench.live.folders import Session, new_session

HOUR_S = 3600
WHOLE = '{"kind":"journal"}\n{"ns":1,"kind":"host-end","source":"journal"}\n'
CUT = '{"kind":"journal"}\n{"ns":1,"kind":"rx"}\n'


@pytest.fixture
def left(tmp_path, monkeypatch):
    """Make a folder as a bench leaves it."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))

    def make(journal, age_s):
        session = new_session("old")
        session.about.write_text("{}")
        if journal is not None:
            session.journal.write_text(journal)
        now_s = session.folder.stat().st_mtime
        for path in (*session.folder.iterdir(), session.folder):
            os.utime(path, (now_s - age_s, now_s - age_s))
        return session

    return make


@pytest.mark.parametrize(
    ("journal", "age_s", "stays"),
    [
        (WHOLE, 120, False),
        (None, 120, False),
        (WHOLE, 30, True),  # it may just be beginning
        (CUT, HOUR_S, True),
        (CUT, 25 * HOUR_S, False),
    ],
)
def test_a_folder_of_nobody_is_cleared_away_and_one_that_says_why_a_bench_died_after_a_day(left, journal, age_s, stays):
    session = left(journal, age_s)
    made = new_session("next")
    assert (session.folder.exists(), made.folder.exists()) == (stays, True)


def test_who_has_a_folder_keeps_it(left):
    session = left(WHOLE, HOUR_S)
    holds = [session.hold(), Session(session.folder).hold()]
    for hold in holds:
        new_session("next")
        assert session.folder.exists()
        hold.release()
    new_session("next")
    assert not session.folder.exists()


def test_a_bench_that_answers_keeps_its_folder_though_nobody_has_it_locked(left):
    session = left(None, HOUR_S)
    with listen_at(session.socket):
        now_s = session.folder.stat().st_mtime - HOUR_S
        for path in (*session.folder.iterdir(), session.folder):
            os.utime(path, (now_s, now_s))
        new_session("next")
        assert session.folder.exists()
    new_session("next")
    assert not session.folder.exists()


def test_what_is_young_within_an_old_folder_keeps_it(left):
    session = left(CUT, 48 * HOUR_S)
    session.journal.write_text(CUT)
    new_session("next")
    assert session.folder.exists()
