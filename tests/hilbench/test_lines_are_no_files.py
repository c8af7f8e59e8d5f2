"""Nothing that is written may go to the line: the board would get the journal, and the client, too."""

from __future__ import annotations

import os
import select
from pathlib import Path

import pytest

from hilbench.cli import main

IMAGE = Path(__file__).parents[2] / "targets/firmware/images/echo-irq.elf"

pytestmark = pytest.mark.usefixtures("keep_signals")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with ``board``, a link to a pseudo-terminal, and ``twin``, another one to the same."""
    master, slave = os.openpty()
    monkeypatch.chdir(tmp_path)
    Path("board").symlink_to(os.ttyname(slave))
    Path("twin").symlink_to("board")
    yield tmp_path
    assert not select.select([master], [], [], 0)[0], "somebody has written to the board"
    os.close(master)
    os.close(slave)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("proxy pty:./new rover-model --journal new", "--journal new: would be written into pty:./new"),
        ("proxy pty:./board rover-model --journal board", "--journal board: would be written into pty:./board"),
        ("proxy tcp:0 serial:./board --journal twin", "--journal twin: would be written into serial:./board"),
        ("proxy serial:board@9600 rover-model --journal board",
         "--journal board: would be written into serial:board@9600"),
        ("serve rover-model --pty ./board --journal board", "--journal board: would be written into --pty board"),
        (f"serve bluepill:{IMAGE} --journal ./bluepill-usart1",
         "--journal bluepill-usart1: would be written into the line of bluepill.usart1"),
        ("check pioneer-plane --target serial:./twin@9600 --journal board",
         "--journal board: would be written into serial:./twin@9600"),
        ("check pioneer-plane --target serial:board@9600,dtr=off --junit board",
         "--junit board: would be written into serial:board@9600,dtr=off"),
        ("check pioneer-plane --target listen:pty:./new --journal new",
         "--journal new: would be written into listen:pty:./new"),
    ],
)  # fmt: skip
def test_a_line_is_refused_whatever_its_name(folder, capfd, words, said):
    before = sorted(folder.iterdir())
    assert main(words.split()) == 2
    assert capfd.readouterr().err == f"hilbench: {said}; choose another file\n"
    assert sorted(folder.iterdir()) == before


def test_of_a_board_its_own_terminal_is_the_line(folder, capfd):
    device = str(Path("board").resolve())
    assert main(["proxy", "tcp:0", "serial:./board", "--journal", device]) == 2
    assert capfd.readouterr().err == (
        f"hilbench: --journal {device}: would be written into serial:./board; choose another file\n"
    )
