from __future__ import annotations

import json
import sys
import tomllib
from pathlib import Path
from textwrap import dedent

import pytest

from hilbench.check import catalogue
from hilbench.cli import main
from hilbench.plugins.discovery import PLUGINS, Plugins

TINY = '''
"""Lines of text."""

from dataclasses import dataclass, field
from types import SimpleNamespace

from hilbench.plugins.protocol import ProtocolPlugin
from protocols.common.items import Item, Kind


@dataclass(frozen=True)
class Options:
    loud: bool = field(default=False, metadata={"help": "in capitals"})
    most: int = field(default=80, metadata={"help": "letters in a line"})


class Lines:
    def __init__(self, options, speaker):
        self.options, self.rest = options, b""

    def find(self, data):
        *lines, self.rest = (self.rest + data).split(b"\\n")
        return [line + b"\\n" for line in lines]

    def sort(self, found):
        return found[:1]

    def read(self, found):
        text = found[:-1].decode("ascii", "replace")[: self.options.most]
        return Item(kind=Kind.FRAME, name=text.upper() if self.options.loud else text, raw=found)

    def feed(self, data):
        return map(self.read, self.find(data))

    def finish(self):
        return [Item(kind=Kind.DROPPED, name="no end", raw=self.rest)] if self.rest else []


def clauses():
    about = {"suite": "tiny", "level": "must", "title": "ends", "text": "A line ends.", "source": "tiny.py"}
    return [SimpleNamespace(id="TINY1", needs=(), **about)]


TINY = ProtocolPlugin(
    api=1, name="tiny", title="Tiny", summary="lines of text", decoder=Lines, options=Options, clauses=clauses
)
'''


@pytest.fixture
def plugins(monkeypatch):
    """Return what is known of plug-ins in this process; it is forgotten again."""
    fresh, modules = Plugins(), set(sys.modules)
    monkeypatch.setattr(PLUGINS, "__dict__", fresh.__dict__)
    monkeypatch.setattr(sys, "path", [*sys.path])
    catalogue._clauses.cache_clear()
    yield PLUGINS
    catalogue._clauses.cache_clear()
    for name in [*filter(_is_brought, set(sys.modules) - modules)]:
        del sys.modules[name]


def _is_brought(name):
    """Say whether a module comes from a folder of a test, or is an example."""
    file = getattr(sys.modules[name], "__file__", None) or ""
    return "pytest-of" in file or any(f"{Path('examples', one)}" in file for one in ("tank", "pantilt"))


@pytest.fixture
def package(tmp_path, monkeypatch, plugins):
    """Return what installs a package: a module with a source, and an entry point for each protocol."""

    def install(name, source, entries, folder="site"):
        site = tmp_path / folder
        about = site / f"{name}-1.0.dist-info"
        about.mkdir(parents=True)
        about.joinpath("METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        points = "".join(f"{protocol} = {value}\n" for protocol, value in entries.items())
        about.joinpath("entry_points.txt").write_text(f"[hilbench.protocols]\n{points}")
        site.joinpath(f"{name}.py").write_text(dedent(source))
        monkeypatch.syspath_prepend(site)

    return install


@pytest.fixture
def example(tmp_path, monkeypatch, plugins):
    """Return what installs an example: its package, and its entry points."""

    def install(folder):
        about = tmp_path / "site" / f"hilbench_{folder.name}-1.0.dist-info"
        about.mkdir(parents=True)
        lines = []
        for group, points in tomllib.loads((folder / "pyproject.toml").read_text())["project"]["entry-points"].items():
            lines += [f"[{group}]", *(f"{name} = {value}" for name, value in points.items())]
        about.joinpath("entry_points.txt").write_text("\n".join(lines) + "\n")
        about.joinpath("METADATA").write_text(f"Metadata-Version: 2.1\nName: hilbench-{folder.name}\nVersion: 1.0\n")
        monkeypatch.syspath_prepend(about.parent)
        monkeypatch.syspath_prepend(folder)

    return install


@pytest.fixture
def verdicts(hilbench, tmp_path):
    """Return what checks a bench: the exit code, and the verdict of each clause."""

    def check(*words):
        report = tmp_path / "report.json"
        code, _, err = hilbench("check", *words, "--json", report)
        assert report.is_file(), err
        return code, {one["id"]: one["verdict"] for one in json.loads(report.read_text())["clauses"]}

    return check


@pytest.fixture
def tiny(tmp_path):
    """Return a file that brings a protocol."""
    path = tmp_path / "tiny.py"
    path.write_text(TINY)
    return path


@pytest.fixture
def hilbench(capsys, plugins):
    """Return what runs a command in this process: its exit code, and what it writes."""

    def run(*words):
        code = main([str(word) for word in words])
        out, err = capsys.readouterr()
        return code, out, err

    return run
