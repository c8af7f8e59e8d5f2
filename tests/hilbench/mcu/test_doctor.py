"""`hilbench doctor --fidelity`: the ledger of a chip."""

from __future__ import annotations

import json

import pytest

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


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["doctor", "--fidelity", "STM32F103ZG"], "--fidelity: no chip 'STM32F103ZG'; did you mean 'STM32F103ZE'?"),
        (["doctor", "--fidelity", "STM32F103RCT6"], "did you mean 'STM32F103RC'?"),
    ],
)
def test_what_it_cannot_say(capsys, words, said):
    assert main(words) == 2
    assert said in capsys.readouterr().err
