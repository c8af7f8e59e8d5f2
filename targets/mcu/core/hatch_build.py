"""Puts the library into wheels, and beside its sources for an editable install. hatchling calls it (pyproject.toml).

``HILBENCH_WHEEL_MACHINE=aarch64`` makes a manylinux wheel for that machine on any other, with the compiler of ziglang
(`make wheels`).
"""

from __future__ import annotations

import os
import shutil
import sys
import sysconfig
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hatchling.builders.config import BuilderConfig
from hatchling.builders.hooks.plugin.interface import BuildHookInterface

_ZIGLANG = "ziglang>=0.16,<0.18"
_TAG = "manylinux_2_17_{0}.manylinux2014_{0}"
"""The tag of what runs with glibc 2.17, by its new and its old name (PEP 600, PEP 599)."""


class CoreBuildHook(BuildHookInterface[BuilderConfig]):
    """Compiles before a wheel is made."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        if self.root not in sys.path:
            sys.path.insert(0, self.root)
        self._machine = os.environ.get("HILBENCH_WHEEL_MACHINE", "")
        self._scratch: Path | None = None

    def dependencies(self) -> list[str]:
        """Return what the build needs beside hatchling: a compiler from PyPI, where there is no other."""
        from targets.mcu.core.build import find_compiler

        return [] if not self._machine and (self._compiled() or find_compiler()) else [_ZIGLANG]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile, and say what the wheel holds and where it runs."""
        from targets.mcu.core.build import build
        from targets.mcu.core.sources import file_name
        from targets.mcu.errors import EngineError

        try:
            if version == "editable":
                build()
                return
            library = self._cross_compiled() if self._machine else self._compiled() or self._compiled_here()
        except EngineError as error:
            self.app.abort(f"{error}; {error.hint}")
        build_data["force_include"][str(library)] = f"targets/mcu/core/{file_name(self._machine)}"
        build_data["pure_python"] = False
        platform = _TAG.format(self._machine) if self._machine else sysconfig.get_platform()
        build_data["tag"] = f"py3-none-{platform.replace('-', '_')}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:  # noqa: ARG002
        """Remove what was compiled for the wheel alone."""
        if self._scratch is not None:
            shutil.rmtree(self._scratch)

    def _compiled(self) -> Path | None:
        from targets.mcu.core.sources import current, digest_of, places

        digest = digest_of()
        return current(digest, places(digest))

    def _compiled_here(self) -> Path:
        from targets.mcu.core.build import some_compiler

        return self._compiled_aside(some_compiler())

    def _cross_compiled(self) -> Path:
        from targets.mcu.core.build import zig_for

        return self._compiled_aside(zig_for(self._machine))

    def _compiled_aside(self, compiler: Sequence[str]) -> Path:
        """Compile without a trace in the folder of the sources."""
        from targets.mcu.core.build import compile_library

        self._scratch = Path(tempfile.mkdtemp(prefix="hilbench-core-"))
        library = self._scratch / "library.so"
        compile_library(library, compiler)
        return library
