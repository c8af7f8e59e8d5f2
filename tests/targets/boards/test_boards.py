"""Boards as data: the built-in ones, and what is refused."""

from __future__ import annotations

import pytest

from targets.boards import Board, Straps, board_names, built_in_board
from targets.mcu.chip_limits import limits_for, limits_of
from targets.mcu.errors import BoardError
from targets.mcu.variants import VARIANTS
from tests.each import each


def test_the_blue_pill_is_what_its_schematic_says():
    board = built_in_board("bluepill")
    assert (board.chip, board.hse_hz, board.lse_hz) == ("STM32F103C8", 8_000_000, 32_768)
    assert (board.hse_startup_us, board.lse_startup_us) == (500, 2_500_000)
    assert (board.variant.flash_bytes, board.variant.ram_bytes) == (65_536, 20_480)
    assert [(led.pin, led.active) for led in board.leds] == [("PC13", "low")]
    assert board.straps == Straps(boot0=0, boot1=0)
    assert board.usarts == ("USART1", "USART2", "USART3")
    assert board.port_pin("A9") == board.port_pin("PA9") == "PA9"
    assert board.port_pin("3.3") is None
    assert board.pulled() == {"PB2": False, "PA12": True}
    assert board.pulled(Straps(boot1=1))["PB2"] is True


def test_the_nucleo_with_the_f103_is_what_its_manual_says():
    """UM1724: the clock of the ST-LINK, USART2 to it, LD2 at D13, B1 to ground; PA2 and PA3 reach no header."""
    board = built_in_board("nucleo-f103rb")
    assert (board.chip, board.hse_hz, board.hse_bypass, board.lse_hz) == ("STM32F103RB", 8_000_000, True, 32_768)
    assert (board.variant.flash_bytes, board.variant.ram_bytes, len(board.variant.pins)) == (128 << 10, 20 << 10, 51)
    assert [(led.name, led.pin, led.active) for led in board.leds] == [("LD2", "PA5", "high")]
    assert board.usarts == ("USART2", "USART1", "USART3")
    assert board.pulled() == {"PC13": True, "PB2": False}
    contacts = {connector.name: len(connector.pins) for connector in board.connectors}
    assert contacts == {"ST-LINK": 6, "CN5": 10, "CN6": 8, "CN8": 6, "CN9": 8, "CN7": 38, "CN10": 38}
    morpho = {contact for connector in board.connectors[-2:] for contact in connector.pins}
    assert board.variant.pins - morpho == {"PA2", "PA3"}
    arduino = {contact for connector in board.connectors[1:5] for contact in connector.pins}
    assert set(board.pins) - arduino == {"D0", "D1"}


def test_the_nucleo_is_what_its_manual_says():
    board = built_in_board("nucleo-f767zi")
    assert (board.chip, board.hse_hz, board.hse_bypass, board.lse_hz) == ("STM32F767ZI", 8_000_000, True, 32_768)
    assert (board.variant.flash_bytes, board.variant.ram_bytes, board.variant.itcm_bytes) == (2 << 20, 512 << 10, 16384)
    assert [(led.name, led.pin, led.active) for led in board.leds] == [
        ("LD1", "PB0", "high"),
        ("LD2", "PB7", "high"),
        ("LD3", "PB14", "high"),
    ]
    assert board.usarts[0] == board.console == "USART3"
    assert sorted(board.usarts) == sorted(board.variant.usarts)
    assert board.port_pin("D15") == "PB8"
    assert board.port_pin("D40") == "PE10"
    assert board.pulled() == {"PC13": False}, "the button connects to 3.3 V; no BOOT1 here"


def test_the_other_nucleo_has_its_own_lights_and_names():
    board = built_in_board("nucleo-h753zi")
    assert (board.chip, board.hse_hz, board.hse_bypass, board.lse_hz) == ("STM32H753ZI", 8_000_000, True, 32_768)
    variant = board.variant
    assert (variant.flash_bytes, variant.ram_bytes, variant.itcm_bytes) == (2 << 20, 128 << 10, 64 << 10)
    assert sum(size for _, size in variant.more_ram) == (512 + 288 + 64) << 10
    assert [(led.name, led.pin) for led in board.leds] == [("LD1", "PB0"), ("LD2", "PE1"), ("LD3", "PB14")]
    assert board.console == "USART3"
    assert [board.port_pin(name) for name in ("D0", "D8", "D38", "A5")] == ["PB7", "PF3", "PE6", "PF10"]
    assert board.pulled() == {"PC13": False}, "the button connects to 3.3 V"


def test_the_connectors_of_the_nucleo_have_as_many_contacts_as_they_have():
    board = built_in_board("nucleo-f767zi")
    contacts = {connector.name: len(connector.pins) for connector in board.connectors}
    assert contacts == {"ST-LINK": 6, "CN7": 20, "CN8": 16, "CN9": 30, "CN10": 34, "CN11": 70, "CN12": 70}
    names = {board.port_pin(name) for name in board.pins}
    morpho = {contact for connector in board.connectors[-2:] for contact in connector.pins}
    assert names <= morpho, "what the Zio connectors have, the morpho connectors have too"


@each("name", board_names())
def test_every_name_on_a_connector_is_a_pin_or_a_supply(name):
    board = built_in_board(name)
    supplies = {"5V", "G", "GND", "3.3", "3V3", "R", "VB"}
    supplies |= {"NC", "AREF", "IOREF", "RESET", "AVDD", "AGND", "VIN", "VDD", "BOOT0", "VBAT", "E5V", "U5V"}
    for connector in board.connectors:
        for contact in connector.pins:
            assert contact in supplies or board.port_pin(contact), contact


@each(
    ("name", "pins"),
    [
        *(("STM32F103T8", 26), ("STM32F103CB", 37), ("STM32F103R8", 51), ("STM32F103VB", 80)),
        *(("STM32F103T4", 26), ("STM32F103C6", 37), ("STM32F103RC", 51), ("STM32F103VD", 80), ("STM32F103ZE", 112)),
        *(("STM32F767VG", 82), ("STM32F767ZI", 114), ("STM32F767IG", 140), ("STM32F767BI", 168), ("STM32F767NI", 168)),
        *(("STM32H743VI", 82), ("STM32H753ZI", 114), ("STM32H743II", 140), ("STM32H753XI", 168)),
    ],
)
def test_packages_have_as_many_pins_as_the_datasheet_says(name, pins):
    assert len(VARIANTS[name].pins) == pins
    kb = {"4": 16, "6": 32, "8": 64, "B": 128, "C": 256, "D": 384, "E": 512, "G": 1024, "I": 2048}
    assert VARIANTS[name].flash_bytes == kb[name[-1]] * 1024


def test_every_f103_from_x4_to_xe_is_there():
    """DS6087, DS5319, DS5792: sizes of flash and RAM, and the packages that each comes in."""
    sizes = {"4": (16, 6), "6": (32, 10), "8": (64, 20), "B": (128, 20), "C": (256, 48), "D": (384, 64), "E": (512, 64)}
    packages = {"4": "TCR", "6": "TCR", "8": "TCRV", "B": "TCRV", "C": "RVZ", "D": "RVZ", "E": "RVZ"}
    found = {name: (one.flash_bytes >> 10, one.ram_bytes >> 10) for name, one in VARIANTS.items() if "F103" in name}
    assert found == {f"STM32F103{one}{size}": sizes[size] for size in sizes for one in packages[size]}


@each("variant", VARIANTS.values())
def test_images_and_boards_know_the_same_chips(variant):
    assert limits_for(variant.name) == limits_of(variant)
    assert limits_of(variant).itcm_size == variant.itcm_bytes
    assert limits_of(variant).more_ram == variant.more_ram
    assert limits_of(variant).flash_bases[1:] == (() if variant.flash_alias is None else (variant.flash_alias,))


MINIMAL = {"name": "mine", "chip": "STM32F103C8"}


def test_a_board_may_have_no_crystal():
    board = Board.from_mapping(MINIMAL)
    assert (board.hse_hz, board.lse_hz, board.leds) == (None, None, ())
    assert board.usarts == ("USART1", "USART2", "USART3")


@each(
    ("more", "said"),
    [
        ({"chip": "STM32F103ZG"}, "no chip 'STM32F103ZG'"),
        ({"console": "USART4"}, "console names 'USART4'"),
        ({"buttons": [{"name": "B", "pin": "PE9"}]}, "buttons name 'PE9'"),
        ({"chip": "STM32F767ZI", "straps": {"boot1": 1}}, "straps set boot1, which the STM32F767ZI does not have"),
        ({"hse_hz": 32_768}, "hse_hz must be between 1000000 and 25000000, not 32768"),
        ({"chip": "STM32F767ZI", "hse_hz": 50_000_001}, "hse_hz must be between 1000000 and 50000000, not 50000001"),
        ({"lse_hz": 0}, "lse_hz must be between"),
        ({"hse_startup_us": 0}, "hse_startup_us must be between 1 and 60000000, not 0"),
        ({"lse_startup_us": 60_000_001}, "lse_startup_us must be between"),
        ({"adc_noise_lsb": -1}, "adc_noise_lsb must be between 0 and 1000, not -1"),
        ({"leds": [{"name": "L", "pin": "PE1"}]}, "leds name 'PE1', which the STM32F103C8 does not have"),
        ({"pins": {"D7": "PD7"}}, "pins name 'PD7'"),
        ({"pull_ups": ["PX"]}, "pull_ups name 'PX'"),
        ({"connectors": [{"name": "c", "pins": [], "usarts": ["USART4"]}]}, "connectors name 'USART4'"),
        ({"crystal": 8}, "unexpected keyword argument 'crystal'"),
    ],
)
def test_what_makes_no_board(more, said):
    with pytest.raises(BoardError, match=said):
        Board.from_mapping(MINIMAL | more)


@each(
    ("chip", "nearest"),
    [
        ("STM32F103RG", "chips: STM32F103RE, STM32F103RD, STM32F103RC"),
        ("STM32F103C8T6", "chips: STM32F103C8, "),
        ("stm32f103ze", "chips: STM32F103ZE, "),
    ],
)
def test_of_a_chip_that_is_not_there_the_nearest_are_named(chip, nearest):
    with pytest.raises(BoardError) as caught:
        Board.from_mapping(MINIMAL | {"chip": chip})
    assert caught.value.hint.startswith(nearest)
    assert set(caught.value.hint.removeprefix("chips: ").split(", ")) <= set(VARIANTS)


def test_what_is_missing_is_named():
    with pytest.raises(BoardError, match="the key 'chip' is missing"):
        Board.from_mapping({"name": "mine"})
    with pytest.raises(BoardError, match="no board 'blackpill'"):
        built_in_board("blackpill")
