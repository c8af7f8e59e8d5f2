"""Benches where the checker has several lines: how bench files name them, and which port each gets."""

from __future__ import annotations

import pytest

from hilbench.bench.checker_lines import ports_of_lines
from hilbench.benchfile.reader import open_bench
from hilbench.errors import UsageError
from hilbench.terminal.options import TargetChoice
from tests.each import each

TWO_LINES = """version = 1
[targets.brain]
board = "nucleo-f767zi"
firmware = "a.elf"
[[links]]
ends = ["peer.simulator", "brain.usart2"]
[[links]]
ends = ["brain.usart3", "peer.stack"]
baud = 921600
"""
LINES = ("simulator", "stack")


@pytest.fixture
def read(tmp_path):
    (tmp_path / "a.elf").write_bytes(b"")

    def open_text(text):
        file = tmp_path / "my.toml"
        file.write_text(text)
        return open_bench(str(file))

    return open_text


def test_lines_have_names(read):
    bench = read(TWO_LINES)
    assert bench.checker_lines == {"simulator": "brain.usart2", "stack": "brain.usart3"}
    assert [link.baud for link in bench.links] == [0, 921_600]


def test_a_line_without_a_name(read):
    assert read(TWO_LINES.replace("peer.stack", "peer")).checker_lines == {
        "simulator": "brain.usart2",
        "": "brain.usart3",
    }


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("peer.stack", "peer.simulator", "'peer.simulator' has a line already"),
        ("peer.stack", "peer.", "'peer.' is not the end of a link"),
        ("peer.stack", "peer.a b", r"'peer\.a b' is not the end of a link"),
        ("peer.stack", "per.stack", r"'per\.stack' is not the end of a link"),
    ],
)
def test_wrong_ends(read, old, new, message):
    with pytest.raises(UsageError, match=message):
        read(TWO_LINES.replace(old, new))


def choices(*words):
    return [TargetChoice(name=name, spec=spec) for name, _, spec in (word.partition("=") for word in words)]


def test_a_port_for_each_line():
    assert ports_of_lines(LINES, choices("stack=serial:/dev/b", "simulator=serial:/dev/a")) == {
        "simulator": "serial:/dev/a",
        "stack": "serial:/dev/b",
    }


@each(
    ("words", "message"),
    [
        (("=serial:/dev/a",), "does not say which line, of simulator and stack"),
        (("simulator=serial:/dev/a", "simulator=serial:/dev/b"), "the line 'simulator' has a port already"),
        (("simulator=serial:/dev/a", "stack=serial:/dev/a"), "two lines at one port"),
        (("simulator=serial:/dev/a",), "nothing at the line 'stack'"),
        (("simulator=serial:/dev/a", "stak=serial:/dev/b"), "no line 'stak'"),
    ],
)
def test_wrong_use(words, message):
    with pytest.raises(UsageError, match=message):
        ports_of_lines(LINES, choices(*words))


def test_a_nearby_name_is_shown():
    with pytest.raises(UsageError) as caught:
        ports_of_lines(LINES, choices("stak=serial:/dev/b"))
    assert "did you mean 'stack'?" in str(caught.value)
