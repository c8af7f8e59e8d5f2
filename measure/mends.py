"""``python -m measure.mends [NAME ...]``: takes mends out of a copy of the last commit; their tests must fail.

`mends.toml` has the edits. The exit code is 1 if a test passes without its mend.
"""

from __future__ import annotations

import subprocess
import sys
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from measure.gate_proof.copies import Copy, a_folder, copy_of

MENDS: Mapping[str, Mapping[str, Any]] = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))


def fails_without(copy: Copy, mend: Mapping[str, Any]) -> bool:
    """Say whether the tests of a mend fail where it is taken out."""
    files = {copy.tree / edit["file"] for edit in mend["edits"]}
    kept = {file: file.read_text(encoding="utf-8") for file in files}
    for edit in mend["edits"]:
        file = copy.tree / edit["file"]
        file.write_text(file.read_text(encoding="utf-8").replace(edit["has"], edit["had"]), encoding="utf-8")
    words = [str(copy.python), "-m", "pytest", "-q", "-x", *mend["tests"]]
    done = subprocess.run(words, cwd=copy.tree, check=False, capture_output=True, text=True)
    for file, text in kept.items():
        file.write_text(text, encoding="utf-8")
    return done.returncode == 1


def main() -> int:
    """Take out those that are named, or all."""
    names, held = sys.argv[1:] or [*MENDS], True
    with a_folder() as folder:
        copy = copy_of("HEAD", folder / "tree")
        for name in names:
            found = fails_without(copy, MENDS[name])
            sys.stdout.write(f"{name}: {'fails without it' if found else 'PASSES without it'}\n")
            sys.stdout.flush()
            held &= found
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
