"""What a person has chosen for all benches: what it does, and what is said of a file that is wrong."""

from __future__ import annotations

import errno
import io
import os
from pathlib import Path

import pytest

from hilbench.cli import main
from hilbench.commands.dashboard import theme
from hilbench.terminal.console import Console
from hilbench.terminal.settings import Settings, settings, settings_file
from tests.each import each


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def write(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.chdir(tmp_path)

    def written(text):
        settings_file().parent.mkdir(parents=True, exist_ok=True)
        settings_file().write_text(text)

    return written


def test_the_file_stands_where_xdg_says(monkeypatch):
    monkeypatch.setenv("HOME", "/home/somebody")
    monkeypatch.setenv("XDG_CONFIG_HOME", "relative")
    assert str(settings_file()) == "/home/somebody/.config/hilbench/settings.toml"
    monkeypatch.setenv("XDG_CONFIG_HOME", "/there")
    assert str(settings_file()) == "/there/hilbench/settings.toml"


@pytest.mark.usefixtures("write")
def test_without_a_file_nothing_is_chosen():
    assert settings() == Settings()
    assert theme() == ""


def test_in_the_home_of_somebody_else_nothing_is_chosen(monkeypatch):
    def refuse(_path, **_options):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr(Path, "exists", refuse)
    assert settings() == Settings()


def test_all_can_be_chosen(write):
    write('bench = "rover"\nplain = true\ntheme = "nord"\n')
    assert settings() == Settings(bench="rover", plain=True, theme="nord")
    assert theme() == "nord"


@each(
    ("text", "said"),
    [
        ("plian = true", "settings.toml:1: unknown key 'plian'; did you mean 'plain'?"),
        ("\nplain = 1", "settings.toml:2: 'plain': must be true or false, not a whole number"),
        ("plain = x", "settings.toml:1: is not TOML"),
        ('bench = "roover"', "settings.toml: bench: roover: no such bench; did you mean 'rover'?"),
    ],
)
def test_a_wrong_file_is_named_with_what_is_wrong(write, capfd, text, said):
    write(text)
    assert main(["check", "--list"]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert said in err
    assert err.count("\n") == 1


def test_a_theme_that_is_none_is_named(write):
    write('theme = "nrod"')
    with pytest.raises(Exception, match=r"settings\.toml: no theme 'nrod'; did you mean 'nord'\?"):
        theme()


def test_a_check_without_a_name_takes_the_chosen_bench(write, capfd):
    def listed(*words):
        assert main(["check", "--list", *words]) == 0
        return capfd.readouterr().out

    write('bench = "rover-model"')
    assert listed() == listed("rover-model") != listed("pioneer")
    assert listed("--suite", "p2os-server") == listed("pioneer", "--suite", "p2os-server")


def test_a_bench_of_this_folder_comes_before_the_chosen_one(write, capfd, tmp_path):
    write('bench = "rover-model"')
    (tmp_path / "hilbench.toml").write_text('version = 1\n[targets.robot]\nmodel = "pioneer-2dx"\n')
    assert main(["check", "--list", "-k", "S01"]) == 0
    assert "S01" in capfd.readouterr().out


def test_plain_prints_to_a_terminal_as_into_a_file(write, monkeypatch):
    seen = []

    def look(_):
        console = Console(out=Terminal(), err=Terminal())
        seen.append((console.colours, console.terminal, console.watched))
        return 0

    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setattr("hilbench.commands.check.run", look)
    main(["check"])
    main(["check", "--plain"])
    main(["check"])
    write("plain = true")
    main(["check"])
    assert seen == [(True,) * 3, (False,) * 3, (True,) * 3, (False,) * 3]
    Console.plain = False
