"""Our own rules, read and applied without udev."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.ports.usb_devices import KINDS
from hilbench.udev.apply import Device, apply_rules
from hilbench.udev.installing import rules_text
from hilbench.udev.rules import Expression, parse_rules, problems_of
from tests.each import each

FILE = Path(__file__).parents[3] / "udev/70-hilbench.rules"
RULES, _ = parse_rules(FILE.read_text())
EVERY_DEVICE = [(kind, number) for kind in KINDS for number in kind.products]
BRLTTY_KINDS = {"ftdi", "cp210x", "ch340"}


def properties(vendor, product, **more):
    return {"ID_VENDOR_ID": f"{vendor:04x}", "ID_MODEL_ID": f"{product:04x}", "ID_USB_INTERFACE_NUM": "02"} | more


def port(vendor, product, *, action="add", kernel="ttyUSB0", **more):
    return apply_rules(
        RULES,
        Device(action=action, subsystem="tty", kernel=kernel, properties=properties(vendor, product, **more)),
    )


def usb_device(vendor, product, *, files=frozenset()):
    product_of_event = f"{vendor:x}/{product:x}/600"
    event = properties(vendor, product, DEVTYPE="usb_device", PRODUCT=product_of_event)
    return apply_rules(RULES, Device(subsystem="usb", properties=event, files=files)), product_of_event


def test_nothing_is_wrong_in_them():
    assert problems_of(FILE.read_text()) == []


def test_every_key_and_operator_in_them_is_read():
    text = " ".join(line for line in FILE.read_text().splitlines() if not line.startswith("#"))
    assert sum(len(rule.expressions) for rule in RULES) == text.count('"') / 2


def test_udev_itself_finds_nothing():
    udevadm = shutil.which("udevadm")
    version = subprocess.run([udevadm, "--version"], capture_output=True, text=True).stdout if udevadm else "none"
    if not version.strip().isdigit() or int(version) < 254:
        pytest.skip(f"udevadm verify not run: systemd 254 can, here is {version.strip()}")
    done = subprocess.run([udevadm, "verify", "--resolve-names=never", str(FILE)], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_each_device_of_the_table_is_known_to_the_rules():
    for kind, product in EVERY_DEVICE:
        which = f"{kind.name} {product:04x}"
        made = port(kind.vendor_id, product, ID_SERIAL_SHORT="A1", ID_PATH="pci-0-usb-0:1.2:1.2")
        assert made.links == [f"hilbench/{kind.name}-A1-if02", "hilbench/at-pci-0-usb-0:1.2:1.2"], which
        assert (made.tags, made.group, made.mode) == (["uaccess"], "dialout", "0660"), which
        assert (made.properties["ID_MM_PORT_IGNORE"], made.properties["ID_MM_DEVICE_IGNORE"]) == ("1", "1"), which
        device, _ = usb_device(kind.vendor_id, product)
        assert device.properties["ID_MM_DEVICE_IGNORE"] == "1", which
        assert (device.tags == ["uaccess"]) == kind.name.startswith("stlink"), which


@given(st.integers(0, 0xFFFF), st.integers(0, 0xFFFF))
def test_no_other_device_is_touched(vendor, product):
    known = any(kind.vendor_id == vendor and product in kind.products for kind in KINDS)
    made = port(vendor, product, ID_SERIAL_SHORT="A1", ID_PATH="here")
    device, _ = usb_device(vendor, product)
    assert bool(made.links) == bool(made.tags) == known
    assert ("ID_MM_DEVICE_IGNORE" in device.properties) == known


@each("serial", ["", "0001"])
def test_without_a_number_of_its_own_a_port_is_named_by_its_place_only(serial):
    made = port(0x10C4, 0xEA60, ID_SERIAL_SHORT=serial, ID_PATH="here")
    assert made.links == ["hilbench/at-here"]


@each("kernel", ["ttyS0", "ttyAMA0", "hidraw0"])
def test_what_is_no_usb_port_is_left_alone(kernel):
    assert port(0x0403, 0x6001, kernel=kernel, ID_PATH="here").links == []


def test_when_a_device_goes_nothing_is_done():
    assert port(0x0403, 0x6001, action="remove", ID_PATH="here").links == []


def test_brltty_does_not_know_generic_chips_unless_somebody_needs_it():
    for kind, product in EVERY_DEVICE:
        device, before = usb_device(kind.vendor_id, product)
        expected = f"not-for-brltty/{before}" if kind.name in BRLTTY_KINDS else before
        assert device.properties["PRODUCT"] == expected, kind.name
        kept, before = usb_device(kind.vendor_id, product, files=frozenset({"/etc/hilbench/keep-brltty"}))
        assert kept.properties["PRODUCT"] == before, kind.name


@each(
    ("ids", "attributes", "written"),
    [
        (("0403", "6001"), {"latency_timer": "16"}, {"latency_timer": "1"}),
        (("0403", "6001"), {}, {}),
        (("10c4", "ea60"), {"latency_timer": "16"}, {}),
    ],
)
def test_only_ftdi_chips_get_another_latency(ids, attributes, written):
    above = {"idVendor": ids[0], "idProduct": ids[1]}
    hub = {"idVendor": "0403", "idProduct": "ffff"}
    made = apply_rules(RULES, Device(subsystem="usb-serial", kernel="ttyUSB0", attributes=[attributes, {}, above, hub]))
    assert made.written == written


def test_vendor_and_product_must_be_of_the_same_device():
    places = [
        {"latency_timer": "16"},
        {"idVendor": "0403", "idProduct": "ffff"},
        {"idVendor": "1", "idProduct": "6001"},
    ]
    assert apply_rules(RULES, Device(subsystem="usb-serial", attributes=places)).written == {}


def test_another_group_stands_everywhere():
    text = rules_text("uucp")
    assert "dialout" not in text
    assert text.count('GROUP="uucp"') == FILE.read_text().count("GROUP=") == 2


@each(
    ("text", "said"),
    [
        ('KERNAL=="tty"', [(1, "unknown key KERNAL")]),
        ('\n# x\nKERNEL="tty"', [(3, "KERNEL does not go with =")]),
        ('LABEL=="x"', [(1, "LABEL does not go with =="), (1, "nothing jumps to label x")]),
        ('ATTRS=="x"', [(1, "ATTRS needs a name in braces")]),
        ('KERNEL{a}=="x"', [(1, "KERNEL takes nothing in braces")]),
        ('GOTO="end"', [(1, "there is no label end")]),
        ('LABEL="a"\nGOTO="a"', [(2, "label a stands above, and udev jumps only forward")]),
        ('GOTO="a"\nLABEL="a"\nLABEL="a"', [(3, "label a stands in line 2, too")]),
        ('LABEL="a"', [(1, "nothing jumps to label a")]),
        ("KERNEL=='tty'", [(1, "cannot be read from here: KERNEL=='tty'")]),
        ('KERNEL=="a" TAG+="b"', [(1, 'cannot be read from here: KERNEL=="a" TAG+="b"')]),
        ('KERNEL=="a", \\\n  TAG="b', [(1, 'cannot be read from here: TAG="b')]),
    ],
)
def test_what_is_wrong_is_found_with_its_line(text, said):
    assert [(problem.line, problem.what) for problem in problems_of(text)] == said


def test_lines_that_go_on_are_one_rule():
    rules, problems = parse_rules('# c \\\nKERNEL=="a", \\\n  ENV{X}+="b\\"c" \n')
    assert problems == []
    assert [(rule.line, len(rule.expressions)) for rule in rules] == [(2, 2)]
    assert rules[0].expressions[1] == Expression(key="ENV", attribute="X", operator="+=", value='b\\"c')


@given(st.text())
def test_any_text_is_read_to_its_end(text):
    rules, problems = parse_rules(text)
    lines = len(text.splitlines())
    assert all(1 <= one.line <= lines for one in [*rules, *problems])
    problems_of(text)
