"""The line a foreign program holds: the same interface in bench time, on a pty, and on a socket.

write(data); read() -> what has come; wait(seconds); now_s; set_baud(bit/s), OSError on a socket; flush(), forget what
has come; close(), what also happens when the program dies. `patience` is how many times longer the program waits for an
answer than the one it stands for: in host time an answer may be late because the host is.
"""

from __future__ import annotations

import os
import socket
import termios

from hilbench.clock import NS_PER_S, MonotonicHostClock

_SPEEDS = {
    9600: termios.B9600,
    19200: termios.B19200,
    38400: termios.B38400,
    57600: termios.B57600,
    115200: termios.B115200,
}


class BenchLine:
    """A line in bench time, of which the program holds one end; `serial` as a tty, else as a socket."""

    patience = 1

    def __init__(self, rig, *, serial):
        self.serial = serial
        self.is_open = True
        self._rig = rig
        self._port = rig.link.b
        self._received = bytearray()
        self._port.on_receive = lambda data, _at_ns: self._received.extend(data)

    @property
    def now_s(self):
        return self._rig.bench.now_s

    def write(self, data):
        assert self.is_open
        self._port.write(data)

    def read(self):
        data = bytes(self._received)
        self._received.clear()
        return data

    def wait(self, duration_s):
        self._rig.bench.run_for(duration_s)

    def set_baud(self, baud):
        if not self.serial:
            raise OSError("not a terminal")
        self._port.baud = baud

    def flush(self):
        self._received.clear()

    def close(self):
        self.is_open = False
        self._rig.client_gone()


class _HostLine:
    """What the lines to a served robot have in common: host time, and a descriptor that is read without waiting."""

    patience = 60

    def __init__(self):
        self._host = MonotonicHostClock()
        self.is_open = True

    @property
    def now_s(self):
        return self._host.monotonic_ns() / NS_PER_S

    def wait(self, duration_s):
        self._host.wait_until(self._host.monotonic_ns() + round(duration_s * NS_PER_S))

    def close(self):
        if self.is_open:
            self.is_open = False
            self._host.close()
            self._close()


class PtyLine(_HostLine):
    """A program that opens a serial port and makes it raw; its rate is whatever it was until `set_baud`."""

    serial = True

    def __init__(self, path):
        super().__init__()
        self._descriptor = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        attributes = termios.tcgetattr(self._descriptor)
        attributes[0] = attributes[1] = attributes[3] = 0
        attributes[2] = termios.CS8 | termios.CREAD | termios.CLOCAL
        termios.tcsetattr(self._descriptor, termios.TCSAFLUSH, attributes)

    def write(self, data):
        assert os.write(self._descriptor, data) == len(data)

    def read(self):
        try:
            return os.read(self._descriptor, 65536)
        except BlockingIOError:
            return b""

    def set_baud(self, baud):
        attributes = termios.tcgetattr(self._descriptor)
        attributes[4] = attributes[5] = _SPEEDS[baud]
        termios.tcsetattr(self._descriptor, termios.TCSAFLUSH, attributes)

    def flush(self):
        termios.tcflush(self._descriptor, termios.TCIFLUSH)

    def _close(self):
        os.close(self._descriptor)


class TcpLine(_HostLine):
    """A program that connects to a socket."""

    serial = False

    def __init__(self, port):
        super().__init__()
        self._socket = socket.create_connection(("127.0.0.1", port), timeout=60)
        self._socket.setblocking(False)

    def write(self, data):
        assert self._socket.send(data) == len(data)

    def read(self):
        try:
            return self._socket.recv(65536)
        except BlockingIOError:
            return b""

    def set_baud(self, baud):
        raise OSError("not a terminal")

    def flush(self):
        self.read()

    def _close(self):
        self._socket.close()
