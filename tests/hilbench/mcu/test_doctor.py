"""`hilbench doctor --fidelity`: the ledger of a chip."""

from __future__ import annotations

import json

import pytest

from hilbench import __version__
from hilbench.cli import main


def test_every_register_is_listed_with_how_far_it_is_modelled(capsys):
    assert main(["doctor", "--fidelity"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(line.startswith("USART1  0x40013800  ") for line in lines)
    assert any(line.split()[1:3] == ["BRR", "modelled"] for line in lines)
    assert any(" absent " in f"{line} " for line in lines)
    assert lines[-1].startswith("STM32F103C8: ")
    assert max(map(len, lines)) < 240


def test_as_json_it_adds_up(capsys):
    assert main(["doctor", "--fidelity", "stm32f103rb", "--json"]) == 0
    ledger = json.loads(capsys.readouterr().out)
    names = {part["name"] for part in ledger["peripherals"]}
    assert {"RCC", "GPIOA", "USART3", "TIM4", "DMA1", "ADC1", "NVIC", "SCB", "STK"} <= names
    for part in ledger["peripherals"]:
        assert sum(part["counts"].values()) == len(part["registers"])
        for register in part["registers"]:
            assert register["fidelity"] in {"modelled", "partly", "absent"}
            assert register["note"] or register["fidelity"] != "partly", (part["name"], register["name"])


def test_without_a_question_it_says_what_is_installed(capsys):
    assert main(["doctor"]) == 0
    out, err = capsys.readouterr()
    said = {line.split(maxsplit=1)[0]: line.split(maxsplit=1)[1] for line in out.splitlines()}
    assert said["hilbench"] == __version__
    assert said["boards"] == "bluepill, nucleo-f767zi, nucleo-h753zi"
    assert {"STM32F103C8", "STM32F767ZI"} <= set(said["chips"].split(", "))
    assert err == "what is modelled of a chip: hilbench doctor --fidelity CHIP\n"
    assert main(["doctor", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert (data["parts"]["unicorn"], data["benches"][0]) == (said["unicorn"], "bluepill")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["doctor", "--fidelity", "STM32F103ZE"], "--fidelity: no chip 'STM32F103ZE'; did you mean 'STM32F103"),
    ],
)
def test_what_it_cannot_say(capsys, words, said):
    assert main(words) == 2
    assert said in capsys.readouterr().err
