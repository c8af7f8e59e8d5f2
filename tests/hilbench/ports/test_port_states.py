from __future__ import annotations

import dataclasses
import fcntl
import json
import os
import pty
import subprocess
import sys

import pytest

from hilbench.cli import main
from hilbench.files.host import Host, this_host
from hilbench.ports.holders import Holder, holders_of
from hilbench.ports.listing import SysfsPorts
from hilbench.ports.states import port_states
from hilbench.udev.installing import INSTALL_BY


@pytest.fixture
def host(machine):
    (machine.root / "etc").mkdir()
    group = os.stat(machine.root / "dev").st_gid
    (machine.root / "etc/group").write_text(f"dialout:x:{group}:somebody\n")
    return Host(root=machine.root, user="somebody", user_id=1000, may_use=lambda path: False)


def states(host):
    return port_states(host, SysfsPorts(host.root)())


def process(host, number, name="minicom", opens=()):
    folder = host.root / f"proc/{number}/fd"
    folder.mkdir(parents=True)
    folder.parent.joinpath("comm").write_text(f"{name}\n")
    for descriptor, path in enumerate(opens, 3):
        (folder / str(descriptor)).symlink_to(path)


def granted(host):
    return dataclasses.replace(host, may_use=lambda _: True)


def install_rules(host):
    folder = host.root / "etc/udev/rules.d"
    folder.mkdir(parents=True)
    (folder / "70-hilbench.rules").touch()


def test_a_port_that_is_free_needs_nothing(machine, host):
    machine.plug("ttyACM0", serial="0668FF")
    (state,) = states(granted(host))
    assert (state.permitted, state.advice, state.holders.programs) == (True, (), ())
    assert state.target == "serial:serial=0668FF"


@pytest.mark.parametrize(
    ("devices", "targets"),
    [
        ([{"serial": "A"}, {"serial": "B"}], ["serial=A", "serial=B"]),
        ([{"serial": "A"}, {"serial": "A"}], ["location=1-0", "location=1-1"]),
        ([{"serial": "A", "interface": 0, "location": "1-0"}, {"serial": "A", "interface": 1, "location": "1-0"}],
         ["serial=A,interface=0", "serial=A,interface=1"]),
        ([{"interface": 0, "location": "1-0"}, {"interface": 1, "location": "1-0"}],
         ["location=1-0,interface=0", "location=1-0,interface=1"]),
        ([{"serial": "0001"}], ["location=1-0"]),
        ([{"serial": "A,location=1-1"}, {"serial": "x@1"}, {"serial": " "}],
         ["location=1-0", "location=1-1", "location=1-2"]),
    ],
    ids=["numbers", "one number twice", "one device, two ports", "without numbers", "factory's", "odd"],
)  # fmt: skip
def test_a_port_is_named_by_the_words_that_last(machine, host, devices, targets):
    from hilbench.ports.choice import choose_port, parse_port_choice

    for number, device in enumerate(devices):
        machine.plug(f"ttyUSB{number}", driver="ftdi_sio", **{"location": f"1-{number}"} | device)
    found = states(host)
    assert [state.target.removeprefix("serial:") for state in found] == targets
    ports = [state.port for state in found]
    for state, target in zip(found, targets, strict=True):
        assert choose_port(parse_port_choice(target), ports) is state.port


def test_who_has_it_open_is_named(machine, host):
    machine.plug("ttyACM0", serial="A")
    process(host, 7, opens=["/dev/null", "/dev/ttyACM0"])
    process(host, 8, opens=["/dev/ttyACM01"])
    (state,) = states(granted(host))
    assert state.holders.programs == (Holder(process=7, name="minicom"),)
    assert [str(advice) for advice in state.advice] == ["it is in use: stop minicom (7)"]


def test_who_locked_it_is_named_even_if_his_descriptors_are_hidden(machine, host):
    machine.plug("ttyACM0", serial="A")
    node = os.stat(machine.root / "dev/ttyACM0")
    place = f"{os.major(node.st_dev):02x}:{os.minor(node.st_dev):02x}:{node.st_ino}"
    process(host, 9, name="ModemManager")
    (host.root / "proc/locks").write_text(
        f"1: POSIX  ADVISORY  WRITE 5 {place} 0 EOF\n2: FLOCK  ADVISORY  WRITE 9 {place} 0 EOF\n"
        f"3: FLOCK  ADVISORY  WRITE 6 {place}1 0 EOF\n4: FLOCK  ADVISORY  WRITE 0 {place} 0 EOF\n"
    )
    (state,) = states(granted(host))
    assert [str(one) for one in state.holders.programs] == [
        "a program that cannot be seen from here",
        "ModemManager (9)",
    ]


@pytest.mark.parametrize(
    ("text", "programs", "stale"),
    [
        ("      7\n", (Holder(process=7, name="minicom"),), None),
        ("      6\n", (), "/run/lock/LCK..ttyACM0"),
        ("", (), "/run/lock/LCK..ttyACM0"),
        ("\0\1", (), "/run/lock/LCK..ttyACM0"),
    ],
)
def test_a_lock_file_counts_as_long_as_its_program_runs(machine, host, text, programs, stale):
    machine.plug("ttyACM0", serial="A")
    process(host, 7)
    (host.root / "run/lock").mkdir(parents=True)
    (host.root / "run/lock/LCK..ttyACM0").write_text(text)
    (host.root / "var").mkdir()
    (host.root / "var/lock").symlink_to(host.root / "run/lock")
    (state,) = states(granted(host))
    assert (state.holders.programs, state.holders.stale_lock) == (programs, stale)
    assert any("sudo rm /run/lock/LCK..ttyACM0" in advice.fix for advice in state.advice) == (stale is not None)


@pytest.mark.parametrize(
    ("device", "account", "rules", "said"),
    [
        ({}, frozenset({"dialout"}), False, "no access yet: you came into the group dialout after you logged in"),
        ({}, frozenset(), False, f"no access: {INSTALL_BY}"),
        ({}, frozenset(), True, 'no access: sudo usermod -aG dialout "$USER"'),
        ({"ids": "1234:0001"}, frozenset(), False, 'no access: sudo usermod -aG dialout "$USER"'),
    ],
    ids=["not logged in again", "no rules", "rules, another seat", "a device the rules do not know"],
)
def test_without_access_it_says_what_to_do(machine, host, device, account, rules, said):
    machine.plug("ttyACM0", **device)
    if rules:
        install_rules(host)
    (state,) = states(dataclasses.replace(host, groups_of_account=account))
    assert not state.permitted
    assert str(state.advice[0]).startswith(said)


@pytest.mark.parametrize(
    ("group", "mode", "member", "said"),
    [
        ("dialout", 0o660, False, 'sudo usermod -aG dialout "$USER", then log out and in again'),
        ("dialout", 0o640, True, "sudo chmod g+rw /dev/ttyUSB0"),
        ("root", 0o600, False,
         ('sudo usermod -aG dialout "$USER", then log out and in again; '
          "sudo chgrp dialout /dev/ttyUSB0; sudo chmod g+rw /dev/ttyUSB0")),
        ("root", 0o660, True, "sudo chgrp dialout /dev/ttyUSB0"),
        ("dialout", 0o660, True, "something beside group and mode keeps you out: getfacl /dev/ttyUSB0"),
    ],
)  # fmt: skip
def test_what_to_do_without_access_helps(machine, host, group, mode, member, said):
    """Whoever is in the group already is not sent there, and the group is one that owns the port then."""
    machine.plug("ttyUSB0", ids="1234:0001", driver="option")
    (machine.root / "dev/ttyUSB0").chmod(mode)
    number = os.stat(machine.root / "dev/ttyUSB0").st_gid
    (machine.root / "etc/group").write_text(f"{group}:x:{number}:\ndialout:x:99999:\n")
    groups = frozenset({"dialout"} if member else ())
    (state,) = states(dataclasses.replace(host, groups=groups, groups_of_account=groups))
    assert [(advice.what, advice.fix) for advice in state.advice] == [("no access", said)]


def test_a_port_without_a_node_is_that_of_a_container(machine, host):
    machine.plug("ttyACM0")
    (machine.root / "dev/ttyACM0").unlink()
    (state,) = states(host)
    assert "start it with --device /dev/ttyACM0" in state.advice[0].fix


@pytest.mark.parametrize(
    ("latency", "rules", "said"), [(16, False, INSTALL_BY), (16, True, "echo 1"), (1, False, None)]
)
def test_a_slow_ftdi_chip_is_told(machine, host, latency, rules, said):
    folder = machine.plug("ttyUSB0", ids="0403:6001", driver="ftdi_sio")
    (folder / "latency_timer").write_text(f"{latency}\n")
    if rules:
        install_rules(host)
    (state,) = states(granted(host))
    assert state.port.latency_ms == latency
    assert [said in advice.fix and "up to 16 ms" in advice.what for advice in state.advice] == ([True] if said else [])


def test_really_an_open_and_locked_port_has_its_holder():
    master, slave = pty.openpty()
    fcntl.flock(slave, fcntl.LOCK_EX)
    found = holders_of(this_host(), os.ttyname(slave))
    fcntl.flock(slave, fcntl.LOCK_UN)
    device = os.ttyname(slave)
    os.close(slave)
    assert os.getpid() in [one.process for one in found.programs]
    assert os.getpid() not in [one.process for one in holders_of(this_host(), device).programs]
    os.close(master)


def test_really_who_serves_a_pseudo_terminal_does_not_hold_it_and_its_client_does():
    master, slave = pty.openpty()
    other = pty.openpty()
    device = os.ttyname(slave)
    program = [sys.executable, "-c", "print(flush=True); input()"]
    client = subprocess.Popen(program, stdin=slave, stdout=subprocess.PIPE, pass_fds=[other[0]])
    try:
        assert client.stdout.readline() == b"\n"
        assert [one.process for one in holders_of(this_host(), device).programs] == [client.pid]
    finally:
        client.kill()
        client.communicate()
    assert holders_of(this_host(), device).programs == ()
    assert holders_of(this_host(), os.ttyname(other[1])).programs == ()
    for descriptor in (master, slave, *other):
        os.close(descriptor)


def test_the_command_shows_each_port(machine, host, monkeypatch, capsys):
    machine.plug("ttyACM0", serial="0668FF", location="1-1.2", interface=2, product="STM32 STLink")
    machine.solder("ttyS0")
    machine.link("/dev/hilbench/stlink-0668FF-if02", "ttyACM0")
    process(host, 7, opens=["/dev/ttyACM0"])
    monkeypatch.setattr("hilbench.files.host.this_host", lambda: host)
    monkeypatch.setattr("hilbench.ports.listing.list_ports", SysfsPorts(machine.root))
    assert main(["ports"]) == 0
    out = capsys.readouterr().out
    first, second = out.split("\n\n")
    assert first.splitlines() == [
        "/dev/ttyACM0  ST-LINK/V2-1 (cdc_acm)",
        "  plugged in   0483:374b at 1-1.2, interface 2, serial number 0668FF",
        "  probably     a Nucleo board, such as the NUCLEO-F767ZI",
        "  target       serial:serial=0668FF",
        "  also         /dev/hilbench/stlink-0668FF-if02",
        "  access       no (dialout 0644)",
        "  in use       minicom (7)",
        f"  do           no access: {INSTALL_BY}, then plug it in again",
        "  do           it is in use: stop minicom (7)",
    ]
    assert second.startswith("/dev/ttyS0  soldered in (serial8250)")
    assert main(["ports", "--json"]) == 0
    board, soldered = json.loads(capsys.readouterr().out)
    assert board["usb"] == {
        "id": "0483:374b",
        "serial_number": "0668FF",
        "location": "1-1.2",
        "interface": 2,
        "manufacturer": None,
        "product": "STM32 STLink",
    }
    assert board["held_by"] == [{"process": 7, "name": "minicom"}]
    assert (soldered["usb"], soldered["chip"], soldered["target"]) == (None, None, "serial:/dev/ttyS0")


def test_the_command_says_so_where_there_is_none(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("hilbench.ports.listing.list_ports", SysfsPorts(tmp_path))
    assert main(["ports"]) == 0
    out, err = capsys.readouterr()
    assert (out, err.startswith("there is no serial port here")) == ("", True)
    assert main(["ports", "--json"]) == 0
    assert capsys.readouterr().out == "[]\n"
