"""CONFIG: none, and a short one."""

from __future__ import annotations

import dataclasses
from functools import partial
from typing import Any

from hilbench.check import Violation, case
from hilbench.clock import NS_PER_S
from hilbench.suites._client import (
    CONFIG_WITHIN_S,
    CONNECT_WITHIN_S,
    UNDERSTAND_S,
    WORKING_PERIOD_S,
    ClientBench,
    begin,
    connect,
    own_client,
    require_session,
)
from hilbench.systems.pioneer.scripted_packets import CONFIG
from protocols.p2os import ClientState, CommandNumber, ConfigPacket, encode_packet


@case("C17", bench_time_s=7.2)
def test_it_does_without_config(bench: ClientBench) -> None:
    server = bench.server
    server.answer("CONFIG")
    begin(bench)
    opened = server.expect_session(CONNECT_WITHIN_S)
    own = bench.client.own
    if own is not None:
        server.wait(lambda: own.state is ClientState.OPEN, CONFIG_WITHIN_S)
        assert own.state is ClientState.OPEN, f"the client is stuck without CONFIG: {own.state.value}"
        own.drive(200)
    require_session(bench, max(0.0, (opened.at_ns - bench.bench.now_ns) / NS_PER_S + CONFIG_WITHIN_S), "no CONFIG came")
    asked = [heard.at_ns for heard in server.heard("CONFIG")]
    server.run(WORKING_PERIOD_S)
    again = len(server.heard("CONFIG")) - len(asked)
    assert not again, f"after {CONFIG_WITHIN_S:g} s the client still asks for CONFIG"


@case("C18", bench_time_s=2.2)
def test_a_short_config_is_used(bench: ClientBench) -> None:
    server = bench.server
    server.answer("CONFIG", encode_packet(dataclasses.replace(CONFIG, fields=_FIELDS_TO_WATCHDOG)))
    connect(bench)
    asked = len(server.heard("CONFIG"))
    require_session(bench, WORKING_PERIOD_S, "CONFIG was short")
    assert len(server.heard("CONFIG")) == asked, "the client asks again for a CONFIG it has"
    config = own_client(bench).config
    assert config is not None, "the short CONFIG was not used"
    used = (config.serial, config.trans_vel_top_mm_s, config.name, config.low_battery_dv, config.watchdog_ms)
    sent = (CONFIG.serial, CONFIG.trans_vel_top_mm_s, CONFIG.name, CONFIG.low_battery_dv, CONFIG.watchdog_ms)
    assert used == sent, f"the short CONFIG was misread: {used} for {sent}"
    assert (config.stall_pwm, config.trans_ki) == (0, 0), "figures were read that the short CONFIG does not have"


def _filled(step: int) -> ConfigPacket:
    """Return a CONFIG of the P2OS form with another number or text in each field."""
    numbers: dict[str, Any] = {}
    for place, field in enumerate(dataclasses.fields(ConfigPacket)):
        if size := field.metadata.get("size"):
            numbers[field.name] = 10 + 3 * place + step if size == 1 else 1000 + 259 * place + 3 * step
    named = dataclasses.replace(CONFIG, serial=f"SERIAL{step}", name=f"name {step}")
    whole = dataclasses.replace(named, **numbers)
    return ConfigPacket.decode(dataclasses.replace(whole, fields=ConfigPacket.P2OS_FIELDS).encode())


@case("C31", bench_time_s=1.6)
def test_each_figure_of_config_is_read(bench: ClientBench) -> None:
    """Once as it connects, and with other figures when it asks again."""
    server = bench.server
    for step in range(3):
        sent = _filled(step)
        server.answer("CONFIG", encode_packet(sent))
        if step:
            own_client(bench).send(CommandNumber.CONFIG, 1)
        else:
            connect(bench)
        server.run(UNDERSTAND_S)
        server.wait(partial(_has_read, bench, sent), CONFIG_WITHIN_S)
        got = own_client(bench).config
        assert got is not None, "the CONFIG was not used"
        wrong = [
            f"{field.name}: sent {getattr(sent, field.name)}, understood {getattr(got, field.name)}"
            for field in dataclasses.fields(ConfigPacket)
            if getattr(sent, field.name) != getattr(got, field.name)
        ]
        if wrong:
            raise Violation(f"{len(wrong)} fields of the CONFIG were misread", wrong)


def _has_read(bench: ClientBench, config: ConfigPacket) -> bool:
    return own_client(bench).config == config


_FIELDS_TO_WATCHDOG = 19
"""How many fields a CONFIG packet has up to and including the watchdog (AriaCoda ArRobotConfigPacketReader.cpp)."""
