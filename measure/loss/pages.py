"""The page and the picture."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from xml.sax.saxutils import escape

from measure.loss.measure import Loss, by_formula
from measure.loss.payloads import STRUCTURED

__all__ = ["page", "picture"]

_HEAD = """\
# What newlines cost a client

Made by `make loss` (`python -m measure.loss`). Do not edit.

No frame of PKT! escapes anything. A client that takes each line for a frame, as the one of the rover's author does
(`rover_groundcontrol/rover/serialprotocol.py`, over pyserial's `readline`), loses every frame with a `0A` in its
length, payload or CRC; so does a receiver of the seed document's frames, which have no length. Of *N* random payload
bytes that is a share of 1 - (255/256)^(N+2).

Measured with {count} frames each, through `protocols.pkt.LineReader`, which is that client, and through `FrameReader`,
which goes by the length byte; ± is two standard deviations.
"""

_TAIL = """
The heads of 0x82 and 0x84 are no random bytes: of 0x82 with random floats the formula for its 56 other bytes says
{imu:.2%}. What a sensor says is less random still, and depends on its noise and on where it is: in Buenos Aires every
latitude near -34.6 holds a newline, and 0x84 is never seen. Of one byte there are 256 payloads only, and four of them
are lost. The author's own notebook (`RoverBasicBenchTest.ipynb`) has 1237 of some 1603 reports of the IMU: 22.8 % lost,
within 2.1 %."""

_RANDOM_IMU_BYTES = 56

_FONT = 'font-family="sans-serif" font-size="12"'

_WIDTH, _HEIGHT, _LEFT, _BOTTOM, _TOP = 640, 360, 52, 44, 20
_MAX_SIZE, _MAX_SHARE = 98, 0.35


def page(random_losses: Mapping[int, Loss], structured: Mapping[str, tuple[int, Loss, Loss]], count: int) -> str:
    """Return the page.

    Args:
        random_losses: by payload size.
        structured: payload size, and what lines and lengths lose, by the names of `STRUCTURED`.
        count: how many frames each.
    """
    lines = [
        _HEAD.format(count=f"{count:,}".replace(",", " ")),
        "![Share lost over payload size](../images/pkt-loss.svg)\n",
    ]
    lines += ["## Random payloads\n", "| Payload, bytes | By the formula | Measured |", "|--:|--:|--:|"]
    lines += [f"| {size} | {by_formula(size):.2%} | {_measured(loss)} |" for size, loss in random_losses.items()]
    lines += ["\n## Payloads as a rover has them\n"]
    lines += ["| What | Bytes | What varies | Formula | Lines lose | Lengths lose |", "|---|--:|---|--:|--:|--:|"]
    for name, (size, by_line, by_length) in structured.items():
        text = STRUCTURED[name][0]
        row = (name, str(size), text, f"{by_formula(size):.2%}", _measured(by_line), f"{by_length.share:.2%}")
        lines.append(f"| {' | '.join(row)} |")
    lines.append(_TAIL.format(imu=by_formula(_RANDOM_IMU_BYTES)))
    return "\n".join(lines) + "\n"


def _measured(loss: Loss) -> str:
    return f"{loss.share:.2%} ± {loss.uncertainty:.2%}"


def picture(random_losses: Mapping[int, Loss], structured: Mapping[str, tuple[int, Loss, Loss]]) -> str:
    """Return the picture: the formula as a curve, what was measured as points."""
    curve = " ".join(f"{_x(size):.1f},{_y(by_formula(size)):.1f}" for size in range(1, _MAX_SIZE))
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {_HEIGHT}" {_FONT}>',
        "<title>Share of frames that a line-splitting client loses</title>",
        f'<rect width="{_WIDTH}" height="{_HEIGHT}" fill="white"/>',
        *_axes(),
        f'<polyline points="{curve}" fill="none" stroke="#0072b2" stroke-width="2"/>',
        *_points(((size, loss.share, "") for size, loss in random_losses.items()), "#0072b2"),
        *_points(((size, loss.share, name) for name, (size, loss, _) in structured.items()), "#d55e00"),
        f'<text x="{_x(6)}" y="{_TOP + 14}" fill="#0072b2">1 - (255/256)^(N+2), and random payloads</text>',
        f'<text x="{_x(6)}" y="{_TOP + 30}" fill="#d55e00">payloads as a rover has them</text>',
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def _x(size: float) -> float:
    return _LEFT + size / _MAX_SIZE * (_WIDTH - _LEFT - 16)


def _y(share: float) -> float:
    return _HEIGHT - _BOTTOM - share / _MAX_SHARE * (_HEIGHT - _BOTTOM - _TOP)


def _axes() -> Iterable[str]:
    for percent in range(0, 36, 5):
        y = _y(percent / 100)
        yield f'<line x1="{_LEFT}" x2="{_WIDTH - 16}" y1="{y:.1f}" y2="{y:.1f}" stroke="#dddddd"/>'
        yield f'<text x="{_LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{percent} %</text>'
    for size in range(0, _MAX_SIZE, 8):
        yield f'<text x="{_x(size):.1f}" y="{_HEIGHT - _BOTTOM + 18}" text-anchor="middle">{size}</text>'
    middle = (_LEFT + _WIDTH) / 2
    yield f'<text x="{middle}" y="{_HEIGHT - 8}" text-anchor="middle">payload, bytes</text>'


def _points(points: Iterable[tuple[int, float, str]], colour: str) -> Iterable[str]:
    """Draw points, each with its name; those that lie upon each other share a line of text."""
    names: dict[tuple[int, int], list[str]] = {}
    places: dict[tuple[int, int], tuple[float, float]] = {}
    for size, share, name in points:
        key = size, round(_y(share) / 8)
        yield f'<circle cx="{_x(size):.1f}" cy="{_y(share):.1f}" r="4" fill="{colour}"/>'
        places.setdefault(key, (_x(size), _y(share)))
        names.setdefault(key, []).extend([name] if name else [])
    for (size, row), together in names.items():
        if together:
            x, y = places[size, row]
            dx, anchor = (-8, "end") if size > _MAX_SIZE * 0.45 else (8, "start")
            text = escape("; ".join(together))
            yield f'<text x="{x + dx:.1f}" y="{y + 4:.1f}" text-anchor="{anchor}" fill="{colour}">{text}</text>'
