"""The example of the documentation runs: its names are filled in so that its loop ends after the first report."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from protocols.pkt import MotionReport, encode_frame, encode_report

PAGE = Path(__file__).parents[3] / "docs/pkt/index.md"


def test_the_example_asks_drives_and_shows_a_report(capsys):
    class ExampleOver(Exception):  # noqa: N818 - not an error
        pass

    class Port:
        def __init__(self):
            self.written = []
            self.waiting = [encode_frame(encode_report(MotionReport(rpm=(1.0, 2.0, 3.0, 4.0))))]

        def write(self, data):
            self.written.append(data)

        def read(self):
            if not self.waiting:
                raise ExampleOver
            return self.waiting.pop()

    (text,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    port = Port()
    with pytest.raises(ExampleOver):
        exec(text, {"port": port, "now_ns": lambda: 0})  # the documentation's own code
    assert [data[5] for data in port.written] == [0x00, 0x03]
    assert capsys.readouterr().out == "(1.0, 2.0, 3.0, 4.0) (0.0, 0.0)\n"
