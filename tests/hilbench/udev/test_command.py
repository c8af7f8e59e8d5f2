from __future__ import annotations

import contextlib
import dataclasses
import json
import os
import resource
import tempfile
from pathlib import Path

import pytest

from hilbench.cli import main
from hilbench.errors import UnavailableError
from hilbench.files.host import Host, Ran
from hilbench.ports.listing import PortInfo, UsbIdentity
from hilbench.udev.installing import INSTALL_BY, check_rules, install_rules, rules_text

NAME = "70-hilbench.rules"
NOBODY = 65534


class Machine:
    """A machine whose udev we are."""

    def __init__(self, root, monkeypatch):
        self.commands = []
        self.verify = Ran(code=0, output="")
        self.version = "252 (252.38-1~deb12u1)\n"
        self.rules = root / "etc/udev/rules.d"
        self.rules.mkdir(parents=True)
        (root / "etc/group").write_text("root:x:0:\nuucp:x:986:\n")
        host = Host(root=root, which=lambda name: f"/bin/{name}", run=self.run)
        self.use(host, monkeypatch)

    def use(self, host, monkeypatch):
        self.host = host
        monkeypatch.setattr("hilbench.files.host.this_host", lambda: host)

    def run(self, command):
        self.commands.append(command[1])
        if command[1] == "--version":
            return Ran(code=0, output=self.version)
        return self.verify if command[1] == "verify" else Ran(code=0, output="")


@pytest.fixture
def folder():
    """Return a folder where everybody may look: pytest keeps its own for whoever runs it."""
    with tempfile.TemporaryDirectory() as name:
        Path(name).chmod(0o755)
        yield Path(name)


@pytest.fixture
def machine(folder, monkeypatch):
    return Machine(folder / "machine", monkeypatch)


@pytest.fixture
def ordinary_user(monkeypatch):
    """Have the rules written by who may not write everywhere, and return who that is: nobody, if root runs the tests.

    Only the writing is done as nobody, who may not even look into the folder that the code and the rules lie in.
    """
    runs_the_tests = os.geteuid()
    writes = runs_the_tests or NOBODY

    def install(*arguments):
        os.seteuid(writes)
        try:
            return install_rules(*arguments)
        finally:
            os.seteuid(runs_the_tests)

    monkeypatch.setattr("hilbench.udev.installing.install_rules", install)
    return writes


def call(*words):
    return main(["udev", *words])


def test_they_are_printed_with_the_group_of_this_machine(machine, capsys):
    assert call() == 0
    out, err = capsys.readouterr()
    assert out == rules_text("uucp")
    assert INSTALL_BY in err


def test_the_group_can_be_chosen(machine, capsys):
    assert call("--group", "robots") == 0
    assert capsys.readouterr().out == rules_text("robots")
    assert call("--group", 'x"') == 2
    assert "is no name of a group" in capsys.readouterr().err


def test_they_are_installed_and_udev_is_told(machine, capsys):
    assert call("--install") == 0
    file = machine.rules / NAME
    assert file.read_text() == rules_text("uucp")
    assert file.stat().st_mode & 0o777 == 0o644
    assert machine.commands == ["--version", "control", "trigger"]
    out, err = capsys.readouterr()
    assert out == ""
    assert f"written: {file}" in err
    assert "udevadm verify: not run, systemd 252 cannot; 254 can" in err
    assert [entry.name for entry in machine.rules.iterdir()] == [NAME]


def test_into_another_folder_nothing_is_reloaded(machine, tmp_path, capsys):
    assert call("--install", "--directory", str(tmp_path)) == 0
    assert (tmp_path / NAME).read_text() == rules_text("uucp")
    assert machine.commands == ["--version"]
    assert "nothing was reloaded" in capsys.readouterr().err


def test_where_udev_cannot_be_told_it_says_how(machine, monkeypatch, capsys):
    machine.use(dataclasses.replace(machine.host, which=lambda _: None), monkeypatch)
    assert call("--install") == 0
    err = capsys.readouterr().err
    assert "udevadm verify: not run, there is no udevadm here" in err
    assert "sudo udevadm control --reload-rules && sudo udevadm trigger" in err


def test_a_file_that_was_there_is_kept(machine, capsys):
    (machine.rules / NAME).write_text("# mine\n")
    assert call("--install") == 0
    assert (machine.rules / f"{NAME}.old").read_text() == "# mine\n"
    assert f"{NAME}.old" in capsys.readouterr().err
    assert call("--install") == 0
    assert (machine.rules / f"{NAME}.old").read_text() == "# mine\n"


def test_not_as_root_they_go_where_one_may_write(machine, folder, ordinary_user):
    own = folder / "own"
    own.mkdir()
    os.chown(own, ordinary_user, -1)
    assert call("--install", "--directory", str(own)) == 0
    assert (own / NAME).stat().st_uid == ordinary_user


def test_not_as_root_etc_is_refused_with_what_to_do(machine, ordinary_user, capsys):
    machine.rules.chmod(0o555)
    assert call("--install") == 3
    err = capsys.readouterr().err
    assert err.startswith(f"hilbench: {machine.rules}: only root may write there; hilbench udev | sudo tee ")
    assert list(machine.rules.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "said"), [("missing", "there is no such folder; sudo mkdir -p "), ("file", "cannot be written: Not a ")]
)
def test_a_folder_that_is_none_is_refused(machine, tmp_path, capsys, name, said):
    (tmp_path / "file").touch()
    assert call("--install", "--directory", str(tmp_path / name)) == 3
    assert f"{tmp_path / name}: {said}" in capsys.readouterr().err


@contextlib.contextmanager
def no_file_longer_than(size):
    """Have the kernel refuse what is longer, as a disk does that is full."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize("before", ["# mine\n", "# mine\n" * 1000], ids=["the new one", "the copy of the old one"])
def test_a_disk_that_is_full_leaves_what_was_there(machine, before):
    text = rules_text("uucp")
    (machine.rules / NAME).write_text(before)
    (machine.rules / f"{NAME}.old").write_text("# older\n")
    room = 1024 if len(before) < 1024 else len(text)
    with no_file_longer_than(room), pytest.raises(UnavailableError, match="cannot be written: File too large"):
        install_rules(machine.rules, text)
    assert sorted(entry.name for entry in machine.rules.iterdir()) == [NAME, f"{NAME}.old"]
    assert (machine.rules / NAME).read_text() == before
    assert (machine.rules / f"{NAME}.old").read_text() == "# older\n"
    install_rules(machine.rules, text)
    assert (machine.rules / f"{NAME}.old").read_text() == before


@pytest.mark.parametrize(
    ("text", "code", "said"),
    [
        (None, 3, f"not installed; install them: {INSTALL_BY}"),
        ("", 3, f"installed, not as this hilbench has them; put right by: {INSTALL_BY}"),
        ('GOTO="nowhere"\n', 3, f"{NAME}:1: there is no label nowhere"),
        (rules_text("uucp"), 0, "installed, as this hilbench has them"),
    ],
    ids=["missing", "other", "wrong", "right"],
)
def test_they_are_checked(machine, capsys, text, code, said):
    if text is not None:
        (machine.rules / NAME).write_text(text)
    assert call("--check") == code
    assert said in capsys.readouterr().out
    assert call("--check", "--json") == code
    assert json.loads(capsys.readouterr().out)["right"] == (code == 0)


def test_udev_has_the_last_word(machine, capsys):
    machine.version = "257\n"
    assert call("--install") == 0
    assert "udevadm verify of systemd 257: nothing found" in capsys.readouterr().err
    machine.verify = Ran(code=1, output=f"{NAME}:7 Unknown\nkey.")
    assert call("--check") == 3
    assert f"udevadm verify of systemd 257: {NAME}:7 Unknown key." in capsys.readouterr().out


def test_those_of_a_distribution_count_if_there_are_no_others(machine, capsys):
    folder = machine.host.root / "usr/lib/udev/rules.d"
    folder.mkdir(parents=True)
    (folder / NAME).write_text(rules_text("uucp"))
    assert call("--check") == 0
    (machine.rules / NAME).write_text("")  # the usual way to switch rules off
    assert call("--check") == 3


def test_a_folder_can_be_checked(machine, tmp_path, monkeypatch, capsys):
    machine.use(dataclasses.replace(machine.host, root=type(tmp_path)("/")), monkeypatch)
    monkeypatch.chdir(tmp_path)
    assert call("--install", "--directory", ".", "--group", "robots") == 0
    assert call("--check", "--directory", ".", "--group", "robots") == 0
    assert str(tmp_path / NAME) in capsys.readouterr().out


def test_the_group_that_was_chosen_is_remembered(machine, capsys):
    (machine.host.root / "etc/group").write_text("uucp:x:986:\nrobots:x:46:\n")
    assert call("--install", "--group", "robots") == 0
    assert "stay" not in capsys.readouterr().err
    assert call("--check") == 0
    assert call("--check", "--group", "uucp") == 3
    assert f"not as this hilbench has them; put right by: {INSTALL_BY}\n" in capsys.readouterr().out
    (machine.rules / NAME).write_text("# older\n" + rules_text("robots"))
    assert call("--check") == 3
    assert f"put right by: {INSTALL_BY} --group robots\n" in capsys.readouterr().out
    assert call("--install") == 0
    assert "the ports stay with the group robots; --group names another" in capsys.readouterr().err
    assert (machine.rules / NAME).read_text() == rules_text("robots")
    assert call("--install", "--group", "uucp") == 0
    assert (machine.rules / NAME).read_text() == rules_text("uucp")


def test_rules_in_a_folder_may_be_for_a_group_of_another_machine(machine, tmp_path, capsys):
    assert call("--install", "--directory", str(tmp_path), "--group", "robots") == 0
    host = dataclasses.replace(machine.host, root=Path("/"))
    assert check_rules(host, directory=str(tmp_path)).right
    (tmp_path / NAME).write_text("# older\n" + rules_text("robots"))
    fix = f"{INSTALL_BY} --directory {tmp_path} --group robots"
    assert check_rules(host, directory=str(tmp_path)).fix == fix


def test_a_file_that_names_several_groups_is_of_none(machine):
    (machine.rules / NAME).write_text(rules_text("uucp").replace('GROUP="uucp"', 'GROUP="root"', 1))
    assert call("--check") == 3
    assert call("--install") == 0
    assert (machine.rules / NAME).read_text() == rules_text("uucp")


def test_the_group_stands_in_what_there_is_to_do(machine, ordinary_user, capsys):
    assert call("--group", "robots") == 0
    assert f"to install them: {INSTALL_BY} --group robots\n" in capsys.readouterr().err
    machine.rules.chmod(0o555)
    assert call("--install", "--group", "robots") == 3
    hint = f"hilbench udev --group robots | sudo tee {machine.rules / NAME} >/dev/null && "
    hint += "sudo udevadm control --reload-rules && sudo udevadm trigger --subsystem-match=usb "
    assert hint in capsys.readouterr().err


def test_they_are_explained(machine, monkeypatch, capsys):
    usb = UsbIdentity(vendor_id=0x0483, product_id=0x374B, serial_number="0668FF", location="1-1", interface=2)
    other = UsbIdentity(vendor_id=0x1234, product_id=1, location="1-2")
    ports = [PortInfo(device="/dev/ttyACM0", usb=usb), PortInfo(device="/dev/ttyACM1", usb=other)]
    monkeypatch.setattr("hilbench.ports.listing.list_ports", lambda: ports)
    assert call("--explain") == 0
    out = capsys.readouterr().out
    assert "/dev/ttyACM0: /dev/hilbench/stlink-0668FF-if02, and one by the place it is plugged into\n" in out
    assert "/dev/ttyACM1: left alone" in out
    assert "/etc/hilbench/keep-brltty" in out
    assert call("--explain", "--json") == 0
    data = json.loads(capsys.readouterr().out)
    names = ["/dev/hilbench/stlink-0668FF-if02"]
    assert data["ports"][0] == {"device": "/dev/ttyACM0", "left_alone": False, "names": names}
    assert data["ports"][1] == {"device": "/dev/ttyACM1", "left_alone": True, "names": []}
    assert {"kind": "ch340", "usb": "1a86:7523", "chip": "CH340"} in data["devices"]


PLACE = "pci-0000:00:14.0-usb-0:1.2:1.0"


@pytest.mark.parametrize(("ids", "number"), [((0x1A86, 0x7523), None), ((0x10C4, 0xEA60), "0001")])
@pytest.mark.parametrize(
    ("links", "said", "names"),
    [
        ((f"/dev/hilbench/at-{PLACE}",), f"/dev/hilbench/at-{PLACE}", [f"/dev/hilbench/at-{PLACE}"]),
        (
            (f"/dev/serial/by-path/{PLACE.replace('usb', 'usbv2')}-port0", f"/dev/serial/by-path/{PLACE}-port0"),
            f"/dev/hilbench/at-{PLACE}",
            [f"/dev/hilbench/at-{PLACE}"],
        ),
        (("/dev/serial/by-id/usb-1a86_USB_Serial-if00-port0",), "a name by the place it is plugged into", []),
    ],
    ids=["its own name", "that of udev", "no name yet"],
)
def test_a_bridge_without_a_number_of_its_own_is_not_left_alone(
    machine, monkeypatch, capsys, ids, number, links, said, names
):
    usb = UsbIdentity(vendor_id=ids[0], product_id=ids[1], serial_number=number, location="1-1.2")
    ports = [PortInfo(device="/dev/ttyUSB0", usb=usb, links=links)]
    monkeypatch.setattr("hilbench.ports.listing.list_ports", lambda: ports)
    assert call("--explain") == 0
    assert f"  /dev/ttyUSB0: {said}\n" in capsys.readouterr().out
    assert call("--explain", "--json") == 0
    told = json.loads(capsys.readouterr().out)["ports"]
    assert told == [{"device": "/dev/ttyUSB0", "left_alone": False, "names": names}]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--directory", "x"), "--directory: goes with --install and --check"),
        (("--install", "--json"), "--json: goes with --check and --explain"),
        (("--install", "--check"), "not allowed with"),
    ],
)
def test_wrong_usage_is_refused(machine, capsys, words, said):
    assert call(*words) == 2
    assert said in capsys.readouterr().err
