"""The command `hilbench proxy` between two pseudo-terminals, full both ways at once: nothing lost, nothing changed.

Run by `make soak`. PROXY_SOAK_BYTES sets another amount each way; PROXY_SOAK_SEED another seed. Both directions are
under way at once, in pieces of all sizes. Nobody leaves more unread than a pseudo-terminal keeps: a line has no way to
tell who sends to wait, so a door loses, and counts, what its client leaves unread beyond that (docs/doors.md).
"""

from __future__ import annotations

import os
import random
import select
import signal
import subprocess
import sys
import time
import tty

import pytest

from measure.soak.streams import Stream

BYTES = int(os.environ.get("PROXY_SOAK_BYTES", "100_000_000"))
SEED = int(os.environ.get("PROXY_SOAK_SEED", "1"))
LARGEST = 4096
MOST_UNREAD = 8192  # Linux keeps 13 kB at least
PATIENCE_MS = 60_000


class Talk(Stream):
    """What one end says, in pieces of all sizes."""

    def __init__(self, seed):
        super().__init__(seed)
        self._chance = random.Random(seed)

    def next(self):
        room = min(BYTES - self.sent, MOST_UNREAD - (self.sent - self.received))
        return self.coming(min(self._chance.randint(1, LARGEST), room))

    @property
    def may_say(self):
        return self.sent < BYTES and self.sent - self.received < MOST_UNREAD

    @property
    def over(self):
        return self.received >= BYTES


def pump(to_board, to_client, client, board):
    """Send and read at both ends until each has had what the other has sent, or nothing comes any more."""
    ends = {client: (to_board, to_client), board: (to_client, to_board)}
    poller = select.poll()
    while not (to_board.over and to_client.over):
        for end, (saying, _) in ends.items():
            poller.register(end, select.POLLIN | (select.POLLOUT if saying.may_say else 0))
        ready = poller.poll(PATIENCE_MS)
        if not ready:
            return
        for end, events in ready:
            saying, hearing = ends[end]
            if events & select.POLLIN:
                hearing.take(os.read(end, LARGEST))
            if events & select.POLLOUT:
                saying.sent += os.write(end, saying.next())


@pytest.fixture
def board():
    """The descriptor of a board's end of a line, and the name of the other end."""
    master, slave = os.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    yield master, os.ttyname(slave)
    os.close(slave)
    os.close(master)


@pytest.fixture
def proxy(tmp_path, board):
    """The command, and the descriptor of its client."""
    words = [sys.executable, "-m", "hilbench", "proxy", f"pty:{tmp_path}/client", f"serial:{board[1]}@921600"]
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as process:
        while "Ctrl-C" not in process.stderr.readline():
            assert process.poll() is None, "it did not come up"
        client = os.open(tmp_path / "client", os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        tty.setraw(client)
        yield process, client
        os.close(client)
        process.kill()


def test_the_command_with_both_directions_full(say, board, proxy):
    process, client = proxy
    to_board, to_client = Talk(SEED), Talk(SEED + 1)
    began_s = time.monotonic()
    pump(to_board, to_client, client, board[0])
    took_s = time.monotonic() - began_s
    process.send_signal(signal.SIGINT)
    said = process.stderr.read()
    assert process.wait() == 0
    say(
        f"hilbench proxy: {to_board.received} and {to_client.received} of {BYTES} bytes each way, "
        f"{to_board.different + to_client.different} different, {2 * BYTES / took_s / 1e6:.1f} MB/s\n{said.strip()}"
    )
    for stream in (to_board, to_client):
        assert (stream.sent, stream.received, stream.different) == (BYTES, BYTES, 0)
