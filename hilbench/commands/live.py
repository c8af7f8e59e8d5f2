"""``hilbench live``: the process of a live bench, which a dashboard starts; nobody types it."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from hilbench.errors import UsageError
from hilbench.strict.changes import parse_change
from hilbench.terminal import arguments, interruption
from hilbench.terminal.parser import Parser, typed

if TYPE_CHECKING:
    from hilbench.benchfile.bench_file import BenchFile


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser("hilbench live", "Run a bench for a dashboard.", "hilbench live pioneer --folder FOLDER")
    made.add_argument("what", metavar="TARGET|BENCH", nargs="?", help="as of 'hilbench serve'")
    made.add_argument("--folder", metavar="FOLDER", required=True, help="private folder for journal and socket")
    made.add_argument("--seed", metavar="N", type=typed(arguments.seed), default=0, help="seed of the run")
    made.add_argument("--target", metavar="[NAME=]T", action="append", default=[], type=typed(arguments.target_choice),
        help="a serial port or pyserial URL instead of the bench file's target")  # fmt: skip
    made.add_argument("--scene", metavar="S", help="scene to stand in instead of that of the bench file")
    made.add_argument("--journal", metavar="FILE", type=typed(arguments.output_file), help="another place for it")
    made.add_argument("--set", metavar="KEY=VALUE", dest="changes", action="append", default=[],
        type=typed(parse_change), help="a different value than in the bench file")  # fmt: skip
    made.add_argument("--no-demo", action="store_true", help="nobody drives at first")
    return made


def in_scene(bench_file: BenchFile, scene: str | None) -> BenchFile:
    """Return a bench in another scene than that of its file; the same if none is named.

    Raises:
        UsageError: there is no such scene, or no world for it.
    """
    from dataclasses import replace

    import msgspec

    from hilbench.benchfile.reader import resolve_scene

    if scene is None:
        return bench_file
    if not bench_file.has_world:
        raise UsageError("no target of this bench has a world", where=f"--scene {scene}")
    resolved = resolve_scene(scene, Path(), "--scene")
    return replace(bench_file, world=msgspec.structs.replace(bench_file.world, scene=resolved))


def run(parsed: argparse.Namespace) -> int:
    """Run the command; see `hilbench.live.session.run_live`."""
    from hilbench.live.folders import Session
    from hilbench.live.scenes import scene_for
    from hilbench.live.session import LiveOptions, run_live
    from hilbench.mcu.command_line import open_target

    options = LiveOptions(
        session=Session(Path(parsed.folder)),
        seed=parsed.seed,
        demo=not parsed.no_demo,
        journal=parsed.journal,
        targets=tuple(parsed.target),
    )
    bench_file = open_target(parsed.what, changes=parsed.changes)
    bench_file = in_scene(bench_file, scene_for(bench_file) if parsed.scene is None else parsed.scene)
    interruption.raise_once()
    return run_live(bench_file, options)
