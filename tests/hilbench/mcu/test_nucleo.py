"""The NUCLEO-F767ZI and NUCLEO-H753ZI as a user has them: in a bench file, in a test, on the command line."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path

import pytest

from hilbench.benchfile.reader import open_bench
from hilbench.cli import main
from hilbench.errors import UsageError
from hilbench.mcu.emulated import EmulatedBench
from hilbench.mcu.under_test import boards_under_test

IMAGES = Path(__file__).parents[3] / "targets/firmware/images"


@pytest.fixture
def nucleo(tmp_path):
    file = tmp_path / "bench.toml"
    file.write_text(f'version = 1\n[targets.brain]\nboard = "nucleo-f767zi"\nfirmware = "{IMAGES / "f767-demo.elf"}"\n')
    with contextlib.closing(EmulatedBench(open_bench(str(file)))) as emulated:
        yield boards_under_test(emulated)["brain"]


def test_a_test_pushes_its_button_and_sees_its_lights(nucleo):
    nucleo.run(0.020)
    assert nucleo.usart("usart3").text.startswith("Nucleo-F767ZI at 216 MHz")
    assert not nucleo.is_lit("LD2")
    nucleo.push("B1")
    assert nucleo.run_until(lambda: nucleo.is_lit("LD2"), within_s=0.02)
    nucleo.let_go()
    assert nucleo.run_until(lambda: not nucleo.is_lit("LD2"), within_s=0.02)
    assert nucleo.run_until(lambda: nucleo.is_lit("LD1"), within_s=0.3)
    assert nucleo.now_s == pytest.approx(0.2503, abs=0.0101), "a step of the bench more at most"
    with pytest.raises(UsageError, match="brain has no button 'B2'; known: B1"):
        nucleo.push("B2")


def test_its_pins_have_three_names(nucleo):
    assert nucleo.pin("D15") is nucleo.pin("PB8")
    assert nucleo.pin("D40") is nucleo.pin("PE10")
    with pytest.raises(UsageError, match="brain has no pin 'PK0'"):
        nucleo.pin("PK0")


@pytest.mark.parametrize(
    ("what", "image", "said"),
    [
        ("nucleo-f767zi", "cut", "truncated: the file has 3000 bytes"),
        ("bluepill", "f767-demo.elf", "it would fit an STM32F767VG (1024 KB of flash, 512 KB of RAM)"),
        ("nucleo-h753zi", "f767-demo.elf", "the initial stack pointer 0x20080000 is outside the RAM of STM32H753ZI"),
    ],
)
def test_images_that_do_not_fit(capsys, tmp_path, what, image, said):
    cut = tmp_path / "cut"
    cut.write_bytes((IMAGES / "f767-demo.elf").read_bytes()[:3000])
    assert main(["run", f"{what}:{cut if image == 'cut' else IMAGES / image}", "--for", "1ms"]) == 2
    assert said in capsys.readouterr().err


def test_it_has_no_boot1(capsys, tmp_path):
    file = tmp_path / "bench.toml"
    image = IMAGES / "f767-demo.elf"
    head = f'version = 1\n[targets.brain]\nboard = "nucleo-f767zi"\nfirmware = "{image}"\n'
    file.write_text(head + "straps = { boot1 = 1 }\n")
    assert main(["run", str(file), "--for", "1ms"]) == 2
    assert "the STM32F767ZI has no BOOT1" in capsys.readouterr().err
    file.write_text(head + "straps = { boot0 = 1 }\n")
    assert main(["run", str(file), "--for", "1ms"]) == 1
    assert "BOOT_ADD1 chooses system memory (0x00100000), whose boot loader is not modelled" in capsys.readouterr().err


def test_its_ledger_is_of_both_names(capsys):
    for name, rcc in (
        *(("nucleo-f767zi", 0x4002_3800), ("stm32f767zi", 0x4002_3800)),
        *(("nucleo-h753zi", 0x5802_4400), ("stm32h753zi", 0x5802_4400)),
    ):
        assert main(["doctor", "--fidelity", name, "--json"]) == 0
        parts = {part["name"]: part for part in json.loads(capsys.readouterr().out)["peripherals"]}
        assert parts["RCC"]["base"] == rcc
        assert parts["SAI1"]["counts"]["absent"] == len(parts["SAI1"]["registers"])


def test_the_other_nucleo_runs_from_the_command_line(capsys):
    assert main(["run", f"nucleo-h753zi:{IMAGES / 'h753-demo.elf'}", "--for", "10ms"]) == 0
    assert "nucleo-h753zi.usart3: 101 bytes sent" in capsys.readouterr().err
