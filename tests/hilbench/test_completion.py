"""What a shell completes after its script of `hilbench completion` was read."""

from __future__ import annotations

import shutil
import subprocess

import pytest

from hilbench.cli import main
from tests.each import each

BASH = """\
source {script}
COMP_WORDS=({words})
COMP_CWORD=$(( ${{#COMP_WORDS[@]}} - 1 ))
function=$(complete -p hilbench | sed 's/.* -F \\([^ ]*\\) .*/\\1/')
"$function" hilbench "${{COMP_WORDS[COMP_CWORD]}}" "${{COMP_WORDS[COMP_CWORD-1]}}"
printf '%s\\n' "${{COMPREPLY[@]}}"
"""
FISH = "source {script}; complete -C '{words}' | cut -f 1"
COMPLETED = [
    ("hilbench che", {"check"}),
    ("hilbench check pio", {"pioneer", "pioneer-plane"}),
    ("hilbench check pioneer --suite pkt", {"pkt-board", "pkt-host"}),
    ("hilbench check --ci g", {"github", "gitlab"}),
    ("hilbench decode p", {"p2os", "pkt"}),
    ("hilbench pioneer --se", {"--seed"}),
    ("hilbench serve --scene corr", {"corridor"}),
    ("hilbench run --chip STM32F767Z", {"STM32F767ZG", "STM32F767ZI"}),
    ("hilbench completion b", {"bash"}),
]
"""Each with what it is completed to."""


@pytest.fixture(scope="module")
def script_of(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scripts")

    def written(shell):
        file = folder / f"hilbench.{shell}"
        with pytest.MonkeyPatch.context() as patch, file.open("w") as out:
            patch.setattr("sys.stdout", out)
            assert main(["completion", shell]) == 0
        return file

    return written


@pytest.fixture(scope="module")
def bash(script_of, tmp_path_factory):
    script, here = script_of("bash"), tmp_path_factory.mktemp("here")
    (here / "run.jsonl").touch()

    def complete(words):
        done = subprocess.run(["bash", "-c", BASH.format(script=script, words=words)], cwd=here, capture_output=True)
        assert done.stderr == b""
        return set(done.stdout.decode().split())

    return complete


@each(("words", "completed"), COMPLETED)
def test_bash_completes(bash, words, completed):
    assert bash(words) == completed


def test_bash_completes_files_where_one_is_meant(bash):
    for words in ("hilbench replay r", "hilbench check --junit r", "hilbench check r"):
        assert "run.jsonl" in bash(words), words
    assert bash("hilbench decode r") == set()


@pytest.mark.skipif(shutil.which("fish") is None, reason="fish is not installed")
def test_fish_completes(script_of):
    script = script_of("fish")
    for words, completed in COMPLETED:
        done = subprocess.run(["fish", "-c", FISH.format(script=script, words=words)], capture_output=True, text=True)
        assert (set(done.stdout.split()), done.stderr) == (completed, ""), words


@pytest.mark.skipif(shutil.which("zsh") is None, reason="zsh is not installed")
def test_zsh_reads_its_script(script_of):
    done = subprocess.run(["zsh", "-n", script_of("zsh")], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


@each("shell", ["zsh", "fish"])
def test_the_other_shells_have_the_same_names(script_of, shell):
    text = script_of(shell).read_text()
    for _, completed in COMPLETED:
        assert all(word.removeprefix("--") in text for word in completed), completed
