"""`hilbench init --protocol`: the board that is plugged in is found again by its identity, and no other is meant."""

from __future__ import annotations

import shlex
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.doctor.first_test import init_port
from hilbench.errors import HilbenchError, UnavailableError, UsageError
from hilbench.links.serial_target import parse_serial_target
from hilbench.plugins.protocol import API, FirstTest, ProtocolPlugin
from hilbench.ports.choice import choose_port, parse_port_choice
from hilbench.ports.listing import PortInfo, UsbIdentity
from hilbench.terminal.arguments import target_choice


def port(number, *, serial="A1", ids=(0x0403, 0x6001), location="1-1", interface=0):
    usb = UsbIdentity(
        vendor_id=ids[0], product_id=ids[1], serial_number=serial, location=location, interface=interface, product="FT"
    )
    return PortInfo(device=f"/dev/ttyUSB{number}", usb=usb, links=(f"/dev/hilbench/robot{number}",))


FIRST = FirstTest(bench="bench.toml", text="def test_it():\n    pass\n")
SLOW = ProtocolPlugin(api=API, name="slow", title="Slow", summary="", decoder=None, baud=9600, first_test=FIRST)
FAST = replace(SLOW, name="fast", baud=115200)
SOLDERED = PortInfo(device="/dev/ttyS0")


def target_in(folder):
    words = shlex.split((folder / "pytest.ini").read_text().partition("addopts = ")[2])
    return target_choice(words[words.index("--hil-target") + 1]).spec


_ports = st.lists(
    st.builds(
        lambda serial, ids, location, interface: (serial, ids, location, interface),
        st.sampled_from([None, "A1", "0001", "B,location=1-1", "x@9", " "]),
        st.sampled_from([(0x0403, 0x6001), (0x10C4, 0xEA60)]),
        st.sampled_from(["1-1", "1-2.4"]),
        st.integers(0, 1),
    ),
    min_size=1,
    max_size=6,
    unique=True,
)


@given(found=_ports, data=st.data())
def test_what_is_written_means_this_port_alone(tmp_path_factory, found, data):
    there = [port(n, serial=s, ids=i, location=w, interface=f) for n, (s, i, w, f) in enumerate(found)]
    wanted = data.draw(st.sampled_from(there))
    folder = tmp_path_factory.mktemp("init")
    init_port(SLOW, wanted.device, None, folder, ports=lambda: there)
    target = parse_serial_target(target_in(folder))
    assert target.baud == 9600
    choice = parse_port_choice(target.url)
    if choice is None:
        assert target.url == wanted.device
    else:
        assert choose_port(choice, there) == wanted


def test_the_only_one_is_taken_under_any_of_its_names(tmp_path):
    for number, name in enumerate(("", "/dev/ttyUSB0", "/dev/hilbench/robot0", "serial=A1", "usb=0403:6001")):
        folder = tmp_path / str(number)
        folder.mkdir()
        written = init_port(FAST, name, None, folder, ports=lambda: [SOLDERED, port(0)])
        assert target_in(folder) == "serial:usb=0403:6001,serial=A1@115200"
        assert [file.name for file in written.files] == ["test_board.py", "pytest.ini"]
        assert written.notes == ("the board is FT, at /dev/ttyUSB0 now",)


@pytest.mark.parametrize(
    ("name", "baud", "target"),
    [
        ("serial:usb=0403:6001", None, "serial:usb=0403:6001,serial=A1@9600"),
        ("serial=A1@115200", None, "serial:usb=0403:6001,serial=A1@115200"),
        ("/dev/ttyUSB0@115200", None, "serial:usb=0403:6001,serial=A1@115200"),
        ("serial:/dev/hilbench/robot0", 57600, "serial:usb=0403:6001,serial=A1@57600"),
        ("/dev/ttyS0@57600", 57600, "serial:/dev/ttyS0@57600"),
        ("serial:/dev/ttyS0@9600,dtr=off,rts=on,parity=E,stop=2", None,
         "serial:/dev/ttyS0@9600,dtr=off,rts=on,parity=E,stop=2"),
        ("socket://robot:8101", None, "serial:socket://robot:8101@9600"),
    ],
)  # fmt: skip
def test_a_port_is_named_as_a_target_is(tmp_path, name, baud, target):
    init_port(SLOW, name, baud, tmp_path, ports=lambda: [SOLDERED, port(0)])
    assert target_in(tmp_path) == target
    assert parse_serial_target(target).baud == int(target.rpartition("@")[2].partition(",")[0])


def test_a_path_of_the_working_folder_is_written_from_the_root(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    init_port(SLOW, "serial:./board", None, tmp_path, ports=list)
    assert target_in(tmp_path) == f"serial:{tmp_path}/board@9600"


def test_two_rates_are_refused(tmp_path):
    with pytest.raises(UsageError, match=r"--baud 9600: the port has 115200 baud; say one rate"):
        init_port(SLOW, "/dev/ttyUSB0@115200", 9600, tmp_path, ports=list)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "there", "error", "said"),
    [
        ("serial:", [port(0)], UsageError, "not a serial port: 'serial:'"),
        ("", [], UnavailableError, "nothing is plugged in"),
        ("", [SOLDERED], UnavailableError, "nothing is plugged in"),
        ("", [port(0), port(1, serial="B")], UsageError, "several boards are plugged in: /dev/ttyUSB0, /dev/ttyUSB1"),
        ("serial=B", [port(0)], HilbenchError, "serial=B"),
    ],
)
def test_which_board_is_never_guessed(tmp_path, name, there, error, said):
    with pytest.raises(error, match=said):
        init_port(SLOW, name, None, tmp_path, ports=lambda: there)
    assert not list(tmp_path.iterdir())


def test_a_port_without_identity_is_known_by_its_name(tmp_path):
    written = init_port(SLOW, "/dev/null", 57600, tmp_path, ports=lambda: [SOLDERED])
    assert target_in(tmp_path) == "serial:/dev/null@57600"
    assert written.notes == ("the board is at /dev/null, which is no USB port: it is known by this name alone",)


def test_a_port_that_is_not_there_is_said_to_be_so(tmp_path):
    written = init_port(SLOW, "/dev/ttyNONE", None, tmp_path, ports=lambda: [SOLDERED])
    assert written.notes == ("the board is at /dev/ttyNONE, which is not there now: it is known by this name alone",)


def test_the_number_that_bridges_leave_the_factory_with_tells_none_apart(tmp_path):
    init_port(SLOW, "", None, tmp_path, ports=lambda: [port(0, serial="0001")])
    assert target_in(tmp_path) == "serial:usb=0403:6001,location=1-1@9600"


def test_an_ini_of_the_user_stays(tmp_path):
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    written = init_port(SLOW, "", None, tmp_path, ports=lambda: [port(0)])
    assert [file.name for file in written.files] == ["test_board.py"]
    assert "--hil-target serial:usb=0403:6001,serial=A1@9600" in written.notes[1]
    assert (tmp_path / "pytest.ini").read_text() == "[pytest]\n"
