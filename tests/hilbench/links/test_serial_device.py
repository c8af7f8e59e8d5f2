"""What is done to a serial device: no such thing is here, so the kernel's answers are put in its mouth."""

from __future__ import annotations

import contextlib
import errno
import os
import struct
import termios

import pytest

from hilbench.errors import UnavailableError, UsageError
from hilbench.links import LineSettings, SerialPort, SerialTarget, parse_serial_target
from hilbench.links import serial_device as device_module
from hilbench.links.serial_device import LineErrors, ModemLines, line_errors, modem_lines, set_modem_lines
from hilbench.links.serial_target import located
from hilbench.ports.listing import PortInfo, UsbIdentity
from tests.each import each

from .conftest import HURRY

MS = 10**6
TIOCGICOUNT = 0x545D
TIOCSBRK, TIOCCBRK = 0x5427, 0x5428


class Uart:
    """Answers the ioctls of a UART's driver; everything else goes to the kernel."""

    def __init__(self, monkeypatch):
        self.bits = termios.TIOCM_DTR | termios.TIOCM_RTS | termios.TIOCM_CTS
        self.set = []
        self.counts = [0] * 20
        self.asked = 0
        self.real = device_module.fcntl.ioctl
        monkeypatch.setattr(device_module.fcntl, "ioctl", self.ioctl)

    def ioctl(self, descriptor, request, argument=0):
        if request == TIOCGICOUNT:
            return struct.pack("20i", *self.counts)
        if request == termios.TIOCMGET:
            self.asked += 1
            return struct.pack("i", self.bits)
        if request == termios.TIOCMSET:
            (self.bits,) = struct.unpack("i", argument)
            self.set.append(self.bits)
            return argument
        if request in (termios.TIOCEXCL, termios.TIOCNXCL, termios.TIOCMBIS, termios.TIOCMBIC):
            return 0
        return self.real(descriptor, request, argument)


@pytest.fixture
def pace():
    return HURRY


@pytest.fixture
def uart(monkeypatch):
    return Uart(monkeypatch)


@pytest.fixture
def pty():
    master, slave = os.openpty()
    yield os.ttyname(slave)
    os.close(master)
    os.close(slave)


@pytest.mark.parametrize(
    ("text", "settings"),
    [
        ("serial:/dev/x@115200,dtr=off", LineSettings(dtr=False)),
        ("/dev/x@9600,dtr=on,rts=off,parity=E,stop=2", LineSettings(dtr=True, rts=False, parity="E", stop_bits=2)),
        ("/dev/x@9600", LineSettings()),
    ],
)
def test_how_a_port_is_opened_stands_behind_the_rate(text, settings):
    assert parse_serial_target(text) == SerialTarget(
        url="/dev/x", baud=parse_serial_target(text).baud, settings=settings
    )


def test_what_a_target_says_goes_before_what_the_bench_says():
    assert parse_serial_target(
        "/dev/x@9600,rts=on", settings=LineSettings(dtr=False, rts=False)
    ).settings == LineSettings(dtr=False, rts=True)


@each("word", ["dtr=1", "speed=9", "parity=M", "stop=3", "dtr="])
def test_wrong_settings_are_refused_with_those_there_are(word):
    with pytest.raises(UsageError, match=r"no setting of a port; there are dtr=on\|off; rts=on\|off; parity=N\|E\|O"):
        parse_serial_target(f"/dev/x@9600,{word}")


def test_a_choice_of_port_stands_where_a_path_may_stand():
    identity = UsbIdentity(vendor_id=0x0403, product_id=0x6010, location="1-1", interface=1)
    ports = [PortInfo(device="/dev/ttyUSB7", usb=identity)]
    target = parse_serial_target("serial:usb=0403:6010,interface=1@57600,dtr=off")
    assert located(target, lambda: ports) == SerialTarget(
        url="/dev/ttyUSB7", baud=57_600, settings=LineSettings(dtr=False)
    )
    with pytest.raises(UnavailableError, match="no port matches"):
        located(target, list)
    with pytest.raises(UsageError, match="two numbers"):
        parse_serial_target("serial:usb=403@9600")


def test_both_lines_are_set_by_one_call(uart):
    set_modem_lines(0, dtr=False, rts=False)
    set_modem_lines(0, dtr=True, rts=None)
    set_modem_lines(0, dtr=None, rts=None)
    assert uart.set == [termios.TIOCM_CTS, termios.TIOCM_CTS | termios.TIOCM_DTR]
    assert modem_lines(0) == ModemLines(dtr=True, rts=False, cts=True, dsr=False, ri=False, cd=False)


def test_what_the_driver_counts(uart):
    uart.counts[6:11] = [1, 2, 3, 4, 5]
    assert line_errors(0) == LineErrors(framing=1, parity=3, overrun=7, breaks=4)


def test_a_pseudo_terminal_has_no_lines_and_counts_nothing(locked, pty):
    port = SerialPort(locked, f"{pty}@9600,dtr=off")
    assert port.modem_lines is None
    with pytest.raises(UnavailableError, match="has no such lines"):
        port.set_lines(dtr=True)
    port.close()
    assert port.modem_lines is None


def test_opening_touches_no_line_that_nobody_asked_for(locked, uart, pty):
    SerialPort(locked, pty).close()
    assert uart.set == []
    port = SerialPort(locked, f"{pty}@9600,dtr=off,rts=off")
    assert uart.set == [termios.TIOCM_CTS]
    port.set_lines(rts=True)
    assert port.modem_lines == ModemLines(dtr=False, rts=True, cts=True, dsr=False, ri=False, cd=False)
    port.close()


def test_the_lines_stay_when_a_port_is_closed(locked, pty):
    descriptor = os.open(pty, os.O_RDWR | os.O_NOCTTY)
    attributes = termios.tcgetattr(descriptor)
    attributes[2] |= termios.HUPCL
    termios.tcsetattr(descriptor, termios.TCSANOW, attributes)
    assert termios.tcgetattr(descriptor)[2] & termios.HUPCL
    os.close(descriptor)
    port = SerialPort(locked, pty)
    attributes = termios.tcgetattr(port._serial.fd)
    assert not attributes[2] & termios.HUPCL
    port.close()


def test_others_are_kept_out_of_a_device_and_let_in_when_it_is_closed(locked, uart, pty, monkeypatch):
    monkeypatch.setattr(device_module, "_PSEUDO", "/nowhere/")  # a pseudo-terminal's own server opens it, too
    asked = []
    answer = device_module.fcntl.ioctl

    def ioctl(descriptor, request, argument=0):
        asked.append(request)
        return answer(descriptor, request, argument)

    monkeypatch.setattr(device_module.fcntl, "ioctl", ioctl)
    port = SerialPort(locked, pty)
    assert (termios.TIOCEXCL in asked, termios.TIOCNXCL in asked) == (True, False)
    port.close()
    assert termios.TIOCNXCL in asked


def test_parity_and_stop_bits_reach_the_driver(locked, pty):
    port = SerialPort(locked, f"{pty}@9600,parity=O,stop=2")
    attributes = termios.tcgetattr(port._serial.fd)
    assert attributes[2] & termios.CSTOPB
    port.close()


def test_errors_and_breaks_are_counted_from_the_opening_on(locked, uart, pty):
    uart.counts[6:11] = [5, 5, 5, 5, 5]
    port = SerialPort(locked, pty)
    breaks = []
    port.on_break = breaks.append
    locked.run_for(150 * MS)
    assert (port.counters.framing_errors, breaks) == (0, [])
    uart.counts[6:11] = [6, 7, 8, 7, 5]
    locked.run_for(150 * MS)
    counted = port.counters
    assert (counted.framing_errors, counted.receive_overruns, counted.parity_errors, counted.breaks) == (1, 2, 3, 2)
    assert len(breaks) == 2
    port.close()
    locked.run_for(150 * MS)


def test_lines_that_change_are_told_to_whoever_watches(locked, uart, pty):
    port, told = SerialPort(locked, pty, watch_lines=True), []
    port.on_modem = lambda lines, at_ns: told.append((lines.cts, lines.dsr, lines.ri, lines.cd))
    locked.run_for(150 * MS)
    assert told == []
    uart.bits |= termios.TIOCM_DSR | termios.TIOCM_CAR
    locked.run_for(150 * MS)
    uart.bits &= ~termios.TIOCM_DTR  # our own
    locked.run_for(150 * MS)
    uart.bits ^= termios.TIOCM_RI | termios.TIOCM_CTS
    locked.run_for(150 * MS)
    assert told == [(True, True, False, True), (False, True, True, True)]
    port.close()


def test_nobody_asks_for_lines_that_nobody_watches(locked, uart, pty):
    """Many adapters ask the device, and the bench would wait for its answer."""
    port, asked = SerialPort(locked, pty), uart.asked
    locked.run_for(250 * MS)
    assert uart.asked == asked
    port.close()


@pytest.mark.parametrize("baud", [2**31, 2**32 - 1, 10**20])
def test_a_rate_beyond_what_a_driver_can_be_told_is_refused(locked, pty, baud):
    with pytest.raises(UnavailableError, match="cannot be opened"):
        SerialPort(locked, f"{pty}@{baud}")
    port = SerialPort(locked, f"{pty}@9600")
    with pytest.raises(UnavailableError, match=f"cannot be set to {baud} baud"):
        port.baud = baud
    assert port.baud == 9600
    port.baud = 19_200
    port.close()


def test_a_device_that_goes_while_it_is_opened_cannot_be_opened(locked, pty, monkeypatch):
    def gone(_descriptor, _queue):
        raise termios.error(5, "Input/output error")

    before = len(os.listdir("/proc/self/fd"))
    monkeypatch.setattr(termios, "tcflush", gone)
    with pytest.raises(UnavailableError, match="cannot be opened: Input/output error"):
        SerialPort(locked, pty)
    assert len(os.listdir("/proc/self/fd")) == before


def test_a_break_ends_at_the_latest_when_the_port_is_closed(locked, uart, pty, monkeypatch):
    held = []
    answer = device_module.fcntl.ioctl

    def ioctl(descriptor, request, argument=0):
        if request in (TIOCSBRK, TIOCCBRK):
            held.append(request == TIOCSBRK)
            return 0
        return answer(descriptor, request, argument)

    monkeypatch.setattr(device_module.fcntl, "ioctl", ioctl)
    monkeypatch.setattr(device_module, "_PSEUDO", "/nowhere/")
    port = SerialPort(locked, pty)
    port.send_break(20 * MS)
    locked.run_for(40 * MS)
    assert held == [True, False]
    port.send_break(10**12)
    port.close()
    assert held == [True, False, True, False]


@pytest.mark.parametrize(("number", "is_refused"), [(errno.ENOTTY, True), (errno.EOPNOTSUPP, True), (errno.EIO, False)])
def test_a_driver_without_breaks_is_told_from_a_device_that_goes(locked, uart, pty, monkeypatch, number, is_refused):
    answer = device_module.fcntl.ioctl

    def ioctl(descriptor, request, argument=0):
        if request == TIOCSBRK:
            raise OSError(number, os.strerror(number))
        return answer(descriptor, request, argument)

    monkeypatch.setattr(device_module.fcntl, "ioctl", ioctl)
    monkeypatch.setattr(device_module, "_PSEUDO", "/nowhere/")
    port = SerialPort(locked, pty)
    with pytest.raises(UnavailableError, match="cannot be sent") if is_refused else contextlib.nullcontext():
        port.send_break(MS)
    assert port.counters.breaks_unsent == is_refused
    port.close()
