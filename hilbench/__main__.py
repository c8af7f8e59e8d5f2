"""The process: the command ``hilbench``, and ``python -m hilbench``, which does the same.

From its first line on an interruption is one line and an exit code; everything else is imported after that.
"""

from __future__ import annotations

import os
import sys

from hilbench.terminal import interruption, own_process


def main() -> int:
    """Run the command line of this process and return its exit code; nothing is left to be done then but to exit."""
    interruption.end_at_once()
    own_process.claim()
    if __name__ == "__main__":
        from hilbench.cli.siblings import leave_working_folder

        leave_working_folder()  # what is imported from now on must not come from there

    from hilbench.cli import main as run
    from hilbench.exit_codes import ExitCode

    code = run()
    interruption.ignore()
    if code == ExitCode.INTERRUPTED:
        # Python dies of SIGINT at its end if KeyboardInterrupt has ever left an exec(), as it may in an import.
        os._exit(code)
    return code


if __name__ == "__main__":
    sys.exit(main())
