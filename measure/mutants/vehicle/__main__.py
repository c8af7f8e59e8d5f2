"""Runs every faulty vehicle interface and writes the page: ``python -m measure.mutants.vehicle``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from measure.mutants.defects_page import Found, by_clauses, killers
from measure.mutants.vehicle.page import PAGE, page
from measure.mutants.vehicle.runs import asked, image_of, run, run_image, to_run
from measure.mutants.vehicle.tables import all_mutants
from targets.robots.vehicle_interface import DEFECTS


def main(words: Sequence[str]) -> int:
    """Run them all and write the page; 1 if one survives."""
    parser = argparse.ArgumentParser(prog="python -m measure.mutants.vehicle", description=__doc__)
    parser.add_argument("--firmware", action="store_true", help="run the images alone; the model is as on the page")
    parser.add_argument("--model", action="store_true", help="run the model alone; the firmware is as on the page")
    parser.add_argument("--clauses", nargs="+", help="run these on the model alone; the rest is as on the page")
    parser.add_argument("--only", nargs="+", metavar="FAULT", help="run these in the model; all else is as on the page")
    chosen = parser.parse_args(words)
    if chosen.only or chosen.clauses:
        said = {name: clauses for name, clauses in PAGE.said().items() if name not in (chosen.only or ())}
        found = by_clauses(said, all_mutants(), chosen.clauses or (), asked=asked, run=run)
        PAGE.path.write_text(page(found, PAGE.said_of_firmware()), encoding="utf-8")
        return 0
    found = PAGE.said() if chosen.firmware else {mutant.id: killers(run(mutant)) for mutant in all_mutants()}
    firmware: Found = PAGE.said_of_firmware() if chosen.model and PAGE.path.is_file() else {}
    if not chosen.model:
        images = [name for name in DEFECTS if image_of(name).is_file() and found[name]]
        firmware = {name: killers(run_image(name, to_run(found[name]))) for name in images}
    PAGE.path.write_text(page(found, firmware), encoding="utf-8")
    survivors = [name for name, clauses in (*found.items(), *firmware.items()) if not clauses]
    sys.stderr.write("".join(f"{name} survives\n" for name in survivors))
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
