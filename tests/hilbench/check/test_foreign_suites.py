"""Every built-in bench with every suite of what it does not speak: refused before a port is even looked for."""

from __future__ import annotations

import pytest

from hilbench.cli import main
from hilbench.files.built_in import built_in_benches
from tests.share import few

SUITES = {
    "p2os": ("p2os-client", "p2os-server", "pioneer-motion"),
    "pkt": ("pkt-board", "pkt-host", "rover-motion"),
    "carla": ("vehicle-board", "vehicle-drive", "vehicle-host"),
    "pins": ("bluepill-pins",),
    "xrce": ("xrce-agent", "xrce-client"),
}
AT_A_PORT = ["--target", "serial:/nowhere/port"]
AT_TWO = ["--target", "simulator=serial:/nowhere/port", "--target", "stack=serial:/nowhere/other"]
BENCHES = {
    "pioneer": ({"p2os"}, AT_A_PORT),
    "pioneer-plane": ({"p2os"}, AT_A_PORT),
    "bluepill": ({"p2os", "pins"}, AT_A_PORT),
    "bluepill-bare": ({"pins"}, AT_A_PORT),
    "bluepill-p2os": ({"p2os", "pins"}, AT_A_PORT),
    "bluepill-robot": ({"p2os", "pins"}, AT_A_PORT),
    "rover": ({"pkt"}, AT_A_PORT),
    "rover-model": ({"pkt"}, AT_A_PORT),
    "vehicle": ({"carla"}, AT_TWO),
    "vehicle-micro-ros": ({"carla"}, AT_TWO),
    "vehicle-model": ({"carla"}, AT_TWO),
    "xrce-agent": ({"xrce"}, AT_A_PORT),
    "xrce-client": ({"xrce"}, AT_A_PORT),
}


@pytest.mark.parametrize("bench", few(BENCHES, 3, "the gate has three of thirteen benches, and test_target more"))
def test_a_suite_of_another_protocol_never_reaches_the_port(bench, capsys):
    speaks, target = BENCHES[bench]
    for protocol in SUITES.keys() - speaks:
        for suite in SUITES[protocol]:
            code = main(["check", bench, "--suite", suite, *target])
            shown = capsys.readouterr()
            assert (code, shown.out) == (2, ""), f"{suite}: {shown}"
            assert shown.err.startswith(f"hilbench: --suite {suite}: is a suite of "), f"{suite}: {shown.err}"
            assert shown.err.count("\n") == 1, f"{suite}: {shown.err}"


def test_a_suite_of_its_own_looks_for_the_port(capsys):
    assert main(["check", "pioneer", "--suite", "p2os-server", *AT_A_PORT]) == 3
    assert "/nowhere/port" in capsys.readouterr().err


def test_all_benches_are_here():
    assert built_in_benches().keys() == BENCHES.keys()
