"""`hilbench init`, the test it writes, and what tests of firmware can do with a board."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from hilbench.benchfile.reader import open_bench
from hilbench.cli import main
from hilbench.errors import UsageError
from hilbench.mcu.under_test import boards_under_test
from tests.hilbench.forked import ALREADY_IMPORTED, PYTEST

ROOT = Path(__file__).parents[3]
IMAGES = ROOT / "targets/firmware/images"


@pytest.fixture
def board(emulate):
    def build(program, more=""):
        (board,) = boards_under_test(emulate(program, more=more)).values()
        return board

    return build


def greeting(machine):
    machine.echo("USART1")
    machine.at_ns(3_000_000, lambda: machine.send_all("USART1", b"ready\n"))
    machine.output("PC13", level=True)
    machine.at_ns(8_000_000, lambda: machine.chip.pins["PC13"].set_latch(False))
    machine.at_ns(9_000_000, lambda: machine.on_console(b"traced\n", "itm"))


def test_a_test_talks_to_a_board(board):
    brain = board(greeting)
    line = brain.usart("usart1")
    assert line.expect("ready") == b"ready"
    began_s = brain.now_s
    line.write("ping")
    assert line.expect(b"ping") == b"\nping"
    assert brain.now_s - began_s == pytest.approx(50 * 625 / 72e6, abs=20e-9)  # four bytes there, and one back
    with pytest.raises(AssertionError, match=r"usart1 did not send b'pong' within 0.01 s, but b''"):
        line.expect("pong", within_s=0.01)
    assert line.text == "ready\nping"
    brain.run(0.2)
    said = [line.split(maxsplit=2) for line in brain.transcript if "usart1" in line]
    assert [what for _, _, what in said] == ["> ready", "< ping", "> ping"]
    assert float(said[1][0]) == pytest.approx(began_s, abs=2e-6)


def test_a_test_sees_pins_lights_console_and_notes(board):
    brain = board(greeting)
    brain.run(0.005)
    assert not brain.is_lit()
    brain.run(0.005)
    assert brain.is_lit("PC13")
    assert brain.pin("C13").level is False
    brain.pin("PA0").drive(True)
    assert brain.pin("A0").level is True
    assert brain.console == "traced\n"
    assert brain.transcript[0].split(maxsplit=2)[1:] == ["brain.PC13", "high (LED PC13 off)"]
    assert (brain.end, brain.notes) == (None, [])


def test_a_test_records_a_pin_that_the_bench_watches_too(board):
    brain = board(greeting)
    pin = brain.pin("PC13")
    pin.record()
    brain.run(0.01)
    assert [(edge.ns, edge.level) for edge in pin.take_edges()] == [(0, True), (8_000_000, False)]
    assert [line.split(maxsplit=2)[1] for line in brain.transcript].count("brain.PC13") == 2


def test_a_run_is_over_when_the_firmware_is(board):
    brain = board(lambda machine: machine.at_ns(2_000_000, lambda: machine.end("lockup", 1)))
    brain.run(1.0)
    assert brain.end.kind == "lockup"
    assert not brain.end.good
    assert brain.now_s == 0.002


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda brain: brain.usart("usart9"), "brain has no free line 'usart9'; did you mean 'usart"),
        (lambda brain: brain.pin("PX1"), "brain has no pin 'PX1'"),
        (lambda brain: brain.is_lit("LED9"), "brain has no light 'LED9'"),
    ],
)
def test_what_a_board_does_not_have(board, ask, said):
    with pytest.raises(UsageError, match=said):
        ask(board(greeting))


# --- init


@pytest.fixture
def pytest_in(forkable):
    def run(folder, *words, forkable=forkable):
        return forkable.run("-p", "no:cacheprovider", *words, program=PYTEST, cwd=folder)

    return run


def test_what_init_writes_passes(pytest_in, tmp_path, capsys):
    image = IMAGES / "style-registers.elf"
    folder = tmp_path / "project" / "tests"
    folder.mkdir(parents=True)
    assert main(["init", "--board", "bluepill", "--image", str(image), "--dir", str(folder)]) == 0
    assert (
        capsys.readouterr().out
        == f"wrote {folder}/hilbench.toml\nwrote {folder}/test_firmware.py\nwrote {folder}/conftest.py\n"
    )
    bench = open_bench(str(folder / "hilbench.toml"))
    assert bench.boards["board"].firmware.resolve() == image
    (folder / "test_mine.py").write_text("def test_x(board): assert not board.end\n")
    # from the folder above, and with a pytest that turns warnings into errors
    done = pytest_in(tmp_path / "project", "-q", "-s", "-W", "error", *ALREADY_IMPORTED)
    assert done.returncode == 0, done.output + done.error
    assert "2 passed" in done.output
    assert "board.PC13" in done.output
    done = pytest_in(folder, "-q", "test_mine.py", "--hilbench-bench", "hilbench.toml")
    assert "1 passed" in done.output, done.output + done.error


OTHER_WAY = pytest.mark.exhaustive("the gate has either folder, and either way to load the plugin")


@pytest.mark.parametrize(
    ("folder", "words"),  # pytest reads the conftest.py of tests early
    [
        ("tests", []),
        ("firmware", ["-p", "hilbench.pytest_plugin"]),
        pytest.param("tests", ["-p", "hilbench.pytest_plugin"], marks=OTHER_WAY),
        pytest.param("firmware", [], marks=OTHER_WAY),
    ],
)
def test_what_init_writes_is_found_by_a_pytest_that_has_it_loaded_already(
    pytest_in, forkable_pytest, tmp_path, folder, words
):
    for name in (folder, "twice"):
        (tmp_path / name).mkdir()
        image = str(IMAGES / "style-registers.elf")
        assert main(["init", "--board", "bluepill", "--image", image, "--dir", str(tmp_path / name)]) == 0
    words = ["-q", "--import-mode=importlib", "-W", "error", *words]
    done = pytest_in(tmp_path, *words, forkable=forkable_pytest)
    assert "2 passed" in done.output, done.output + done.error


def test_the_tests_in_readme_and_docs_pass(pytest_in, tmp_path):
    pages = [(ROOT / page).read_text() for page in ("README.md", "docs/firmware.md")]
    blocks = [block for page in pages for block in re.findall(r"```python\n(.*?)```", page, re.DOTALL)]
    assert blocks
    assert (
        main(["init", "--board", "bluepill", "--image", str(IMAGES / "style-irq-dma.elf"), "--dir", str(tmp_path)]) == 0
    )
    for number, block in enumerate(blocks):
        (tmp_path / f"test_block_{number}.py").write_text(block)
    done = pytest_in(tmp_path, "-q", "-W", "error", *ALREADY_IMPORTED)
    (passed,) = re.findall(r"^\d+ passed", pages[1], re.MULTILINE)
    assert passed in done.output, done.output + done.error


def test_a_conftest_of_the_user_stays_and_init_says_what_it_needs(tmp_path, capsys):
    (tmp_path / "conftest.py").write_text("# mine\n")
    image = str(IMAGES / "style-registers.elf")
    assert main(["init", "--board", "bluepill", "--image", image, "--dir", str(tmp_path)]) == 0
    out, err = capsys.readouterr()
    assert "conftest.py" not in out
    assert err.startswith(
        f"note: {tmp_path}/conftest.py is there already and stays as it is; it needs this line: "
        'pytest_plugins = ["hilbench.pytest_plugin"]\n'
    )
    assert (tmp_path / "conftest.py").read_text() == "# mine\n"


def test_the_written_test_fails_when_the_firmware_crashes(pytest_in, tmp_path):
    image = IMAGES / "bad-lockup.elf"
    assert main(["init", "--board", "bluepill", "--image", str(image), "--dir", str(tmp_path)]) == 0
    done = pytest_in(tmp_path, "-q")
    assert done.returncode == 1
    assert "board: lockup in HardFault_Handler" in done.output


def test_a_board_file_is_seen_from_where_the_bench_file_is(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text('name = "Mine"\nchip = "STM32F103RB"\n')
    (tmp_path / "sub").mkdir()
    image = str(IMAGES / "style-registers.elf")
    assert main(["init", "--board", "./mine.toml", "--image", image, "--dir", "sub"]) == 0
    assert open_bench("sub/hilbench.toml").boards["board"].board.name == "Mine"
    assert '"../mine.toml"' in (tmp_path / "sub" / "hilbench.toml").read_text()


@pytest.mark.parametrize("there", ["hilbench.toml", "test_firmware.py"])
def test_init_overwrites_nothing(tmp_path, capsys, there):
    (tmp_path / there).write_text("mine")
    words = ["init", "--board", "bluepill", "--image", str(IMAGES / "style-registers.elf"), "--dir", str(tmp_path)]
    assert main(words) == 2
    assert f"{tmp_path}/{there}: is there already" in capsys.readouterr().err
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [(there, "mine")]


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["--board", "bluepil", "--image", "x.elf"], 2, "--board: no board 'bluepil'; did you mean 'bluepill'?"),
        (["--board", "bluepill", "--image", "x.elf"], 3, "x.elf: no such firmware file"),
        (["--board", "bluepill", "--image", "empty.elf"], 2, "empty.elf: the file is empty"),
        (["--board", "bluepill"], 2, "--image is missing"),
        (["--board", "bluepill", "--image", "{image}", "--dir", "none"], 2, "there is no folder"),
    ],
)
def test_what_init_refuses(tmp_path, monkeypatch, capsys, words, code, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty.elf").write_bytes(b"")
    image = str(IMAGES / "style-registers.elf")
    assert main(["init", *(word.replace("{image}", image) for word in words)]) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err
    assert err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["empty.elf"]


def test_the_example_of_two_boards_passes(pytest_in):
    done = pytest_in(Path(__file__).parents[3] / "examples/two-boards", "-q", "-W", "error", *ALREADY_IMPORTED)
    assert done.returncode == 0, done.output + done.error
    assert "2 passed" in done.output


def test_a_board_fixture_without_a_board_says_so(pytest_in, tmp_path):
    (tmp_path / "test_it.py").write_text('pytest_plugins = ["hilbench.pytest_plugin"]\ndef test_it(board): pass\n')
    done = pytest_in(tmp_path, "-q")
    assert "no hilbench.toml beside it or above it; write one: hilbench init --help" in done.output
    done = pytest_in(tmp_path, "-q", "-p", "hilbench.pytest_plugin", "--hilbench-bench", "pioneer-plane")
    assert "pioneer-plane: has no emulated board" in done.output
