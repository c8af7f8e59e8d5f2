from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from hilbench.doctor.facts import Facts
from hilbench.files.host import Host, Ran
from hilbench.ports.listing import PortInfo, UsbIdentity
from hilbench.udev.installing import rules_text

BOARD = UsbIdentity(vendor_id=0x0403, product_id=0x6001, serial_number="A50285BI", location="1-1.2")


def _run(command):
    return Ran(code=0, output="12.2.1\n" if command[0].endswith("gcc") else "257\n")


class Bench:
    """A machine at which nothing is wrong, and where a problem can be made."""

    def __init__(self, root: Path):
        self.root = root
        for folder in ("dev", "proc/7", "etc/udev/rules.d", "work", "state", "tmp"):
            (root / folder).mkdir(parents=True)
        group = (root / "dev").stat().st_gid
        self.write("etc/group", f"dialout:x:{group}:\n")
        self.write("proc/7/comm", "bash\n")
        self.write("proc/sys/kernel/pty/max", "4096\n")
        self.write("proc/sys/kernel/pty/nr", "3\n")
        self.write("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc\n")
        self.write("etc/udev/rules.d/70-hilbench.rules", rules_text("dialout"))
        self.port_list: list[PortInfo] = []
        self.host = Host(
            root=root,
            user="somebody",
            user_id=1000,
            groups=frozenset({"dialout"}),
            groups_of_account=frozenset({"dialout"}),
            which=lambda name: f"/usr/bin/{name}",
            run=_run,
            may_use=lambda _: True,
        )
        self.facts = Facts(
            host=self.host,
            ports=lambda: self.port_list,
            python=(3, 12, 1),
            executable="/env/bin/python",
            requirements=("pyelftools==0.33", "pyserial<4,>=3.5", "tool>=1; extra == 'dev'"),
            version_of={"pyelftools": "0.33", "pyserial": "3.5", "pybullet": "3.2.7"}.get,
            import_error=lambda _: None,
            core=lambda: "/env/libhilmcu.so, by gcc 12.2.0, sources 3fa91b3c4d5e",
            distributions={"protocols": ["hilbench", "hilbench"], "yaml": ["PyYAML"]},
            intruder=None,
            working_folder=root / "work",
            open_pty=lambda: None,
            file_limit=1024,
            lateness_ns=lambda: [50_000] * 100,
            state_folder=root / "state",
            temporary_folder=root / "tmp",
            write_error=lambda _: None,
            calibration=lambda _device, _ports: None,
        )

    def write(self, path, text):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def plug(self, device="/dev/ttyUSB0", **more):
        node = self.root / device.lstrip("/")
        node.touch()
        node.chmod(0o660)
        port = PortInfo(**{"device": device, "usb": BOARD, "driver": "ftdi_sio", "latency_ms": 1} | more)
        self.port_list.append(port)
        return port

    def change(self, **more):
        self.facts = dataclasses.replace(self.facts, **more)

    def change_host(self, **more):
        self.host = dataclasses.replace(self.host, **more)
        self.change(host=self.host)


@pytest.fixture
def bench(tmp_path):
    return Bench(tmp_path / "machine")
