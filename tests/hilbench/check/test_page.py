"""The HTML page of a run: what it shows, that it loads nothing, and that whatever a target says stays text in it."""

from __future__ import annotations

import base64
import hashlib
import html.parser
import json
import os
import re

import msgspec
import pytest

from hilbench.check.page import html_page, run_of_journal, run_of_report
from hilbench.check.page.story import story_of
from hilbench.cli import main
from hilbench.journal import Recording
from hilbench.plugins.discovery import PLUGINS

BODY = """
    @my("A1")
    def test_stops(): raise Violation("<script>alert(1)</script> \\x00 & \\udc80")

    @my("A2")
    def test_in_time(): at_most(0.3, 0.2, unit="s", what="answer")

    @my("A3")
    def test_answers(): within(2.5, 2, 4, unit="s", what="pause")
    """


class Parsed(html.parser.HTMLParser):
    """The elements of a page, its text, and the addresses of what it shows."""

    VOID = frozenset({"meta", "input", "img", "br"})

    def __init__(self, page):
        super().__init__()
        self.open, self.elements, self.texts, self.addresses = [], [], [], []
        self.feed(page)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        self.addresses += [value for name, value in attrs if name in ("src", "href")]
        assert not [name for name, _ in attrs if name.startswith("on")]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append((self.open[-1] if self.open else "", data))

    def text(self):
        return "".join(text for tag, text in self.texts if tag not in ("script", "style"))

    def scripts(self):
        return [text for tag, text in self.texts if tag == "script"]


def rows(page):
    """The rows: clause, verdicts, whether they differ."""
    found = [attributes for tag, attributes in page.elements if tag == "details"]
    return [(row["data-words"][1:-1].split("|"), "data-changed" in row) for row in found]


def test_what_a_target_says_is_text(check):
    text = html_page([run_of_report(check(BODY), "x")])
    page = Parsed(text)
    text.encode()
    assert "<script>alert(1)</script>" in page.text()
    assert len(page.scripts()) == 1
    assert "\0" not in text


def test_it_loads_nothing_and_its_policy_lets_its_own_script_run_alone(check):
    page = Parsed(html_page([run_of_report(check(BODY), "x")]))
    assert all(address.startswith("data:image/svg+xml;base64,") for address in page.addresses)
    policy = next(about["content"] for tag, about in page.elements if about.get("http-equiv"))
    digest = base64.b64encode(hashlib.sha256(page.scripts()[0].encode()).digest()).decode()
    assert "default-src 'none'" in policy
    assert f"script-src 'sha256-{digest}'" in policy


def test_figures_stand_between_their_limits(check):
    text = html_page([run_of_report(check(BODY), "x")])
    assert "answer 0.3 s" in text
    assert "at most 0.2 s" in text
    assert '<i style="left: 25.0%">' in text


def test_runs_stand_beside_each_other_and_what_differs_is_marked(check):
    old, new = check(BODY), check(BODY.replace("2.5, 2, 4", "5, 2, 4").replace("A2", "A9"), name="test_new.py")
    page = Parsed(html_page([run_of_report(old, "old"), run_of_report(new, "new")]))
    first, *others = rows(page)
    assert first == (["fail", "fail"], False)
    assert all(changed for _, changed in others)
    assert sorted(words for words, _ in others) == [["", "fail"], ["fail", ""], ["pass", "fail"]]
    assert "old: fail" in " ".join(page.text().split())


def test_a_picture_is_taken_from_its_folder_alone(check, tmp_path):
    (tmp_path / "screens").mkdir()
    for name, text in (("screens/a.svg", "<svg/>"), ("secret.svg", "<svg>x</svg>"), ("screens/b.svg", "no picture")):
        (tmp_path / name).write_text(text)
    os.mkfifo(tmp_path / "screens" / "fifo.svg")
    report = check(BODY)
    for name, shown in (
        ("screens/a.svg", True),
        ("screens/../secret.svg", False),
        ("secret.svg", False),
        ("screens/b.svg", False),
        ("screens/fifo.svg", False),
        ("screens/none.svg", False),
        ("\0", False),
    ):
        cases = tuple(msgspec.structs.replace(case, screen=str(tmp_path / name)) for case in report.cases[:1])
        run = run_of_report(msgspec.structs.replace(report, cases=cases), "x")
        page = Parsed(html_page([run], screens=tmp_path / "screens"))
        assert bool(page.addresses) is shown, name


def test_a_thousand_clauses_take_less_than_five_megabytes(check):
    report = check(BODY)
    many = [msgspec.structs.replace(report.clauses[0], id=f"A{n}", cause="x" * 200) for n in range(1000)]
    page = html_page([run_of_report(msgspec.structs.replace(report, clauses=tuple(many)), "x")])
    assert len(page.encode()) < 5_000_000
    assert len(rows(Parsed(page))) == 1000


# --- with a recording

SUITE = """
from hilbench.check import case, Violation

@case("X1", text="One.", source="us")
def test_one(peer, world):
    peer.run(0.3)
    raise Violation("never right")

@case("X2", text="Two.", source="us")
def test_two(bench): pass
"""


@pytest.fixture
def stored(tmp_path, capsys, monkeypatch):
    """Check the virtual Pioneer; return the folder with report, journal and page."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "test_x.py").write_text(SUITE)
    words = [
        "check",
        "pioneer-plane",
        "--suite",
        "p2os-server",
        "-k",
        "S10 or S20",
        "--json",
        "run.json",
        "--journal",
        "run.jsonl",
    ]
    assert main([*words, "--html", "run.html"]) in (0, 4)
    capsys.readouterr()
    return tmp_path


@pytest.mark.slow("a whole check of a few cases")
def test_the_command_writes_it_and_makes_it_again_from_what_is_stored(stored, capsys):
    assert main(["report", "run.json", "run.jsonl"]) == 0
    again = Parsed(capsys.readouterr().out)
    assert rows(again) == rows(Parsed((stored / "run.html").read_text()))
    assert main(["report", "run.jsonl", "--html", "cases.html"]) == 0
    assert "p2os-server/" in Parsed((stored / "cases.html").read_text()).text()
    for words, code, said in (
        (["run.json", "none.json"], 3, "none.json: cannot be read: No such file or directory"),
        (["run.json", "--html", "run.json"], 2, "run.json"),
        (["test_x.py"], 3, "test_x.py: is no recording"),
    ):
        assert main(["report", *words]) == code
        assert said in capsys.readouterr().err
    damaged = json.loads((stored / "run.json").read_text()) | {"cases": 3}
    (stored / "damaged.json").write_text(json.dumps(damaged))
    assert main(["report", "damaged.json"]) == 2
    assert re.search(
        r"^hilbench: damaged.json: is no report of 'hilbench check --json': .*\n$", capsys.readouterr().err
    )


@pytest.mark.slow("two whole checks of a case")
def test_the_last_moments_of_a_case_are_told_and_nothing_else_changes(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "test_x.py").write_text(SUITE)
    hashes = []
    for more in ([], ["--html", "run.html"]):
        assert main(["check", "pioneer", "--suite", "test_x.py", "--json", "run.json", *more]) == 1
        hashes.append(json.loads((tmp_path / "run.json").read_text())["run_hash"])
    assert hashes[0] == hashes[1]
    page = Parsed((tmp_path / "run.html").read_text())
    assert "x/one, to its end" in page.text()
    assert "verdict" in page.text()
    assert [about["alt"] for tag, about in page.elements if tag == "img"] == ["the world from above"]
    assert not list(tmp_path.glob("*.jsonl"))


STARVES = """
from hilbench.check import case, Violation

@case("X1", text="One.", source="us")
def test_one(peer):
    peer.start()
    for pause_s in (0.5, 1.5, 2.5):
        peer.run(pause_s)
        peer.send(0)
    raise Violation("never right")
"""


@pytest.mark.slow("two whole checks of a case")
def test_margins_of_watchdogs_are_drawn_and_hash_and_verdict_are_those_without(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "test_x.py").write_text(STARVES)
    found = []
    for more in ([], ["--html", "run.html", "--journal", "run.jsonl"]):
        words = ["check", "pioneer-plane", "--suite", "test_x.py", "--json", "run.json"]
        assert main([*words, *more]) == 1
        report = json.loads((tmp_path / "run.json").read_text())
        found.append((report["run_hash"], report["cases"][0]["verdict"], report["cases"][0]["case_hash"]))
    assert found[0] == found[1]
    assert main(["report", "run.jsonl", "--html", "again.html"]) == 0
    for name in ("run.html", "again.html"):
        page = Parsed((tmp_path / name).read_text())
        (picture,) = (about["src"] for _, about in page.elements if "time was left" in about.get("alt", ""))
        drawn = base64.b64decode(picture.partition(",")[2]).decode()
        assert "robot WATCHDOG, set for 2 s: ran out<" in drawn
        assert ("td", "margins") not in page.texts


def pin(ns, level, name="b.PA0"):
    return {"ns": ns, "kind": "pin", "source": name, "level": level}


def test_a_journal_alone_has_a_row_for_each_case(check):
    events = (
        {"ns": 0, "kind": "case", "source": "journal", "case": "s/one"},
        *(pin(n * 1000, bool(n % 2), "b.<P>") for n in range(9)),
        {"ns": 9000, "kind": "tx", "source": "checker", "data": "00" * 500},
        {"ns": 9000, "kind": "event", "source": "<x>", "name": "</td>", "value": {"text": "<b>\0"}},
        {"ns": 9000, "kind": "verdict", "source": "checker", "verdict": "fail", "cause": "<i>"},
        {"ns": 9000, "kind": "case-end", "source": "journal", "case": "s/one", "hash": ""},
        {"ns": 0, "kind": "case", "source": "journal", "case": "s/two"},
    )
    recording = Recording(header={"bench": "<bench>", "faults": ["<f>"]}, events=events, problem="cut", ended=False)
    page = Parsed(html_page([run_of_journal(recording, "x")]))
    assert rows(page) == [(["fail"], False), (["not run"], False)]
    assert {"<bench>", "<i>", "</td>"} <= {one for one in ("<bench>", "<i>", "</td>") if one in page.text()}
    assert sum(tag == "img" for tag, _ in page.elements) == 1


def test_each_line_of_a_source_is_a_stream_of_its_own():
    sync, text = "fafb03000000", b"$GPGGA,1*00".hex()
    events = [
        {"ns": 0, "kind": "case", "source": "journal", "case": "s/one"},
        {"ns": 1, "kind": "rx", "source": "agent", "line": "line1", "data": sync[:6]},
        {"ns": 2, "kind": "rx", "source": "agent", "line": "line2", "data": text},
        {"ns": 3, "kind": "rx", "source": "agent", "line": "line1", "data": sync[6:]},
        {"ns": 4 * 10**9, "kind": "case-end", "source": "journal", "case": "s/one", "hash": ""},
    ]
    recording = Recording(header={}, events=events, problem="", ended=True)
    story = story_of(recording, "s/one", PLUGINS.get("p2os", ""))
    assert {(line.source, line.name == "bytes", line.bad) for line in story.lines if line.raw} == {
        ("agent.line1", False, False),
        ("agent.line2", True, False),
    }


def test_a_line_without_a_frame_of_the_protocol_is_not_damaged_but_another():
    sync, text = "fafb03000000", b"$GPGGA,1*00".hex()
    events = [
        {"ns": 0, "kind": "case", "source": "journal", "case": "s/one"},
        {"ns": 1, "kind": "rx", "source": "robot", "data": sync},
        {"ns": 2, "kind": "rx", "source": "robot", "data": text},
        {"ns": 2 * 10**9, "kind": "rx", "source": "robot", "data": sync},
        {"ns": 3, "kind": "tx", "source": "gps", "data": text},
        {"ns": 4 * 10**9, "kind": "case-end", "source": "journal", "case": "s/one", "hash": ""},
    ]
    recording = Recording(header={}, events=events, problem="", ended=True)
    story = story_of(recording, "s/one", PLUGINS.get("p2os", ""))
    assert {(line.source, line.name == "bytes", line.bad) for line in story.lines if line.raw} == {
        ("robot", False, False),
        ("robot", False, True),
        ("gps", True, False),
    }
