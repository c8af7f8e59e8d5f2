"""One image, two robots: what it does at its pins is the same on both ways."""

from __future__ import annotations

from collections.abc import Iterable

from hilbench.check import CaseSetup
from hilbench.mcu.board_case import BoardCase
from hilbench.suites._bluepill import CONNECT, DISTANCES, MOTORS, RESET
from hilbench.suites._board_watch import Watch
from hilbench.suites.bluepill_pins._ways import SONAR_LATE_S, WORDS, look_at_post, on_wheels, required


def order_of(watch: Watch, pins: Iterable[str], since_ns: int = 0) -> list[tuple[str, bool]]:
    """Return the edges of pins without their times."""
    return [(edge.pin, edge.level is True) for edge in watch.edges_of(pins, since_ns)]


OUTPUTS = (*MOTORS, CONNECT, RESET, "PA0", "PA11", "PA12")


@on_wheels("G14", program="words", lasts_s=9.5, needs=("variant 'robot'", "part 'adapter'"))
def test_words_on_both(bench: BoardCase) -> None:
    other = bench.open_other(CaseSetup(variant="robot", program="words"), "empty")
    benches = (bench, other)
    watches = [Watch(one, OUTPUTS) for one in benches]
    for one in benches:
        one.board.run(9.5)
    here, there = (order_of(watch, OUTPUTS) for watch in watches)
    required(len(here) > len(WORDS), "the program moves nothing", here)
    required(here == there, "the edges at the connector come in another order over the adapter", [here, there])


FRONT = range(2, 7)
"""The sensors that both ways have."""


@on_wheels("G14", program="sensors", lasts_s=2.6, scene="post", needs=("variant 'robot'", "part 'adapter'"))
def test_sensors_on_both(bench: BoardCase) -> None:
    other = bench.open_other(CaseSetup(variant="robot", program="sensors"), "post")
    orders, texts = [], []
    for one, settle_s in ((bench, 0.05), (other, SONAR_LATE_S)):
        pins = (*DISTANCES[1:6], *OUTPUTS)
        watch, line = Watch(one, pins), one.board.usart("usart1")
        one.board.run(2.0)
        begun_ns = one.bench.now_ns
        for sensor in FRONT:
            look_at_post(one, sensor, settle_s)
        one.board.run(0.1)
        orders.append(order_of(watch, pins, begun_ns))
        texts.append(line.text)
    required(len(orders[0]) >= 4 * len(FRONT), "the sensors or the lamp move nothing", orders[0])
    required(orders[0] == orders[1], "the edges come in another order over the adapter", orders)
    required(texts[0] == texts[1], "the program says something else over the adapter", texts)
