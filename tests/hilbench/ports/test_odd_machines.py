"""Machines on which files have odd contents, links lead in circles, and devices go in the middle of being looked at."""

from __future__ import annotations

import pytest

from hilbench.cli import main
from hilbench.doctor.access import look_at_access
from hilbench.doctor.facts import Facts
from hilbench.files.host import Host
from hilbench.links.reconnecting import identity_of
from hilbench.ports.listing import SysfsPorts
from hilbench.ports.states import as_text, port_states, state_at


@pytest.fixture
def loop(tmp_path):
    """A link that leads to itself."""
    path = tmp_path / "loop"
    path.symlink_to(path)
    return path


def states(machine):
    return port_states(Host(root=machine.root), SysfsPorts(machine.root)())


@pytest.mark.parametrize("text", ["", "\n", "xyz", "²", "-1", "123456789", "9" * 5000])
@pytest.mark.parametrize("attribute", ["idVendor", "idProduct"])
def test_a_device_without_readable_ids_is_a_port_without_identity(machine, attribute, text):
    machine.plug("ttyUSB0", driver="ftdi_sio", **{attribute: text})
    machine.plug("ttyUSB1", driver="ftdi_sio", location="1-2")
    odd, plain = states(machine)
    assert (odd.port.device, odd.port.usb, odd.target) == ("/dev/ttyUSB0", None, "serial:/dev/ttyUSB0")
    assert plain.port.usb is not None


@pytest.mark.parametrize("text", ["", "zz", "9" * 5000])
def test_a_device_that_goes_while_it_is_read_has_no_identity_rather_than_a_wrong_one(machine, text):
    folder = machine.plug("ttyUSB0", driver="ftdi_sio", interface=1)
    (folder.parent / "bInterfaceNumber").write_text(text)
    (folder / "latency_timer").write_text(text)
    (found,) = SysfsPorts(machine.root)()
    assert (found.usb, found.latency_ms) == (None, None)


def test_what_a_device_says_of_itself_does_not_reach_the_terminal_as_it_is(machine):
    machine.plug("ttyUSB0", ids="1234:5678", driver="option", product="\x1b]0;owned\x07Modem ü", serial="A\x1b[2J")
    text = as_text(states(machine))
    assert "Modem ü" in text
    assert "\x1b" not in text


@pytest.mark.parametrize("text", ["²\n", "9" * 5000])
def test_a_lock_file_of_no_program_is_a_stale_one(machine, text):
    machine.plug("ttyUSB0")
    (machine.root / "run/lock").mkdir(parents=True)
    (machine.root / "run/lock/LCK..ttyUSB0").write_text(text)
    assert states(machine)[0].holders.stale_lock == "/run/lock/LCK..ttyUSB0"


def test_links_that_lead_in_circles_are_no_names_of_ports(machine):
    machine.plug("ttyUSB0")
    for place in ("dev/hilbench", "dev/serial/by-id", "run/lock"):
        (machine.root / place).mkdir(parents=True)
    for name in ("dev/hilbench/loop", "dev/serial/by-id/loop", "run/lock/LCK..ttyUSB0", "dev/loop"):
        (machine.root / name).symlink_to(machine.root / name)
    (state,) = states(machine)
    assert state.port.links == ()
    host = Host(root=machine.root)
    assert not state_at(host, "/dev/loop", [state.port]).permitted
    found = [finding.what for finding in look_at_access(Facts(host=host, ports=SysfsPorts(machine.root)), None)]
    assert sum("dev/hilbench/loop leads to" in what for what in found) == 1


def test_a_name_that_is_stale_is_removed_by_whoever_may(machine, tmp_path, monkeypatch):
    folder = tmp_path / "with blanks"
    folder.mkdir()
    (folder / "board").symlink_to("/dev/pts/999999")
    (machine.root / "dev/hilbench").mkdir()
    (machine.root / "dev/hilbench/gone").symlink_to("/nowhere")
    host = Host(root=machine.root)
    found = look_at_access(Facts(host=host, ports=SysfsPorts(machine.root), working_folder=folder), None)
    fixes = [finding.fix for finding in found if finding.subject == "stale name"]
    assert fixes[0].startswith(f"sudo rm {machine.root}/dev/hilbench/gone, and")
    assert fixes[1].startswith(f"rm '{folder}/board', and")


def test_a_circle_is_no_port_and_no_output(loop, capfd):
    assert identity_of(str(loop), ()) is None
    assert main(["proxy", "tcp:0", f"serial:{loop}"]) == 3
    assert capfd.readouterr().err.endswith(f"{loop}: cannot be opened: Too many levels of symbolic links\n")
    assert main(["check", "pioneer-plane", "--list", "--junit", str(loop)]) == 2
    assert f"--junit {loop}: is a link that leads to itself" in capfd.readouterr().err
