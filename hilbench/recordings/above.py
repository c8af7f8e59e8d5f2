"""A moment of a recording from above, as SVG."""

from __future__ import annotations

from hilbench.recordings.moments import Moment
from worlds.above import fitting_sheet, top_view

__all__ = ["map_of"]


def map_of(moment: Moment, size_px: tuple[int, int], *, title: str, note: str) -> str:
    """Return what stands there, where the vehicle is and where it has been.

    Args:
        moment: of a recording.
        size_px: width and height that the drawing fits into.
        title: of the picture.
        note: what stands below it.
    """
    x_m, y_m, _ = moment.pose.position_m
    outlines = moment.stage.outlines_m(x_m, y_m, moment.pose.yaw_rad)
    tracks = {"the way to here": moment.track}
    sheet = fitting_sheet(moment.stage.scene, tracks, outlines, size_px, title=title, note=note)
    return top_view(moment.stage.scene, tracks, outlines, sheet)
