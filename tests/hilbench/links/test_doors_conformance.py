"""Every kind of link keeps the same promises. Bench time is real here; nothing is asserted about the host's."""

from __future__ import annotations

import pytest

from hilbench.clock import Scheduler
from hilbench.links import Line, MemoryLink, PtyDoor, SerialPort, TcpDoor
from hilbench.testing import LinkUnderTest, check_link
from tests.each import each

LARGE = 3000


@each("baud", [0, 9600, 115_200, 921_600])
def test_memory(baud):
    def make_link():
        scheduler = Scheduler()
        link = MemoryLink(scheduler, Line(baud=baud))
        return LinkUnderTest(scheduler=scheduler, a=link.a, b=link.b, baud=baud)

    check_link(make_link, large_bytes=20_000, patience_s=60)


@pytest.mark.parametrize("baud", [0, 250_000, 921_600])
def test_pty_and_serial_port(locked, tmp_path, baud):
    def make_link():
        path = tmp_path / "port"
        door = PtyDoor(locked, path, Line(baud=baud))
        port = SerialPort(locked, f"serial:{path}@{baud or 115_200}")
        return LinkUnderTest(scheduler=locked, a=door, b=port, baud=baud)

    check_link(make_link, large_bytes=LARGE, patience_s=60)
    assert not (tmp_path / "port").is_symlink()


@pytest.mark.parametrize("baud", [0, 460_800])
def test_tcp_and_serial_port(locked, baud):
    def make_link():
        door = TcpDoor(locked, "0", Line(baud=baud))
        port = SerialPort(locked, f"socket://127.0.0.1:{door.port}")
        return LinkUnderTest(scheduler=locked, a=door, b=port, baud=baud)

    check_link(make_link, large_bytes=LARGE, patience_s=60)
