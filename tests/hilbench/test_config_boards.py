"""Bench files with emulated boards, and board files of a user's own."""

from __future__ import annotations

import pytest

from hilbench.benchfile.bench_file import PinEnd
from hilbench.benchfile.board_files import board_schema, open_board
from hilbench.benchfile.reader import open_bench
from hilbench.cli import main
from hilbench.errors import HilbenchError, UnavailableError, UsageError
from hilbench.strict.schema import DATA_FOLDER, schema_text
from targets.boards import Straps, board_names, built_in_board
from targets.robots.pioneer import RobotSettings

BRAIN = 'version = 1\n[targets.brain]\nboard = "bluepill"\nfirmware = "a.elf"\n'
TWO = f'{BRAIN}[targets.other]\nboard = "bluepill"\nfirmware = "a.elf"\n'
MINE = 'name = "Mine"\nchip = "STM32F103RB"\nhse_hz = 12000000\n'


@pytest.fixture
def read(tmp_path):
    (tmp_path / "a.elf").write_bytes(b"")

    def open_text(text):
        file = tmp_path / "my.toml"
        file.write_text(text)
        return open_bench(str(file))

    return open_text


def test_a_board_and_its_defaults(read, tmp_path):
    bench = read(BRAIN)
    brain = bench.boards["brain"]
    assert brain.board == built_in_board("bluepill")
    assert brain.firmware == tmp_path / "a.elf"
    assert (brain.timing, brain.skip_idle, brain.straps) == ("flat", True, Straps())
    assert (bench.targets, bench.links, bench.nets, bench.lockstep_ns) == ({}, (), (), 20_000)
    assert bench.header(3)["timing"] == {"brain": "flat"}


def test_everything_about_a_board_can_be_said(read):
    bench = read(f'{BRAIN}timing = "table"\nskip_idle = false\nstraps = {{ boot0 = 1 }}\n')
    brain = bench.boards["brain"]
    assert (brain.timing, brain.skip_idle, brain.straps) == ("table", False, Straps(boot0=1, boot1=0))


def test_a_board_may_have_another_chip_than_its_own(read):
    """Blue Pills are sold with 64 and with 128 KB."""
    bench = read(f'{BRAIN}chip = "stm32f103cb"\n')
    board = bench.boards["brain"].board
    assert (board.chip, board.variant.flash_bytes, board.name) == ("STM32F103CB", 131_072, "Blue Pill")


def test_a_board_of_a_user_s_own_is_as_good_as_a_built_in_one(read, tmp_path):
    (tmp_path / "boards").mkdir()
    (tmp_path / "boards" / "mine.toml").write_text(MINE)
    bench = read(BRAIN.replace("bluepill", "./boards/mine.toml"))
    board = bench.boards["brain"].board
    assert (board.name, board.variant.flash_bytes, board.hse_hz, board.lse_hz) == ("Mine", 131_072, 12_000_000, None)


@pytest.mark.parametrize("name", board_names())
def test_the_strict_reader_takes_built_in_boards(name, tmp_path):
    assert open_board(name, tmp_path) == built_in_board(name)


def test_lines_between_boards_a_robot_and_the_door(read):
    bench = read(
        TWO
        + '[targets.robot]\nmodel = "pioneer-2dx"\n[world]\nphysics = "plane"\n'
        + '[[links]]\nends = ["brain.usart1", "other.usart3"]\n'
        + '[[links]]\nends = ["brain.usart2", "robot.host"]\n'
        + '[[links]]\nends = ["other.usart1", "peer"]\n'
        + '[[links]]\nends = ["peer", "other.usart2"]\nbaud = 14400\n'
    )
    assert [(link.ends, link.baud) for link in bench.links] == [
        (("brain.usart1", "other.usart3"), 0),
        (("brain.usart2", "robot.host"), 9600),
        (("other.usart1", "peer"), 0),
        (("peer", "other.usart2"), 14400),
    ]
    assert bench.settings_of(RobotSettings) == RobotSettings()


def test_wires_that_touch_are_one_net(read):
    bench = read(
        TWO
        + '[[wires]]\nends = ["brain.PA0", "other.B1"]\n'
        + '[[wires]]\nends = ["brain.C13", "3V3"]\n'
        + '[[wires]]\nends = ["other.PB5", "3v3"]\n'
        + '[[wires]]\nends = ["other.PB1", "brain.A4"]\n'
    )
    pins = [{str(pin) for pin in net.pins} for net in bench.nets]
    assert pins == [{"brain.PC13"}, {"other.PB5"}, {"brain.PA0", "other.PB1", "brain.PA4"}]
    assert [net.supplies for net in bench.nets] == [{"3v3"}, {"3v3"}, frozenset()]
    assert PinEnd(board="other", pin="PB1") in bench.nets[2].pins


def test_a_smaller_chip_leaves_the_ends_that_it_lacks_unconnected(read):
    assert read(BRAIN + "chip = 'STM32F103C4'\n").boards["brain"].board.usarts == ("USART1", "USART2")


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        (BRAIN + "frimware = 1\n", 5, "unknown key 'frimware' in [targets.brain]; did you mean 'firmware'?"),
        (BRAIN + "timing = 'tabel'\n", 5, "'tabel' is not a value it takes; did you mean 'table'?"),
        (BRAIN + "chip = 'STM32F103RG'\n", 5, "take the place of the STM32F103C8; did you mean 'STM32F103RE'?"),
        (BRAIN + "chip = 'STM32F103CE'\n", 5, "take the place of the STM32F103C8; did you mean 'STM32F103RE'?"),
        (BRAIN + "chip = 'STM32F103Z8'\n", 5, "take the place of the STM32F103C8; did you mean 'STM32F103V8'?"),
        (BRAIN + "chip = 'STM32F767ZI'\n", 5, "no chip 'STM32F767ZI' that could take the place of the STM32F103C8"),
        (BRAIN + "chip = 'STM32F103T8'\n", 5, "does not fit the board: leds name 'PC13', which the STM32F103T8"),
        (BRAIN + "skip_idle = 1\n", 5, "must be true or false"),
        (BRAIN + "base = 0x08000001\n", 5, "0x08000001 is no multiple of 0x80, as the place of a vector table is"),
        (BRAIN + "straps.boot0 = 2\n", 5, "2 is not a value it takes; it takes: 0, 1"),
        (BRAIN + "straps.boot2 = 1\n", 5, "did you mean 'boot"),
        (BRAIN + "settings.watchdog_ms = 100\n", 5, "'settings' says nothing about a board"),
        (
            BRAIN.replace("bluepill", "bluepil"),
            3,
            "no board 'bluepil'; did you mean 'bluepill'? (a file of yours",
        ),
        (BRAIN.replace("a.elf", "b.elf"), 4, "no firmware file '"),
        (BRAIN + "[world]\nscene = 'empty'\n", 5, "no target of this bench has a world"),
        (BRAIN + "[[links]]\nends = ['brain.usart1', 'brain.usart4']\n", 6, "did you mean 'brain.usart"),
        (BRAIN + "[[links]]\nends = ['brain.usart1', 'brain.usart1']\n", 6, "both ends are 'brain.usart1'"),
        (BRAIN + 2 * "[[links]]\nends = ['brain.usart1', 'peer']\n", 8, "'brain.usart1' has a line already"),
        (BRAIN + "[[links]]\nends = ['brain.usart1', 'brain.usart2']\nbaud = 9600\n", 7, "have a rate of their own"),
        (BRAIN + "[[links]]\nends = ['brain.usart1', 'peer']\nbaud = 9\n", 7, "must be a whole number >= 300"),
        (BRAIN + "[[wires]]\nends = ['brain.PA0']\n", 6, "length >= 2"),
        (BRAIN + "[[wires]]\nends = ['brain.PA0', 'brain.PE1']\n", 6, "'brain' has no pin 'PE1'; did you mean 'P"),
        (
            BRAIN + "[[wires]]\nends = ['brain.PA0', 'PA1']\n",
            6,
            "'PA1' is not a pin of a board, a terminal of a part, 3v3 or gnd",
        ),
        (BRAIN + "[[wires]]\nends = ['brain.PA0', '3v3', 'gnd']\n", 6, "joins 3v3 and gnd"),
        (
            BRAIN + "[[faults]]\nkind = 'drop'\nbyte = 1\n",
            5,
            'no line of this bench leads to a board; write [[links]] ends = ["peer", "brain.usart1"]',
        ),
        (
            BRAIN + "[[links]]\nends = ['brain.usart1', 'brain.usart2']\n[[faults]]\nkind = 'drop'\nbyte = 1\n",
            7,
            "link 0 joins two ends of boards",
        ),
        (
            BRAIN + "[[links]]\nends = ['brain.usart1', 'peer']\n[[faults]]\nkind = 'drop'\nbyte = 1\nlink = 1\n",
            10,
            "there is no link 1: this bench has one line, link 0",
        ),
        ("lockstep_us = 0\n" + BRAIN, 1, "must be a whole number >= 1"),
        (
            "version = 1\n[targets.r]\nmodel = 'pioneer-2dx'\nfirmware = 'a'\n",
            4,
            "'firmware' says nothing about a model",
        ),
    ],
)
def test_what_is_wrong_is_one_line_with_its_place(read, tmp_path, text, line, message):
    with pytest.raises(HilbenchError) as raised:
        read(text)
    said = str(raised.value)
    assert said.startswith(f"{tmp_path / 'my.toml'}:{line}: ")
    assert message in said
    assert "\n" not in said


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        (MINE + "hse = 8\n", 4, "unknown key 'hse'; did you mean 'hse_hz'?"),
        (MINE.replace("103RB", "103RG"), 2, "'STM32F103RG' is not a value it takes; did you mean 'STM32F103RE'?"),
        (MINE.replace("12000000", "12"), 3, "hse_hz must be between 1000000 and 25000000, not 12"),
        (MINE + "[[leds]]\nname = 'a'\npin = 'PE0'\n", 4, "leds name 'PE0', which the STM32F103RB does not have"),
        (MINE + "[[leds]]\nname = 'a'\npin = 'PA0'\nactive = 'lo'\n", 7, "did you mean 'low'?"),
        ('chip = "STM32F103RB"\n', None, "the key 'name' is missing"),
    ],
)
def test_what_is_wrong_in_a_board_file(tmp_path, text, line, message):
    (tmp_path / "mine.toml").write_text(text)
    with pytest.raises(UsageError) as raised:
        open_board("mine.toml", tmp_path)
    place = f"{tmp_path / 'mine.toml'}:{line}: " if line else f"{tmp_path / 'mine.toml'}: "
    assert str(raised.value).startswith(place)
    assert message in str(raised.value)


def test_a_missing_image_is_not_wrong_but_missing(read):
    with pytest.raises(UnavailableError):
        read(BRAIN.replace("a.elf", "b.elf"))


def test_the_published_schema_of_boards_is_that_of_the_model():
    published = (DATA_FOLDER / "board.schema.json").read_text(encoding="utf-8")
    assert published == schema_text(board_schema()), (
        "write schema_text(board_schema()) to hilbench/data/board.schema.json"
    )
    for definition in board_schema()["$defs"].values():
        for key, entry in definition["properties"].items():
            assert entry.get("description") or "$ref" in entry, f"{definition['title']}.{key}"


def test_a_bench_of_boards_alone_has_no_robot_to_serve_or_check(read, tmp_path, capsys):
    read(BRAIN)
    assert main(["check", str(tmp_path / "my.toml")]) == 2
    assert "my.toml: names no suite for its boards; write suites = " in capsys.readouterr().err
