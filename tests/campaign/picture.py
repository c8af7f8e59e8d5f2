"""The tracks from above, as SVG, written by hand: a picture needs no library."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from xml.sax.saxutils import escape

from worlds.scenes import Scene

Point = tuple[float, float]

PX_PER_M = 60
MARGIN_PX = 16
LEGEND_PX = 92
LEAST_STEP_M = 0.02
COLOURS = ("#0072b2", "#d55e00", "#009e73")
"""Blue, vermilion and green of Okabe and Ito: told apart by everybody."""


def picture(scene: Scene, tracks: Mapping[str, Sequence[Point]], outline: Sequence[Point]) -> str:
    """Return the picture.

    Args:
        scene: what stands around.
        tracks: where the robot was, by what the legend says.
        outline: the robot from above, drawn where it begins.
    """
    view = _View([corner for box in scene.boxes for corner in box.outline_m()])
    size = f"0 0 {view.width} {view.height + LEGEND_PX}"
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{size}" font-family="sans-serif" font-size="14">',
        f"<title>{scene.name} from above, with the tracks of the dodger</title>",
        f'<rect width="{view.width}" height="{view.height + LEGEND_PX}" fill="white"/>',
        *(f'<polygon points="{view.points(box.outline_m())}" fill="#9a9a9a"/>' for box in scene.boxes),
        f'<polygon points="{view.points(outline)}" fill="#e8e8e8" stroke="#444444"/>',
    ]
    for (name, track), colour in zip(tracks.items(), COLOURS, strict=False):
        lines += _track(view, name, track, colour)
    lines += [*_legend(view, tracks), "</svg>"]
    return "\n".join(lines) + "\n"


class _View:
    """From metres, y up, to pixels, y down."""

    def __init__(self, corners: Sequence[Point]) -> None:
        xs, ys = [x for x, _ in corners], [y for _, y in corners]
        self._left, self._top = min(xs), max(ys)
        self.width = round((max(xs) - min(xs)) * PX_PER_M) + 2 * MARGIN_PX
        self.height = round((max(ys) - min(ys)) * PX_PER_M) + 2 * MARGIN_PX

    def point(self, point: Point) -> Point:
        x, y = point
        return MARGIN_PX + (x - self._left) * PX_PER_M, MARGIN_PX + (self._top - y) * PX_PER_M

    def points(self, points: Iterable[Point]) -> str:
        return " ".join(f"{x:.1f},{y:.1f}" for x, y in map(self.point, points))


def _track(view: _View, name: str, track: Sequence[Point], colour: str) -> Iterable[str]:
    x, y = view.point(track[-1])
    yield (
        f'<polyline points="{view.points(_thinned(track))}" fill="none" stroke="{colour}" stroke-width="2" '
        f'stroke-linejoin="round"><title>{escape(name)}</title></polyline>'
    )
    yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="6" fill="{colour}" stroke="white" stroke-width="1.5"/>'


def _thinned(track: Sequence[Point]) -> list[Point]:
    """Leave out what is nearer to the point before than can be seen."""
    kept = [track[0]]
    for x, y in track[1:]:
        if (x - kept[-1][0]) ** 2 + (y - kept[-1][1]) ** 2 >= LEAST_STEP_M**2:
            kept.append((x, y))
    return [*kept, track[-1]]


def _legend(view: _View, names: Iterable[str]) -> Iterable[str]:
    y = view.height + 8
    for name, colour in zip(names, COLOURS, strict=False):
        yield f'<line x1="{MARGIN_PX}" y1="{y}" x2="{MARGIN_PX + 30}" y2="{y}" stroke="{colour}" stroke-width="3"/>'
        yield f'<text x="{MARGIN_PX + 38}" y="{y + 5}" fill="#222222">{escape(name)}</text>'
        y += 22
    right = view.width - MARGIN_PX
    yield f'<line x1="{right - PX_PER_M}" y1="{y}" x2="{right}" y2="{y}" stroke="#222222" stroke-width="2"/>'
    yield f'<text x="{right - PX_PER_M - 38}" y="{y + 5}" fill="#222222">1 m</text>'
    note = "outline: the robot at its start; dots: where it ends"
    yield f'<text x="{MARGIN_PX}" y="{y + 5}" fill="#222222">{note}</text>'
