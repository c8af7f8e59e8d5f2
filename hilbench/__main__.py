"""``python -m hilbench``: the same as the command ``hilbench``."""

from __future__ import annotations

import sys

from hilbench.siblings import leave_working_folder

leave_working_folder()

from hilbench.cli import main  # noqa: E402 - what it imports must not come from the working folder

if __name__ == "__main__":
    sys.exit(main())
