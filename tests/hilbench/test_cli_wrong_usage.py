"""Wrong command lines: one line that says what and where, the right exit code, and nothing else."""

from __future__ import annotations

import pytest

from hilbench.cli import main

WRONG = [
    ("", "the dashboard needs a terminal, and this is none; try 'hilbench check' or 'hilbench --help'"),
    ("pioneer", "the dashboard needs a terminal, and this is none; try 'hilbench check' or 'hilbench --help'"),
    ("pioneer --sede 3", "hilbench: unknown option --sede; did you mean '--seed'?"),
    ("attach --lits", "attach: unknown option --lits; did you mean '--list'?"),
    ("replay", "replay: JOURNAL is missing; see 'hilbench replay --help'"),
    ("replay none.jsonl", "the dashboard needs a terminal, and this is none; 'hilbench decode' does without"),
    ("chekc", "unknown command 'chekc'; did you mean 'check'?"),
    ("--verison", "unknown option '--verison'; did you mean '--version'?"),
    ("--html", "unknown option '--html'; options: --help, --version, --journal"),
    ("run --html", "run: unknown option --html; options: "),
    ("check --sede 3", "check: unknown option --sede; did you mean '--seed'?"),
    ("check --seed", "--seed: expected one argument"),
    ("check --seed x", "--seed: 'x' is not a whole number"),
    ("check --seed -1", "--seed: -1 is not between 0 and"),
    ("check --timeout-scale 0.5", "--timeout-scale: '0.5' is not a factor of 1 to 1000"),
    ("check --timeout-scale 1e308", "--timeout-scale: '1e308' is not a factor of 1 to 1000"),
    ("check --timeout-scale nan", "--timeout-scale: 'nan' is not a factor"),
    ("check --strict=1", "--strict: ignored explicit argument '1'"),
    ("check pioneer extra", "check: 'extra' is one argument too many"),
    ("pionere", "unknown command 'pionere'; did you mean 'pioneer'?"),
    ("pioner", "unknown command 'pioner'; did you mean 'pioneer'?"),
    ("check pioner", "pioner: no such bench; did you mean 'pioneer'?"),
    ("completion", "completion: SHELL is missing"),
    ("completion tcsh", "SHELL: invalid choice: 'tcsh'"),
    ("check pionere", "pionere: no such bench; did you mean 'pioneer'?"),
    ("pkt", "'pkt' is a protocol; name a command, or a bench file whose target speaks it"),
    ("check pkt", "pkt: no such bench; 'pkt' is a protocol; name a bench file whose target speaks it"),
    ("check ./none.toml", "none.toml: no such bench file"),
    ("check pioneer --suite p2os-sever", "--suite p2os-sever: no such suite or file; did you mean 'p2os-server'?"),
    ("check pioneer --suite pyproject.txt", "--suite pyproject.txt: no such suite or file"),
    ("check pioneer -k", "-k: expected one argument"),
    ("check pioneer -k (", "-k '(': a word is missing at the end"),
    ("check pioneer -k nosuchcase", "-k 'nosuchcase': nothing is selected; see 'hilbench check --list'"),
    ("check pioneer --target robot=", "--target: 'robot=' names no target"),
    ("check pioneer --target pionere", "--target pionere: not a target; did you mean 'pioneer'?"),
    ("check pioneer --junit -", "--junit: '-' is not a file"),
    ("check pioneer --json none/r.json", "--json none/r.json: there is no folder"),
    ("serve", "serve: TARGET|BENCH is missing; see 'hilbench serve --help'"),
    ("serve pioneer", "no endpoint; add --pty PATH, --tcp PORT or --rfc2217 PORT"),
    ("serve pioneer-plane --pty robt=p", "--pty robt=: no line 'robt'; did you mean 'robot'?"),
    ("serve pioneer-plane --tcp x=0", "--tcp x=: no line 'x'; lines: robot, robot.host"),
    ("check pioneer --target robt=pioneer", "--target robt=pioneer: no target 'robt'; did you mean 'robot'?"),
    ("serve pioneer --tcp 70000", "--tcp: '70000' does not end in a port from 0 to 65535"),
    ("serve pioneer --tcp localhost", "--tcp: 'localhost' does not end in a port"),
    ("serve pioneer --tcp 0 --scene coridor", "did you mean 'corridor'?"),
    ("serve pioneer --tcp 0 --baud fast", "--baud: 'fast' is not a whole number"),
    ("serve pioneer --pty ''", "--pty: '' names no path"),
    ("serve pionere --tcp 0", "pionere: no such bench; did you mean 'pioneer'?"),
    ("validate", "validate: BENCH is missing"),
    ("validate /dev/zero", "/dev/zero: too large for a bench file: more than 1048576 bytes"),
    ("validate none.toml", "none.toml: no such bench file"),
]


@pytest.mark.parametrize(("line", "said"), WRONG, ids=[line or "nothing" for line, _ in WRONG])
def test_a_wrong_line_is_answered_in_one(line, said, capfd, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = [word.strip("'") for word in line.split()]
    assert main(words) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith("hilbench: ")
    assert said in err
    assert err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_defect_is_one_line_and_a_file_with_the_traceback(capfd, tmp_path, monkeypatch):
    from hilbench.commands import validate

    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr(validate, "run", lambda _: 1 / 0)
    assert main(["validate", "pioneer"]) == 5
    (file,) = tmp_path.iterdir()
    assert capfd.readouterr().err == (
        f"hilbench: defect in hilbench: ZeroDivisionError: division by zero (traceback in {file})\n"
    )
    assert "in <lambda>" in file.read_text()


def test_an_interruption_is_130(capfd, monkeypatch):
    from hilbench.commands import validate

    def interrupted(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(validate, "run", interrupted)
    assert main(["validate", "pioneer"]) == 130
    assert capfd.readouterr().err == "hilbench: interrupted\n"


@pytest.mark.parametrize("command", [[], ["check"], ["serve"], ["validate"]])
def test_help_has_an_example(command, capsys):
    assert main([*command, "--help"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert "examples:\n  hilbench " in out
    assert max(map(len, out.splitlines())) <= 120


def test_version(capsys):
    from hilbench import __version__

    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"hilbench {__version__}\n"


def test_a_right_bench_file_is_said_to_be_so(capsys, tmp_path):
    file = tmp_path / "b.toml"
    file.write_text('version = 1\n[targets.robot]\nmodel = "pioneer-2dx"\n')
    assert main(["validate", str(file)]) == 0
    assert capsys.readouterr() == (f"{file}: ok\n", "")


def test_a_folder_that_is_called_like_a_protocol_is_no_bench(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    tmp_path.joinpath("pkt").mkdir()
    assert main(["check", "pkt"]) == 2
    assert "'pkt' is a protocol" in capsys.readouterr().err
