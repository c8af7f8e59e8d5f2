"""Whatever our descriptors are, the library's chatter never reaches them, and they survive."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap

import pytest

from worlds import PhysicsOutputError, WorldError
from worlds.quiet import captured_output

OPEN = "from worlds import open_world; world = open_world('wall', 'pioneer-2dx', 'bullet'); world.step(); "


MORE = pytest.mark.exhaustive("the gate has one descriptor closed, and all of them")


def shout(descriptor, text):
    os.write(descriptor, text.encode())


def test_what_is_written_meanwhile_is_swallowed_and_the_rest_is_not(capfd):
    shout(1, "before\n")
    with captured_output():
        shout(1, "hidden\n")
        shout(2, "hidden\n")
    shout(1, "after\n")
    shout(2, "after\n")
    out, err = capfd.readouterr()
    assert (out, err) == ("before\nafter\n", "after\n")


@pytest.mark.parametrize("descriptor", [1, 2])
@pytest.mark.parametrize("mark", ["b3Warning", "b3Error"])
def test_warnings_are_errors(capfd, descriptor, mark):
    with pytest.raises(PhysicsOutputError, match="no inertia"), captured_output():
        shout(descriptor, f"{mark}[somewhere.cpp,1]: no inertia")
    assert capfd.readouterr() == ("", "")


def test_an_error_of_the_body_comes_first_and_the_descriptors_are_back(capfd):
    with pytest.raises(WorldError, match="mine"), captured_output():
        shout(1, "b3Warning: theirs\n")
        raise WorldError("mine")
    shout(1, "after\n")
    assert capfd.readouterr() == ("after\n", "")


def test_no_descriptor_leaks():
    def count():
        return len(os.listdir("/proc/self/fd"))

    before = count()
    for _ in range(20):
        with captured_output():
            pass
    assert count() == before


def test_text_buffered_by_c_goes_where_it_was_meant_to(python):
    run = python(
        textwrap.dedent("""
            import ctypes
            from worlds.quiet import captured_output
            libc = ctypes.CDLL(None)
            libc.printf(b"ours\\n")
            with captured_output():
                libc.printf(b"theirs\\n")
            libc.printf(b"ours too\\n")
        """)
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "ours\nours too\n", "")


@pytest.mark.needs_bullet
def test_opening_a_world_prints_nothing_until_the_process_is_gone(python):
    run = python(OPEN + "print('mine'); world.close()")
    assert (run.returncode, run.stdout, run.stderr) == (0, "mine\n", "")


@pytest.mark.needs_bullet
def test_the_library_does_chatter_without_us(python):
    assert "pybullet build time" in python("import pybullet").stderr


@pytest.mark.needs_bullet
@pytest.mark.parametrize(
    "closed", ["1>&-", pytest.param("2>&-", marks=MORE), pytest.param("1>&- 2>&-", marks=MORE), "0<&- 1>&- 2>&-"]
)
def test_closed_descriptors_stay_closed(tmp_path, closed):
    report = tmp_path / "report"
    check = f"""
import os
def is_open(n):
    try: os.fstat(n)
    except OSError: return False
    return True
before = [is_open(n) for n in (0, 1, 2)]
{OPEN}
same = before == [is_open(n) for n in (0, 1, 2)]
open({str(report)!r}, "w").write(repr(same))
"""
    program = tmp_path / "program.py"
    program.write_text(check)
    command = f"{sys.executable} {program} {closed}"
    environment = {**os.environ, "PYTHONPATH": os.getcwd()}
    subprocess.run(["sh", "-c", command], check=True, env=environment, timeout=60)
    assert report.read_text() == "True"


@pytest.mark.needs_bullet
def test_a_warning_while_loading_is_an_error_in_a_clean_process(python):
    run = python(
        textwrap.dedent("""
            from worlds import PhysicsOutputError, Vehicle, open_world
            from worlds.vehicles.model import Part
            part = Part(name="flat", mass_kg=1.0, center_of_mass_m=(0, 0, 0), inertia_kg_m2=(1.0, 1.0, 9.0))
            try:
                open_world("empty", Vehicle(name="flat", parts=(part,)), "bullet")
            except PhysicsOutputError as problem:
                print("refused")
        """)
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "refused\n", "")
