"""Scenes from above with what drove in them, as SVG, written by hand: a picture needs no library."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape

from worlds.scenes import Box, Lane, Scene

__all__ = ["COLOURS", "Sheet", "fitting_sheet", "top_view"]

Point = tuple[float, float]

MARGIN_PX = 16
LEGEND_PX = 92
LEAST_STEP_PX = 1.2
LEAST_BOX_PX = 5
LEAST_BAR_PX = 40
LEAST_SPAN_M = 2.0
LEAST_WIDTH_PX = 560
NICE_M = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
COLOURS = ("#0072b2", "#d55e00", "#009e73")
"""Blue, vermilion and green of Okabe and Ito: told apart by everybody. More tracks than these are not drawn."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sheet:
    """What is not in the scene.

    Attributes:
        title: of the picture.
        px_per_m: its scale.
        bar_m: length of the bar that shows the scale.
        note: what outline and dots are.
    """

    title: str
    px_per_m: float = 60
    bar_m: float = 1
    note: str = "outline: the robot at its start; dots: where it ends"


def fitting_sheet(
    scene: Scene,
    tracks: Mapping[str, Sequence[Point]],
    outlines: Sequence[Sequence[Point]],
    size_px: tuple[int, int],
    *,
    title: str,
    note: str,
) -> Sheet:
    """Return the sheet of the largest scale at which everything `top_view` draws fits into ``size_px``."""
    points = _extent(scene, tracks, outlines)
    spans_m = [max(along) - min(along) for along in zip(*points, strict=True)]
    across_px, down_px = (most - 2 * MARGIN_PX for most in (size_px[0], size_px[1] - LEGEND_PX))
    px_per_m = min(across_px / max(spans_m[0], LEAST_SPAN_M), down_px / max(spans_m[1], LEAST_SPAN_M))
    bar_m = next((nice for nice in NICE_M if nice * px_per_m >= LEAST_BAR_PX), NICE_M[-1])
    return Sheet(title=title, px_per_m=px_per_m, bar_m=bar_m, note=note)


def top_view(
    scene: Scene, tracks: Mapping[str, Sequence[Point]], outlines: Sequence[Sequence[Point]], sheet: Sheet
) -> str:
    """Return the picture.

    Args:
        scene: what stands around, and where to drive.
        tracks: where the vehicle was, metres, by what the legend says.
        outlines: the vehicle from above, in one piece or in several, metres.
        sheet: the rest.
    """
    view = _View(_extent(scene, tracks, outlines), sheet.px_per_m)
    size = f"0 0 {view.width} {view.height + LEGEND_PX}"
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{size}" font-family="sans-serif" font-size="14">',
        f"<title>{escape(sheet.title)}</title>",
        f'<rect width="{view.width}" height="{view.height + LEGEND_PX}" fill="white"/>',
        *(_lane(view, scene.lane, sheet.px_per_m) if scene.lane else ()),
        *(_box(view, box, sheet.px_per_m) for box in scene.boxes),
        *(f'<polygon points="{view.points(one)}" fill="#e8e8e8" stroke="#444444"/>' for one in outlines),
    ]
    for (name, track), colour in zip(tracks.items(), COLOURS, strict=False):
        lines += _track(view, name, track, colour)
    lines += [*_legend(view, tracks, sheet), "</svg>"]
    return "\n".join(lines) + "\n"


def _extent(scene: Scene, tracks: Mapping[str, Sequence[Point]], outlines: Sequence[Sequence[Point]]) -> list[Point]:
    """Points between which everything that is drawn lies."""
    points = [corner for box in scene.boxes for corner in box.outline_m()]
    if scene.lane:
        aside = scene.lane.width_m / 2
        points += [(x + way * aside, y + way * aside) for x, y in scene.lane.center_m for way in (-1, 1)]
    points += (point for line in (*outlines, *tracks.values()) for point in line)
    return points


class _View:
    """From metres, y up, to pixels, y down."""

    def __init__(self, corners: Sequence[Point], px_per_m: float) -> None:
        self._left, right = _wide(max(LEAST_SPAN_M, LEAST_WIDTH_PX / px_per_m), (x for x, _ in corners))
        low, self._top = _wide(LEAST_SPAN_M, (y for _, y in corners))
        self._px_per_m = px_per_m
        self.width = round((right - self._left) * px_per_m) + 2 * MARGIN_PX
        self.height = round((self._top - low) * px_per_m) + 2 * MARGIN_PX

    def point(self, point: Point) -> Point:
        x, y = point
        return MARGIN_PX + (x - self._left) * self._px_per_m, MARGIN_PX + (self._top - y) * self._px_per_m

    def points(self, points: Iterable[Point]) -> str:
        return " ".join(f"{x:.1f},{y:.1f}" for x, y in map(self.point, points))

    def thinned(self, track: Sequence[Point]) -> list[Point]:
        """Leave out what is nearer to the point before than can be seen."""
        kept, least_m = [track[0]], LEAST_STEP_PX / self._px_per_m
        for x, y in track[1:]:
            if (x - kept[-1][0]) ** 2 + (y - kept[-1][1]) ** 2 >= least_m**2:
                kept.append((x, y))
        return [*kept, track[-1]]


def _wide(least_m: float, values: Iterable[float]) -> tuple[float, float]:
    """Least and largest of them, and as far from their middle as is asked for."""
    ordered = sorted(values)
    beyond_m = max(0.0, least_m - (ordered[-1] - ordered[0])) / 2
    return ordered[0] - beyond_m, ordered[-1] + beyond_m


def _box(view: _View, box: Box, px_per_m: float) -> str:
    """Its outline; a dot where that could hardly be seen."""
    if max(box.size_m[:2]) * px_per_m >= LEAST_BOX_PX:
        return f'<polygon points="{view.points(box.outline_m())}" fill="#9a9a9a"/>'
    x, y = view.point(box.center_m[:2])
    return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{LEAST_BOX_PX / 2:g}" fill="#e69f00"/>'


def _lane(view: _View, lane: Lane, px_per_m: float) -> Iterable[str]:
    """Asphalt, and a dashed line in its middle."""
    shape = "polygon" if lane.closed else "polyline"
    drawn = f'<{shape} points="{view.points(view.thinned(lane.center_m))}" fill="none" stroke-linejoin="round"'
    yield f'{drawn} stroke="#e3e3e3" stroke-width="{lane.width_m * px_per_m:.1f}"/>'
    yield f'{drawn} stroke="#ffffff" stroke-dasharray="8 8"/>'


def _track(view: _View, name: str, track: Sequence[Point], colour: str) -> Iterable[str]:
    x, y = view.point(track[-1])
    yield (
        f'<polyline points="{view.points(view.thinned(track))}" fill="none" stroke="{colour}" stroke-width="2" '
        f'stroke-linejoin="round"><title>{escape(name)}</title></polyline>'
    )
    yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="6" fill="{colour}" stroke="white" stroke-width="1.5"/>'


def _legend(view: _View, names: Iterable[str], sheet: Sheet) -> Iterable[str]:
    y = view.height + 8
    for name, colour in zip(names, COLOURS, strict=False):
        yield f'<line x1="{MARGIN_PX}" y1="{y}" x2="{MARGIN_PX + 30}" y2="{y}" stroke="{colour}" stroke-width="3"/>'
        yield f'<text x="{MARGIN_PX + 38}" y="{y + 5}" fill="#222222">{escape(name)}</text>'
        y += 22
    right, bar_px = view.width - MARGIN_PX, sheet.bar_m * sheet.px_per_m
    yield f'<line x1="{right - bar_px:g}" y1="{y}" x2="{right}" y2="{y}" stroke="#222222" stroke-width="2"/>'
    label = f"{sheet.bar_m} m"
    yield f'<text x="{right - bar_px - 24 - 7 * len(label) + 7:g}" y="{y + 5}" fill="#222222">{label}</text>'
    yield f'<text x="{MARGIN_PX}" y="{y + 5}" fill="#222222">{escape(sheet.note)}</text>'
