from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.errors import UnavailableError, UsageError
from hilbench.ports.choice import PortChoice, choose_port, parse_port_choice
from hilbench.ports.listing import PortInfo, UsbIdentity
from hilbench.terminal.arguments import target_choice
from hilbench.terminal.options import TargetChoice
from tests.each import each


def port(device, ids="0483:374b", **changes):
    vendor, product = (int(part, 16) for part in ids.split(":"))
    return PortInfo(
        device=device, usb=UsbIdentity(**{"vendor_id": vendor, "product_id": product, "location": "1-1"} | changes)
    )


NUCLEO = port("/dev/ttyACM0", serial_number="0668FF", location="1-1.2", interface=2)
OTHER_NUCLEO = port("/dev/ttyACM1", serial_number="0669AA", location="1-1.3", interface=2)
DUAL = [port(f"/dev/ttyUSB{number}", "0403:6010", interface=number, location="2-1") for number in (0, 1)]
SOLDERED = PortInfo(device="/dev/ttyS0")
PORTS = [SOLDERED, NUCLEO, OTHER_NUCLEO, *DUAL]


@each(
    ("text", "device"),
    [
        ("serial=0668FF", "/dev/ttyACM0"),
        ("location=1-1.3", "/dev/ttyACM1"),
        ("usb=0403:6010,interface=1", "/dev/ttyUSB1"),
        ("interface=01,usb=0403:6010", "/dev/ttyUSB1"),
        ("usb=0483:374B,serial=0669AA", "/dev/ttyACM1"),
    ],
)
def test_a_port_is_chosen(text, device):
    assert choose_port(parse_port_choice(text), PORTS).device == device


@each(
    ("text", "said"),
    [
        ("usb=0483:374b", "2 ports match; say which by serial=, location= or interface=: /dev/ttyACM0 (usb="),
        ("usb=1a86:7523", "no port matches; there are /dev/ttyACM0 "),
        ("serial=0668ff", "no port matches"),
        ("serial=0668FF,location=1-1.3", "no port matches"),
    ],
)
def test_what_is_not_one_port_is_refused_with_what_is_there(text, said):
    with pytest.raises(UnavailableError) as caught:
        choose_port(parse_port_choice(text), PORTS)
    assert f"{text}: {said}" in str(caught.value)
    assert "ttyS0" not in str(caught.value)


def test_where_nothing_is_plugged_in_it_says_so():
    with pytest.raises(UnavailableError, match="no USB port is there"):
        choose_port(parse_port_choice("serial=1"), [SOLDERED])


@each("text", ["/dev/ttyUSB0", "./p2=x", "socket://host:8101", "COM3", "spy:///dev/x?file=y", ""])
def test_paths_and_urls_choose_nothing(text):
    assert parse_port_choice(text) is None


@each(
    ("text", "said"),
    [
        ("uzb=0483:374b", "ports have no 'uzb='; did you mean 'usb'?"),
        ("vid=1", "ports have no 'vid='; a port is chosen by: usb, serial, location, interface"),
        ("usb=0483", "'usb=' takes two numbers of four hex digits"),
        ("serial=", "'serial=' takes a serial number"),
        ("location=1.2", "'location=' takes bus and ports"),
        ("interface=a", "'interface=' takes a number"),
        ("serial=a,serial=b", "'serial=' is given twice"),
        ("usb=0483:374b,", "'usb=' takes"),
    ],
)
def test_a_wrong_choice_is_refused_in_words(text, said):
    with pytest.raises(UsageError) as caught:
        parse_port_choice(text)
    assert said in str(caught.value)


def test_a_serial_number_may_hold_a_comma():
    assert parse_port_choice("serial=a,b,location=1-1") == PortChoice((("serial", "a,b"), ("location", "1-1")))


@given(
    st.dictionaries(st.sampled_from(["usb", "serial", "location", "interface"]), st.integers(0, 0xFFFF), min_size=1),
)
def test_what_was_read_is_printed_as_it_was(numbers):
    forms = {"usb": "{0:04x}:{0:04x}", "serial": "S{0}", "location": "1-{0}.2", "interface": "{0}"}
    text = ",".join(f"{key}={forms[key].format(number)}" for key, number in numbers.items())
    assert str(parse_port_choice(text)) == text


@each(
    ("word", "name", "spec"),
    [
        ("serial:serial=0668FF", "", "serial:serial=0668FF"),
        ("serial:usb=0483:374b,interface=2@9600", "", "serial:usb=0483:374b,interface=2@9600"),
        ("stack=serial:location=1-1.2", "stack", "serial:location=1-1.2"),
    ],
)
def test_a_choice_in_a_target_is_not_taken_for_the_name_of_a_line(word, name, spec):
    assert target_choice(word) == TargetChoice(name=name, spec=spec)
