"""What a person has chosen for all benches: a TOML file of one's own.

It is ``$XDG_CONFIG_HOME/hilbench/settings.toml``, else below ``~/.config`` (XDG Base Directory Specification 0.8). It
changes how hilbench shows things and what it opens unasked, never what a check finds.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

__all__ = ["Settings", "settings", "settings_file"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """The file.

    Attributes:
        bench: the bench of ``hilbench`` and ``hilbench check`` where none is named and there is no ``hilbench.toml``;
            empty for the default one.
        plain: print as into a file, as with ``--plain``.
        theme: the theme that the dashboard begins with; empty for the one that was chosen last.
    """

    bench: str = ""
    plain: bool = False
    theme: str = ""


def settings() -> Settings:
    """Return what the file says; the defaults if there is none.

    Raises:
        UsageError: it is wrong; the line is named.
    """
    file = settings_file()
    try:
        if not file.exists():
            return Settings()
    except PermissionError:  # the home of somebody else, as where HOME outlives a change of the user
        return Settings()
    from hilbench.strict import Strict
    from hilbench.strict.toml_file import TomlFile

    toml = TomlFile(file, "settings file")
    return Strict(toml.place).convert(toml.data, Settings)


def settings_file() -> Path:
    """Return where the file is, or would be."""
    home = os.environ.get("XDG_CONFIG_HOME", "")
    folder = Path(home) if Path(home).is_absolute() else Path(os.environ.get("HOME", "/")) / ".config"
    return folder / "hilbench" / "settings.toml"
