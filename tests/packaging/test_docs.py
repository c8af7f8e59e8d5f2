"""The documentation tells the truth: generated pages are up to date, examples run, links lead somewhere."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from hilbench.cli import main
from tests.each import each

ROOT = Path(__file__).parent.parent.parent
PAGES = [
    *ROOT.glob("*.md"),
    *(page for folder in ("docs", "udev", "examples") for page in ROOT.glob(f"{folder}/**/*.md")),
]
LINK = re.compile(r"\]\((?!https?:|mailto:|#)([^)#\s]+)")
FILE = re.compile(r"(?<![\w/.-])(?:docs|examples|hilbench|measure|protocols|targets|tests|udev|worlds)/[\w./*-]*\w")
PYTHON_BLOCK = re.compile(r"```python\n(.*?)```", re.DOTALL)


def test_generated_pages_are_up_to_date() -> None:
    done = subprocess.run([sys.executable, "docs/generate.py", "--check"], cwd=ROOT, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_links_lead_somewhere() -> None:
    for page in PAGES:
        missing = [link for link in LINK.findall(page.read_text()) if not (page.parent / link).exists()]
        if page.name != "gate-proof.md":  # as it was at the commit that it names
            missing += [file for file in FILE.findall(page.read_text()) if not any(ROOT.glob(file))]
        assert missing == [], page


def test_the_suite_in_the_docs_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    text, _ = PYTHON_BLOCK.findall((ROOT / "docs/checks.md").read_text())
    suite = tmp_path / "our_panel.py"
    suite.write_text(text)
    monkeypatch.chdir(tmp_path)
    assert main(["check", "pioneer-plane", "--suite", str(suite)]) == 0
    assert "2 clauses: 2 pass" in capfd.readouterr().out


def test_the_suite_for_a_board_in_the_docs_runs(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    _, text = PYTHON_BLOCK.findall((ROOT / "docs/checks.md").read_text())
    (tmp_path / "our_board.py").write_text(text)
    image = ROOT / "targets/firmware/images/echo-irq.elf"
    file = tmp_path / "hilbench.toml"
    file.write_text(
        f'version = 1\nsuites = ["our_board.py"]\n[targets.brain]\nboard = "bluepill"\nfirmware = "{image}"\n'
    )
    assert main(["check", str(file)]) == 0
    assert "OUR02   must   pass" in capfd.readouterr().out


PACKAGES = {path.parent for path in (ROOT / "examples").rglob("pyproject.toml")}  # their benches need what they bring
CAMPAIGNS = sorted((ROOT / "examples" / "campaigns").glob("*.toml"))
FILES = sorted(path for path in (ROOT / "examples").rglob("*.toml") if PACKAGES.isdisjoint(path.parents))
BENCHES = [path for path in FILES if path not in CAMPAIGNS]


def test_example_campaigns_are_right(capsys):
    for path in CAMPAIGNS:
        assert main(["campaign", str(path), "--list"]) == 0, path
        assert capsys.readouterr().out.startswith("hilbench check "), path


@each("bench", BENCHES)
def test_example_benches_are_right(bench: Path) -> None:
    assert main(["validate", str(bench)]) == 0


def test_the_protocol_example_in_the_docs_shakes_hands() -> None:
    """The snippet is a loop for ever; here its names are filled in so that it ends after the first answer."""
    (text,) = PYTHON_BLOCK.findall((ROOT / "docs/p2os/index.md").read_text())
    written: list[bytes] = []

    class ExampleOver(Exception):  # noqa: N818 - not an error
        pass

    class Port:
        def write(self, data: bytes) -> None:
            written.append(data)

        def read(self) -> bytes:
            if len(written) > 1:
                raise ExampleOver
            return bytes.fromhex("FA FB 03 00 00 00")

    with pytest.raises(ExampleOver):
        exec(text, {"port": Port(), "now_ns": lambda: 0})  # the documentation's own code
    assert written == [bytes.fromhex("FA FB 03 00 00 00"), bytes.fromhex("FA FB 03 01 00 01")]
