"""`hilbench init --protocol` of our own protocols: what is written passes on what speaks them."""

from __future__ import annotations

import pytest

from hilbench.cli import main
from hilbench.doctor.first_test import init_port
from hilbench.ports.listing import PortInfo, UsbIdentity
from hilbench.systems.pioneer.protocol import P2OS
from hilbench.systems.rover.protocol import PKT

ADAPTER = UsbIdentity(
    vendor_id=0x0403, product_id=0x6001, serial_number="A1", location="1-1", interface=0, product="FT"
)


@pytest.mark.parametrize("protocol", [P2OS, PKT], ids=lambda protocol: protocol.name)
def test_the_tests_pass_on_what_speaks_it(tmp_path, protocol):
    """On the bench that the pytest.ini names, without the port: the virtual robot and the rover's model."""
    init_port(protocol, "", None, tmp_path, ports=lambda: [PortInfo(device="/dev/ttyUSB0", usb=ADAPTER)])
    bench = {"pioneer": "pioneer-plane"}.get(protocol.first_test.bench, "rover-model")
    assert main(["check", bench, "--suite", str(tmp_path / "test_board.py")]) == 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--protocol", "p2os", "--board", "bluepill"], "--board: is for an emulated board"),
        (["--port", "/dev/ttyS0"], "--port: is for a board at a port"),
        (["--baud", "9600"], "--baud: is for a board at a port"),
        ([], "init: --board, --image are missing"),
        (["--board", "bluepill"], "init: --image is missing"),
        (["--protocol", "p2o"], "--protocol"),
    ],
)
def test_wrong_usage(tmp_path, monkeypatch, capfd, words, said):
    monkeypatch.chdir(tmp_path)
    assert main(["init", *words]) == 2
    out, err = capfd.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert said in err
    assert not list(tmp_path.iterdir())
