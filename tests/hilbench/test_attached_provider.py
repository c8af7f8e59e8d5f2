"""A real target is left as a person would want to find it."""

from __future__ import annotations

import os
import threading
import tty
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from hilbench.bench_provider import make_provider
from hilbench.check.provider import CaseInfo
from hilbench.options import CheckOptions, TargetChoice

STOPPED_SIP = bytes.fromhex("FA FB 1B 32 00 00 00 00 00 00 00 00 00 00 80 00 00 00 00 00 00 00 00 05 00 00 FF 00 38 7F")
STOP = bytes.fromhex("FA FB 03 1D 00 1D")
ENABLE_0 = bytes.fromhex("FA FB 06 04 3B 00 00 04 3B")
CLOSE_1 = bytes.fromhex("FA FB 06 02 3B 01 00 03 3B")


@contextmanager
def robot_in_session() -> Iterator[tuple[str, bytearray]]:
    """A line on which SIPs come until CLOSE; yields its name and what was written to it."""
    master, slave = os.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    written, over = bytearray(), threading.Event()

    def run() -> None:
        while not over.wait(0.02):
            with suppress(BlockingIOError):
                written.extend(os.read(master, 4096))
            if CLOSE_1 not in written:
                os.write(master, STOPPED_SIP)

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield os.ttyname(slave), written
    finally:
        over.set()
        thread.join()
        os.close(master)
        os.close(slave)


def test_the_session_is_closed_before_the_first_case_and_after_the_last() -> None:
    with robot_in_session() as (name, written):
        provider = make_provider(CheckOptions(targets=(TargetChoice(spec=f"serial:{name}"),)))
        try:
            with provider.open_case(CaseInfo(id="x", clause_ids=("S01",), seed=0)) as bench:
                assert bytes(written) == STOP + ENABLE_0 + CLOSE_1
                written.clear()  # the robot talks again, as after a case that failed in the middle of a session
                bench.finish("fail", "")
        finally:
            provider.close()
        assert bytes(written) == STOP + ENABLE_0 + CLOSE_1
