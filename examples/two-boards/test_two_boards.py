"""Two boards that talk to each other. Run it with ``pytest examples/two-boards``."""

from __future__ import annotations

from collections.abc import Mapping

from hilbench.mcu.under_test import BoardUnderTest

pytest_plugins = ["hilbench.pytest_plugin"]


def test_each_hears_the_other(boards: Mapping[str, BoardUnderTest]) -> None:
    boards["worker"].run(0.25)
    said: dict[str, list[str]] = {who: [] for who in ("reporter.usart1", "worker.usart1")}
    for line in boards["worker"].transcript:  # bench time, who, what; of all boards
        _, who, what = line.split(maxsplit=2)
        if who in said:
            said[who].append(what.removeprefix("> "))
    (report,) = said["reporter.usart1"]
    assert report.startswith("messages 50 wrong 0")
    assert f"? {report}" in said["worker.usart1"]
    assert said["worker.usart1"].count("button") == 7  # PA2 has fallen so often


def test_the_wire_carries_the_level(boards: Mapping[str, BoardUnderTest]) -> None:
    boards["reporter"].run(0.03)
    assert boards["reporter"].pin("A2").level is True
    assert boards["worker"].pin("A0").level is True
