"""A display on a bench: what it shows is saved as a picture, and what can be wrong with that."""

from __future__ import annotations

import struct
import zlib

import pytest

from hilbench.cli import main
from targets.firmware import image_path

BENCH = f"""
version = 1
[targets.brain]
board = "bluepill"
firmware = "{image_path("style-display")}"
[parts.display]
kind = "ssd1306"
buses = {{ i2c = "brain.I2C1" }}
[parts.memory]
kind = "at24c02"
buses = {{ i2c = "brain.I2C1" }}
"""


@pytest.fixture
def bench(tmp_path):
    file = tmp_path / "b.toml"
    file.write_text(BENCH)
    return file


def pixels(file):
    """Read a picture as this program writes it: one chunk of data, no filter."""
    data = file.read_bytes()
    width, height = struct.unpack_from(">II", data, 16)
    begin = data.index(b"IDAT") + 4
    rows = zlib.decompress(data[begin : begin + int.from_bytes(data[begin - 8 : begin - 4])])
    return {(x, y) for y in range(height) for x in range(width) if rows[y * (width + 1) + 1 + x]}


def square(x, y, size):
    sides = {(x + at, y + side) for at in range(size) for side in (0, size - 1)}
    return sides | {(x + side, y + at) for at in range(size) for side in (0, size - 1)}


def test_what_a_display_shows_is_saved(bench, tmp_path):
    file = tmp_path / "shown.png"
    assert main(["run", str(bench), "--for", "0.07s", "--picture", f"display={file}"]) == 0
    frame = {(x, y) for x in range(128) for y in range(64) if x in (0, 127) or y in (0, 63)}
    assert pixels(file) == frame | square(4, 4, 6) | square(17, 20, 20)


@pytest.mark.parametrize(
    ("picture", "code", "words"),
    [
        ("displax=shown.png", 2, "'displax' is no display of the bench; did you mean 'display'?"),
        ("memory=shown.png", 2, "'memory' is no display"),
        ("display", 2, "'display' is not NAME=FILE"),
        ("display=b.toml", 2, "would overwrite the bench file"),
        ("display=no/such/shown.png", 2, "/no/such; make it first"),
        ("display=.", 2, "--picture .: is a folder"),
    ],
)
def test_wrong_pictures_are_refused(bench, monkeypatch, capsys, picture, code, words):
    monkeypatch.chdir(bench.parent)
    assert main(["run", "b.toml", "--for", "1ms", "--picture", picture]) == code
    (line,) = capsys.readouterr().err.splitlines()  # said before the run
    assert words in line
