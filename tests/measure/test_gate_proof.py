"""The gate's own proof: which defects it makes, how it chooses them, and that it goes on where it was stopped."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading

import pytest

from measure.gate_proof import processes
from measure.gate_proof.choice import LEAST, Module, choose, shares
from measure.gate_proof.crew import StoppedError, side_by_side
from measure.gate_proof.defects import defects_of
from measure.gate_proof.plugins.gate_store import Part
from measure.gate_proof.proof import GATE, OLD, Plan, Proof
from measure.gate_proof.recording import Recording, join
from measure.gate_proof.report import Judged, page
from measure.gate_proof.running import Outcome
from measure.gate_proof.selection import Tree, moved_lines

PLAN = Plan("new", "old", 17, 300)
ALIKE = [
    ("comparison", "a < b", "a <= b"),
    ("comparison", "(a)  is not\\\n (b)", "(a)  is\\\n (b)"),
    ("comparison", "a == b not in c", "a == b in c"),
    ("and, or", "a and (b and c)", "a or (b and c)"),
    ("not", "not a", "a"),
    ("arithmetic", "(a - 1.5) * b", "(a - 1.5) / b"),
    ("arithmetic", "a // b", "a * b"),
    ("mask", "a & b", "a | b"),
    ("mask", "a | b", "a & b"),
    ("sign", "-a", "+a"),
    ("truth", "True", "False"),
    ("whole number", "9", "10"),
    ("whole number", "0x0F", "0x0E"),
    ("whole number", "99_999", "100_000"),
    ("number", "0.25", "0.5"),
    ("number", "0.0", "1.0"),
    ("arguments swapped", "f(a, (b), c)", "f(b, (a), c)"),
    ("slice", "a[b:]", "a[(b) + 1:]"),
    ("min, max, any, all", "min(a, b)", "max(a, b)"),
    ("end of a text", "'é'.startswith(a)", "'é'.endswith(a)"),
    ("condition negated", "a if b else c", "a if not (b) else c"),
    ("condition negated", "[a for a in b if a]", "[a for a in b if not (a)]"),
    ("assignment in place", "a += b", "a -= b"),
    ("statement removed", "a.b = c", "pass"),
    ("statement removed", "a.b(c)", "pass"),
    ("statement removed", "raise ValueError(f'{a:3}')", "pass"),
    ("value not returned", "return a", "return None"),
]


def made(text):
    return {(one.kind, one.put_into(text.encode()).decode()) for one in defects_of("worlds/m.py", text.encode())}


def test_each_kind_of_defect_changes_its_place_and_nothing_else():
    for kind, before, after in ALIKE:
        text, wanted = (f"def f():\n    'é'; {line}\n" for line in (before, after))
        assert (kind, wanted) in made(text), (kind, before)


def test_a_loop_is_left_where_it_went_on():
    assert ("break, continue", "for a in b:\n    continue\n") in made("for a in b:\n    break\n")


def test_what_cannot_be_seen_is_left_alone():
    text = '''
"""Says 1 < 2."""
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import a

__all__ = ["b"[0:1]]

@dataclass(frozen=True, slots=True)
class C(D, order=True):
    e: int | None
    def f(self, g: Literal[1]) -> Literal[2]:
        assert g is not None
        raise ValueError(f"{g:3} {1 + 1}")
    @overload
    def h(self): return 1 < 2
    def i(self): return "one" + "two"
'''
    assert {(one.kind, one.before[:5]) for one in defects_of("worlds/m.py", text.encode())} == {
        ("statement removed", "raise"),
        ("value not returned", '"one"'),
    }


def test_every_defect_of_a_module_compiles_to_something_else():
    source = "\n".join(f"def f{number}():\n    {line}" for number, (_, line, _) in enumerate(ALIKE)).encode()
    found = defects_of("worlds/m.py", source)
    assert len(found) > len(ALIKE)
    assert [one for one in found if not one.matters(source)] == []
    assert len({one.id for one in found}) == len(found)


def test_a_defect_keeps_its_name_when_lines_come_before_it():
    source = b"def f():\n    return a < b\n"
    moved = b"import a\n\n" + source
    assert [one.id for one in defects_of("m.py", moved)] == [one.id for one in defects_of("m.py", source)]
    assert {one.line - 2 for one in defects_of("m.py", moved)} == {one.line for one in defects_of("m.py", source)}


def modules():
    made = []
    for package, count in {"hilbench": 20, "protocols": 8, "targets": 15, "worlds": 4}.items():
        for number in range(count):
            path = f"{package}/m{number}.py"
            source = "".join(f"def f{line}():\n    return a < {line}\n" for line in range(5)).encode()
            made.append(Module(path, source, defects_of(path, source)))
    return made


def test_the_seed_alone_chooses():
    chosen = choose(modules(), 17, 60)
    assert choose(modules()[::-1], 17, 60) == chosen
    assert choose(modules(), 18, 60) != chosen
    assert len(chosen) == 60
    assert len({(one.path, one.line) for one in chosen}) == 60


def test_a_small_package_has_a_share_that_says_something():
    assert shares({"hilbench": 40_000, "protocols": 12_000, "targets": 28_000, "worlds": 2000}, 300) == {
        "hilbench": 129,
        "protocols": LEAST,
        "targets": 91,
        "worlds": LEAST,
    }


def told(name, gate, *, by="", found=True):
    outcome = {"found": found, "how": "failed", "by": by, "tests": 3, "covering": 2, "cpu_s": 1.0, "wall_s": 1.0}
    return {"what": "result", "id": name, "gate": gate, "outcome": outcome}


def proof(folder, *lines, end=""):
    folder.mkdir(exist_ok=True)
    (folder / "results.jsonl").write_text("".join(f"{json.dumps(line)}\n" for line in lines) + end)
    return Proof(folder, PLAN, 2)


def test_another_run_goes_on_with_what_is_left(tmp_path):
    source = b"def f():\n    return a < b\n"
    first, *rest = defects_of("m.py", source)
    under_way = proof(tmp_path, told(first.id, GATE), end='{"what": "result", "id"')
    assert {one.id for one in under_way.left(GATE, [first, *rest])} == {one.id for one in rest}
    assert len(under_way.left(OLD, [first, *rest])) == len(rest) + 1
    assert (tmp_path / "results.jsonl").read_text().endswith("}\n")


def test_another_plan_in_the_same_folder_changes_nothing(tmp_path, capsys):
    proof(tmp_path)
    assert Proof(tmp_path, Plan("newer", "old", 1, 2), 2).plan == PLAN
    assert "going on with" in capsys.readouterr().err


def test_a_test_that_fails_anyway_has_found_nothing(tmp_path):
    under_way = proof(
        tmp_path,
        told("one", GATE, by="t.py::bad"),
        told("two", GATE, by="t.py::good"),
        {"what": "tried", "gate": GATE, "tests": ["t.py::bad", "t.py::good"], "failed": ["t.py::bad"]},
    )
    assert set(under_way.results(GATE)) == {"two"}


def test_what_was_missed_is_put_before_better_tests(tmp_path):
    under_way = proof(tmp_path, told("one", GATE), told("two", GATE, found=False), told("two", OLD, found=False))
    under_way.again("newer")
    assert under_way.plan.commit == "newer"
    assert set(under_way.results(GATE)) == {"one"}
    assert set(under_way.results(OLD)) == {"two"}


def test_a_defect_is_judged_anew_when_it_is_asked_for(tmp_path):
    under_way = proof(tmp_path, told("one", GATE), told("two", GATE))
    under_way.forget(["one"])
    assert set(under_way.results(GATE)) == {"two"}


def recorded(folder):
    """Two tests that share a fixture, one of which starts a process."""
    part = Part(folder / "part-1.sqlite")
    part.ran("fixture shared", {"worlds/m.py": [(-1, 1), (1, 2)]})
    for name, line in {"tests/worlds/test_m.py::one": 8, "tests/worlds/test_m.py::two": 9}.items():
        part.ran(name, {"worlds/m.py": [(line, -1)]})
        part.ended(name, (0.1, 0.2), "passed", ["fixture shared"])
    part.close()
    child = {"context": "tests/worlds/test_m.py::two", "arcs": {"worlds/m.py": [[20, 21]]}}
    (folder / "child-2-0.json").write_text(json.dumps(child))
    (folder / "child-3-0.json").write_text('{"context":')
    join(folder, folder / "whole.sqlite")
    return Recording(folder / "whole.sqlite")


def test_a_line_has_the_tests_that_run_it_themselves_by_a_fixture_or_in_a_process(tmp_path):
    one, two = "tests/worlds/test_m.py::one", "tests/worlds/test_m.py::two"
    tree = Tree(tmp_path, [recorded(tmp_path)])
    by_line = {line: tree.running("worlds/m.py", [line]) for line in tree.lines_run("worlds/m.py")}
    assert by_line == {1: {one, two}, 2: {one, two}, 8: {one}, 9: {two}, 20: {two}, 21: {two}}


def test_the_tests_of_a_defect_are_those_of_its_line_then_those_beside_them(tmp_path):
    (tmp_path / "worlds").mkdir()
    (tmp_path / "worlds" / "m.py").write_text("LIMIT = 3\n" + "\n" * 5 + "def f():\n    a.b()\n    c.d()\n")
    tree = Tree(tmp_path, [recorded(tmp_path)])
    constant, _, second = defects_of("worlds/m.py", tree.source("worlds/m.py"))
    chosen = tree.selection(second)
    assert (chosen.order, chosen.covering) == (["tests/worlds/test_m.py::two", "tests/worlds/test_m.py::one"], 1)
    assert tree.selection(constant).covering == 2


def test_what_a_module_calls_as_it_is_imported_is_tested_by_all_who_use_it(tmp_path):
    (tmp_path / "worlds").mkdir()
    (tmp_path / "worlds" / "m.py").write_text("def f():\n    return a < 2\n\ndef g():\n    return b < 2\n\nF = f()\n")
    part = Part(tmp_path / "part-1.sqlite")
    for name, arcs in {"t.py::one": [(1, 4), (4, 7), (7, 2)], "t.py::two": [(-4, 5)], "u.py::three": [(-4, 5)]}.items():
        part.ran(name, {"worlds/m.py": arcs})
        part.ended(name, (0.1, 0.2), "passed", [])
    part.close()
    tree = Tree(tmp_path, [Recording(tmp_path / "part-1.sqlite")])
    covering = {one.where: len(tree.covering(one)) for one in defects_of("worlds/m.py", tree.source("worlds/m.py"))}
    assert covering == {"f": 3, "g": 2}


def test_lines_that_moved_are_known_again():
    assert moved_lines(b"a\nb\nc\n", b"new\na\nchanged\nc\n") == {1: 2, 3: 4}


def test_jobs_are_done_by_several_at_once_and_end_with_the_first_that_goes_wrong():
    done = []
    side_by_side("ab", range(9), lambda _, job: done.append(job), threading.Event())
    assert sorted(done) == list(range(9))
    stop = threading.Event()

    def work(bench, job):
        if job == 0:
            raise ValueError("wrong")
        stop.wait()
        raise StoppedError

    with pytest.raises(ValueError, match="wrong"):
        side_by_side("ab", range(9), work, stop)


def test_all_processes_of_a_run_end_with_it():
    words = "import os, signal; os.fork() or os.setsid(); signal.alarm(99); os.write(1, b'1'); signal.pause()"
    with subprocess.Popen(
        [sys.executable, "-S", "-c", words],
        env={**os.environ, processes.MARK: "a-run-of-this-test"},
        stdout=subprocess.PIPE,
        start_new_session=True,
    ) as leader:
        assert leader.stdout.read(2) == b"11"
        assert len(list(processes.of_run("a-run-of-this-test", leader.pid))) == 2
        assert processes.used("a-run-of-this-test", leader.pid).memory > 2**20
        processes.end("a-run-of-this-test", leader.pid)
        assert leader.wait() < 0
        assert leader.stdout.read() == b""


def judged(defect, gate, old):
    def outcome(found):
        return Outcome(found, "failed" if found else "", "tests/t.py::a" if found else "", 3, 2, 1.0, 1.0)

    return Judged(defect, outcome(gate), outcome(old), asked_old=not gate)


def test_the_page_has_each_miss_with_its_reason():
    found, alone, both, unknown = defects_of("worlds/m.py", b"def f():\n    if a | b < 2:\n        pass\n")[:4]
    lines = [judged(found, True, False), judged(alone, False, True), judged(both, False, False)]
    text = page(
        [*lines, judged(unknown, False, False)],
        dict.fromkeys(("commit", "before", "seed", "per_module", "thorough"), "x"),
        {},
        {alone.id: "The test is in exhaustive.", both.id: "Nobody sees it."},
    )
    assert "| worlds | 4 | 1 | 2 | 1 | 25 % |" in text
    (line,) = [line for line in text.splitlines() if line.startswith(f"| {alone.id}")]
    assert line.endswith("| found by `tests/t.py::a`; The test is in exhaustive. |")
    assert f"{both.id} | `worlds/m.py:2` `f` |" in text
    assert text.count("not looked at") == 1
