"""``python -m measure.proxy_soak``: a hundred million bytes between a ground station and an emulated rover, by a proxy.

The station talks without a pause, and the rover answers at the full rate of its USART, 115200 baud. Between the two are
what ``hilbench proxy`` is made of, and the kernel's pseudo-terminals: a client at a door, a relay, a client at a door,
all in virtual time: what is said passes at once, a millisecond's worth of bytes at a time. (What a proxy does that has
much to carry both ways at once, `measure/soak` looks at, in real time and without a rover.) Each byte
that one of the two says is held against what the other gets, and what the rover has accepted against what was said.

The bytes are those of both directions. They come in parts of five million, each with a bench, a proxy and a seed of its
own, one process for each of the host's processors; all of them take some three hours of two processors, so parts may be
asked for one after the other (``--seed``, ``--bytes``). The firmware is `rover-dma`, which is woken by pieces of what
comes: with an interrupt for each byte (``--image rover``) it takes twice as long.
"""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import os
import random
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial

from hilbench.bench import Bench
from hilbench.benchfile.bench_file import BenchFile
from hilbench.benchfile.reader import open_bench
from hilbench.clock import NS_PER_MS, NS_PER_S, EventClass, Scheduler, Stopwatch
from hilbench.errors import HilbenchError
from hilbench.journal import Journal
from hilbench.links import Port
from hilbench.links.front import PortInFront
from hilbench.serving.near_ends import open_near_end
from hilbench.systems.rover.ground_station import GroundStation
from hilbench.through import Routes
from targets.firmware import image_path

IMAGE = "rover-dma"
_TALK_NS = 5 * NS_PER_MS
_AHEAD_BYTES = 115  # 10 ms of the line
_TELL_S = 60.0
_REQUESTS = 0.6
"""So much of what the station says are requests for 0x80."""
_REPORT_S = 0.6
"""The rover says 0x80 by itself at 3 Hz."""
_PAUSES = 1000


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What came of a conversation.

    Attributes:
        to_rover: bytes that the rover's line was given, each compared with what the station said.
        from_rover: bytes that the station got, each compared with what the rover's line gave.
        passed: bytes that the proxy has had.
        different: how many of those compared were others.
        missing: bytes that were said and never came.
        strange: bytes that came and were never said.
        said: packets that the station said and the rover counts; it does not count requests.
        accepted: packets that the rover says it has accepted.
        rejected: packets that it says it has rejected.
        reports: how many the station has had.
        bench_s: how long it took in bench time.
        host_s: how long it took.
        failure: what ended it; empty if nothing did.
    """

    to_rover: int
    from_rover: int
    passed: int
    different: int
    missing: int
    strange: int
    said: int
    accepted: int
    rejected: int
    reports: int
    bench_s: float
    host_s: float
    failure: str = ""

    @property
    def sound(self) -> bool:
        """Whether all that was said has come, by the proxy, as it was, and the rover has understood it."""
        wrong = self.different + self.missing + self.strange + self.rejected
        through = self.passed == self.to_rover + self.from_rover
        return not (self.failure or wrong) and through and self.accepted == self.said and self.reports > 0


class Comparison:
    """Whether what came is what was said, without keeping more of it than is on the way."""

    def __init__(self) -> None:
        self._said, self._came = bytearray(), bytearray()
        self.compared = 0
        self.different = 0

    def said(self, data: bytes) -> None:
        """Take what has been said."""
        self._said += data
        self._compare()

    def came(self, data: bytes) -> None:
        """Take what has come."""
        self._came += data
        self._compare()

    @property
    def missing(self) -> int:
        """Bytes that were said and have not come."""
        return len(self._said)

    @property
    def strange(self) -> int:
        """Bytes that have come and were not said."""
        return len(self._came)

    def _compare(self) -> None:
        count = min(len(self._said), len(self._came))
        said, came = self._said[:count], self._came[:count]
        if said != came:
            self.different += sum(one != other for one, other in zip(said, came, strict=True))
        del self._said[:count], self._came[:count]
        self.compared += count


class _Front(PortInFront):
    """A port before another that also tells when bytes are out."""

    def __init__(self, port: Port) -> None:
        super().__init__(port)
        self.counters = port.counters
        port.on_sent = self._handed_over

    def _handed_over(self, data: bytes, at_ns: int) -> None:
        self.on_sent(data, at_ns)


class Ear(_Front):
    """Hears what is written to a port and what comes from it."""

    def __init__(self, port: Port, writes: Callable[[bytes], None], hears: Callable[[bytes], None]) -> None:
        super().__init__(port)
        self._writes, self._hears = writes, hears

    def write(self, data: bytes) -> None:
        """Hand bytes to the port behind."""
        self._writes(data)
        super().write(data)

    def _received(self, data: bytes, at_ns: int) -> None:
        self._hears(data)
        super()._received(data, at_ns)


class Gatherer(_Front):
    """Hands on what comes once in a millisecond, as a USB adapter does: each piece costs some system calls."""

    def __init__(self, scheduler: Scheduler, port: Port) -> None:
        super().__init__(port)
        self._scheduler = scheduler
        self._kept = bytearray()

    def _received(self, data: bytes, _at_ns: int) -> None:
        if not self._kept:
            self._scheduler.after(NS_PER_MS, self._hand_on, order=EventClass.CONTROL, source="gatherer")
        self._kept += data

    def _hand_on(self) -> None:
        data = bytes(self._kept)
        self._kept.clear()
        self.on_receive(data, self._scheduler.now_ns)


class Talk:
    """Has a station say something all the time: it asks, switches the test LED and drives, by chance.

    Args:
        bench: whose time is used.
        station: who talks.
        port: its line, which never runs dry.
        chance: decides what is said.

    Attributes:
        goes_on: whether there is more to say.
        counted: packets said that the rover counts.
    """

    def __init__(self, bench: Bench, station: GroundStation, port: Port, chance: random.Random) -> None:
        self._scheduler, self._station, self._port, self._chance = bench.scheduler, station, port, chance
        self.goes_on = True
        self.counted = 0
        self._talk()

    def _talk(self) -> None:
        while self._port.pending < _AHEAD_BYTES:
            self._say()
        if self.goes_on:
            self._scheduler.after(_TALK_NS, self._talk, order=EventClass.CONTROL, source="talk")

    def _say(self) -> None:
        station, chance = self._station, self._chance
        choice = chance.random()
        self.counted += choice >= _REQUESTS
        if choice < _REQUESTS:
            station.request()
        elif choice < 0.8:
            station.switch_led(lit=choice < 0.7)
        elif choice < 0.9:
            station.drive_motors(chance.uniform(-1, 1), chance.uniform(-1, 1))
        else:
            station.drive(chance.uniform(-0.5, 0.5), chance.uniform(-2, 2))


def converse(image: str, total: int, seed: int, tell: Callable[[str], None] = lambda _text: None) -> Outcome:
    """Let a station and a rover talk through a proxy until so many bytes have passed, both ways together.

    Args:
        image: the rover's firmware, by its name in `targets.firmware`.
        total: how many bytes.
        seed: decides what the station says.
        tell: told each minute how far it is.
    """
    to_rover, from_rover = Comparison(), Comparison()
    bench, watch, failure = Bench(Scheduler(), Journal()), Stopwatch(), ""
    with contextlib.ExitStack() as stack:
        near = open_near_end(bench, _with_firmware(open_bench("rover"), image), real_time=False)
        stack.callback(near.close)
        ways = stack.enter_context(contextlib.closing(Routes("proxy")))
        at_rover = Ear(near.port, to_rover.came, from_rover.said)
        at_station = Ear(ways(Gatherer(bench.scheduler, at_rover)), to_rover.said, from_rover.came)
        station = GroundStation(bench, at_station)
        station.connect()
        talk = Talk(bench, station, at_station, random.Random(seed))
        try:
            for passed in _minutes(bench, watch, lambda: to_rover.compared + from_rover.compared, total):
                tell(f"seed {seed}: {passed} bytes, {bench.now_ns / NS_PER_S:.0f} s of bench time")
            talk.goes_on = False
            station.disconnect()  # which stops the motors: one packet more
            _let_arrive(bench, [to_rover, from_rover])
        except HilbenchError as error:  # the proxy's own ways do not go on when a byte is another, or missing
            failure = str(error)
        passed = ways.passed
    return Outcome(
        to_rover=to_rover.compared,
        from_rover=from_rover.compared,
        passed=passed,
        different=to_rover.different + from_rover.different,
        missing=to_rover.missing + from_rover.missing,
        strange=to_rover.strange + from_rover.strange,
        said=talk.counted + 1,
        accepted=station.totals.accepted if station.totals else 0,
        rejected=station.totals.rejected if station.totals else 0,
        reports=station.counts.total(),
        bench_s=bench.now_ns / NS_PER_S,
        host_s=watch.elapsed_s(),
        failure=failure,
    )


def _minutes(bench: Bench, watch: Stopwatch, passed: Callable[[], int], total: int) -> Iterator[int]:
    """Let time pass until so many bytes have passed, or nothing does; say each minute how many have."""
    told_s, before = 0.0, -1
    while before < passed() < total:
        before = passed()
        bench.run_for(0.1)
        if watch.elapsed_s() - told_s > _TELL_S:
            told_s = watch.elapsed_s()
            yield passed()


def _let_arrive(bench: Bench, comparisons: Sequence[Comparison]) -> None:
    """Wait for the rover's next 0x80, and then for a pause in which nothing is on the way: it goes on to report."""
    bench.run_for(_REPORT_S)
    for _ in range(_PAUSES):
        bench.run_for(0.007)
        if not any(comparison.missing for comparison in comparisons):
            return


def _with_firmware(bench_file: BenchFile, image: str) -> BenchFile:
    ((name, board),) = bench_file.boards.items()
    return dataclasses.replace(bench_file, boards={name: dataclasses.replace(board, firmware=image_path(image))})


def _say(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def main(words: Sequence[str]) -> int:
    """Have all parts done and tell of each; 1, and no more parts, if one of them is not sound."""
    parser = argparse.ArgumentParser(prog="python -m measure.proxy_soak", description=__doc__)
    parser.add_argument("--bytes", type=_positive, default=100_000_000, help="both ways together (default: 100000000)")
    parser.add_argument("--part", type=_positive, default=5_000_000, help="bytes of a part at most (default: 5000000)")
    parser.add_argument("--image", default=IMAGE, help=f"the rover's firmware (default: {IMAGE})")
    parser.add_argument("--seed", type=int, default=1, help="of the first part; the next have the next (default: 1)")
    parser.add_argument(
        "--processes", type=_positive, default=os.cpu_count() or 1, help="how many (default: as processors)"
    )
    chosen = parser.parse_args(words)
    parts = -(-chosen.bytes // chosen.part)
    seeds = range(chosen.seed, chosen.seed + parts)
    work = partial(converse, chosen.image, -(-chosen.bytes // parts), tell=_say)
    outcomes: list[Outcome] = []
    with ProcessPoolExecutor(chosen.processes) as pool:
        futures = [pool.submit(work, seed) for seed in seeds]
        for seed, future in zip(seeds, futures, strict=True):
            outcomes.append(future.result())
            _say(f"seed {seed}: {told(outcomes[-1:])}")
            if not outcomes[-1].sound:
                pool.shutdown(wait=False, cancel_futures=True)
                break
    _say(f"a station, a proxy and the emulated rover ({chosen.image}): {told(outcomes)}")
    return 0 if all(one.sound for one in outcomes) else 1


def _positive(word: str) -> int:
    number = int(word)
    if number < 1:
        raise argparse.ArgumentTypeError("at least 1")
    return number


def told(outcomes: Sequence[Outcome]) -> str:
    """Say what came of conversations, of all together."""
    sums = Counter[str]()
    for one in outcomes:
        sums.update({name: value for name, value in dataclasses.asdict(one).items() if name != "failure"})
    failures = "".join(f"; {one.failure}" for one in outcomes if one.failure)
    return (
        "{to_rover} bytes to it, {from_rover} from it, {passed} by the proxy; {different} of {both} different, "
        "{missing} missing, {strange} strange; {bench_s:.0f} s of bench time in {host_s:.0f} s; the rover accepted "
        "{accepted} of {said} packets and rejected {rejected}; {reports} reports came{failures}"
    ).format(both=sums["to_rover"] + sums["from_rover"], failures=failures, **sums)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
