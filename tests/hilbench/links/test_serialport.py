from __future__ import annotations

import dataclasses
import errno
import fcntl
import os
import termios
import threading

import pytest
import serial

from hilbench.errors import UnavailableError, UsageError
from hilbench.files.host import this_host
from hilbench.links import Line, PtyDoor, SerialPort, SerialTarget, parse_serial_target
from hilbench.links.serial_device import _cannot_open
from hilbench.udev.installing import port_group
from tests.each import each

from .conftest import until

S = 10**9


@each(
    ("text", "url", "baud"),
    [
        ("serial:/dev/ttyUSB0@115200", "/dev/ttyUSB0", 115_200),
        ("/dev/ttyUSB0", "/dev/ttyUSB0", 9600),
        ("socket://host:8101", "socket://host:8101", 9600),
        ("rfc2217://host:4000@57600", "rfc2217://host:4000", 57_600),
        ("serial:/dev/serial/by-id/a@b", "/dev/serial/by-id/a@b", 9600),
    ],
)
def test_targets(text, url, baud):
    assert parse_serial_target(text) == SerialTarget(url=url, baud=baud)


@each("text", ["", "serial:", "@9600", "/dev/ttyUSB0@0"])
def test_not_targets(text):
    with pytest.raises(UsageError):
        parse_serial_target(text)


def test_a_port_without_a_descriptor_is_read_by_a_thread(locked):
    before = threading.active_count()
    port = SerialPort(locked, "loop://@115200")
    got = bytearray()
    port.on_receive = lambda data, at_ns: got.extend(data)
    data = os.urandom(3000)
    port.write(data)
    until(locked, lambda: len(got) == len(data))
    assert got == data
    port.close()
    port.close()
    assert threading.active_count() == before


def test_a_disappearing_port_takes_the_line_down(locked):
    master, slave = os.openpty()
    port = SerialPort(locked, os.ttyname(slave))
    lines = []
    port.on_line = lambda up, at_ns: lines.append(up)
    os.close(slave)
    os.close(master)
    until(locked, lambda: not port.line_is_up)
    assert lines == [False]
    port.write(b"lost")
    assert port.counters.lost == 4
    port.close()


def test_a_line_that_takes_nothing_never_blocks_the_bench(locked):
    master, slave = os.openpty()
    port = SerialPort(locked, os.ttyname(slave), write_timeout_s=0.02)
    port.write(bytes(100_000))
    until(locked, lambda: port.counters.lost > 0)
    assert 50_000 < port.counters.lost < 100_000
    port.close()
    os.close(slave)
    os.close(master)


def test_a_port_belongs_to_one_program(locked, tmp_path):
    door = PtyDoor(locked, tmp_path / "port", Line(baud=9600))
    port = SerialPort(locked, str(tmp_path / "port"))
    with pytest.raises(UnavailableError, match="another program uses the port") as caught:
        SerialPort(locked, str(tmp_path / "port"))
    assert "\n" not in str(caught.value)
    port.baud = 19_200
    assert door.client_baud == port.baud == 19_200
    port.close()
    door.close()


def test_errors_are_one_line_and_say_what_to_do(locked):
    with pytest.raises(UnavailableError, match=r"no such port.*'hilbench ports' shows what"):
        SerialPort(locked, "/dev/ttyNONE")
    with pytest.raises(UsageError, match="pyserial does not know"):
        SerialPort(locked, "nonsense://x")
    with pytest.raises(UnavailableError) as caught:
        SerialPort(locked, "socket://127.0.0.1:1")
    assert "\n" not in str(caught.value)


def test_permission_denied_names_the_group(tmp_path, monkeypatch):
    host = dataclasses.replace(this_host(), groups=frozenset(), groups_of_account=frozenset())  # of who is in none
    monkeypatch.setattr("hilbench.files.host.this_host", lambda: host)
    path = tmp_path / "port"
    path.touch()
    target = SerialTarget(url=str(path), baud=9600)
    error = serial.SerialException(errno.EACCES, "could not open port")
    group = host.group_name(path.stat().st_gid)
    wanted = port_group(host) if group == "root" else group  # nobody is told to join the group of root
    assert f"usermod -aG {wanted} " in str(_cannot_open(target, error))
    missing = SerialTarget(url="/dev/ttyNONE", baud=9600)
    assert "start it with --device /dev/ttyNONE" in str(_cannot_open(missing, error))


def test_a_port_in_use_names_who_has_it():
    master, slave = os.openpty()
    target = SerialTarget(url=os.ttyname(slave), baud=9600)
    error = serial.SerialException(errno.EBUSY, "could not open port")
    fcntl.flock(slave, fcntl.LOCK_EX)  # as a client does; who has the master, too, only serves the pseudo-terminal
    said = str(_cannot_open(target, error))
    assert "another program uses the port; stop " in said
    assert f"({os.getpid()})" in said
    os.close(slave)
    assert "root sees whose" in str(_cannot_open(target, error))
    os.close(master)


@pytest.mark.parametrize(
    ("url", "said"),
    [
        ("socket://127.0.0.1", "names no port of its host"),
        ("rfc2217://127.0.0.1:99999", "no number from 1 to 65535"),
        ("socket://127.0.0.1:http", "no number from 1 to 65535"),
        ("hilbench://rover-model?fast@115200", "its clock would differ"),
        ("hilbench://nobody", "no such bench"),
        ("socket://[::1:400", "is no URL: Invalid IPv6 URL"),
        ("loop://?logging=foo", "pyserial does not know it: KeyError: 'foo'"),
        ("hwgrep://[", "pyserial does not know it: (Pattern)?[eE]rror: unterminated character set"),
    ],
)
def test_a_url_that_makes_no_sense_is_wrong_usage(locked, url, said):
    with pytest.raises(UsageError, match=said):
        SerialPort(locked, url)


def test_a_file_beside_the_port_that_is_not_there_is_named(locked, tmp_path):
    with pytest.raises(UnavailableError, match=r"/log: No such file or directory$"):
        SerialPort(locked, f"spy:///dev/null?file={tmp_path}/nowhere/log")


def test_a_file_is_no_serial_port(locked, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(UnavailableError, match="is no serial port"):
        SerialPort(locked, str(tmp_path / "file"))


def test_what_a_far_port_refuses_is_no_wrong_usage():
    target = SerialTarget(url="rfc2217://h:1", baud=9600)
    error = _cannot_open(target, ValueError("remote rejected value for option 'parity'"))
    assert isinstance(error, UnavailableError)
    assert "the remote port refuses" in str(error)


def test_a_port_is_one_programs_own_also_behind_another_url(locked):
    master, slave = os.openpty()
    port = SerialPort(locked, os.ttyname(slave))
    with pytest.raises(UnavailableError, match="another program uses the port"):
        SerialPort(locked, f"spy://{os.ttyname(slave)}")
    port.close()
    os.close(master)
    os.close(slave)


def test_a_break_throws_nothing_away(locked):
    """Whoever had the port before may have left it so that one does."""
    master, slave = os.openpty()
    attributes = termios.tcgetattr(slave)
    attributes[0] |= termios.BRKINT
    termios.tcsetattr(slave, termios.TCSANOW, attributes)
    port = SerialPort(locked, os.ttyname(slave))
    assert not termios.tcgetattr(slave)[0] & termios.BRKINT
    port.close()
    os.close(master)
    os.close(slave)
