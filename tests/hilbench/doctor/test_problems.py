"""Every problem is named with its fix: each is made, alone, on a machine at which nothing else is wrong."""

from __future__ import annotations

import errno

import pytest

from hilbench.doctor.finding import Finding, State, cross, fine, warning
from hilbench.doctor.report import as_data, as_text, findings_of, is_fit
from hilbench.errors import UnavailableError
from hilbench.files.host import Ran
from hilbench.ports.calibration import Calibration
from hilbench.udev.installing import INSTALL_BY, rules_text

RULES = "etc/udev/rules.d/70-hilbench.rules"
PROBLEMS = {}


def problem(subject, state, what, fix, *, target=None):
    """Say what the doctor must find once the function below has been at the machine."""

    def add(make):
        PROBLEMS[make.__name__] = (make, subject, state, what, fix, target)
        return make

    return add


def full(error):
    def raise_it():
        raise OSError(error, "")

    return raise_it


# --- software


@problem("Python", State.CROSS, "3.10.4 is too old, hilbench needs 3.11 to 3.14", "python3.11 -m venv")
def an_old_python(bench):
    bench.change(python=(3, 10, 4))


@problem("Python", State.WARNING, "3.15.0 is newer than those it is tested with", "use a Python of 3.11 to 3.14")
def a_new_python(bench):
    bench.change(python=(3, 15, 0))


@problem("wheels", State.CROSS, "pyserial is not installed", "/env/bin/python -m pip install 'pyserial<4,>=3.5'")
def a_missing_wheel(bench):
    bench.change(version_of={"pyelftools": "0.33", "pybullet": "3.2.7"}.get)


@problem("wheels", State.CROSS, "pyelftools is 0.32, not ==0.33", "pip install 'pyelftools==0.33'")
def a_wheel_of_another_version(bench):
    bench.change(version_of={"pyelftools": "0.32", "pyserial": "3.5", "pybullet": "3.2.7"}.get)


@problem(
    "wheels", State.WARNING, "hilbench runs from a folder and is not installed", "/env/bin/python -m pip install -e "
)
def a_checkout_that_is_not_installed(bench):
    bench.change(requirements=None)


@problem("emulated CPU", State.CROSS, "there is no C compiler", "sudo apt install gcc libc6-dev")
def no_library_of_the_cpu(bench):
    def core():
        raise UnavailableError("there is no C compiler", hint="sudo apt install gcc libc6-dev")

    bench.change(core=core)


@problem(
    "physics", State.WARNING, 'only benches with physics = "plane" run', "/env/bin/python -m pip install mujoco-core"
)
def no_physics(bench):
    bench.change(version_of={"pyelftools": "0.33", "pyserial": "3.5"}.get)


@problem(
    "physics", State.CROSS, "pybullet 3.2.7 cannot be imported: boom", "pip install --force-reinstall pybullet==3.2.7"
)
def broken_physics(bench):
    bench.change(import_error={"pybullet": "boom"}.get)


@problem("compiler", State.WARNING, "there is no arm-none-eabi-gcc", "sudo apt install gcc-arm-none-eabi")
def no_compiler(bench):
    bench.change_host(which=lambda name: None if name.endswith("gcc") else name)


@problem("compiler", State.WARNING, "/usr/bin/arm-none-eabi-gcc does not run", "apt install --reinstall")
def a_compiler_that_does_not_run(bench):
    bench.change_host(run=lambda command: None if command[0].endswith("gcc") else Ran(code=0, output="257\n"))


@problem("names", State.CROSS, "plans and work installs a package 'targets', too", "pip uninstall plans work && ")
def a_colliding_distribution(bench):
    bench.change(distributions={"targets": ["work", "hilbench", "plans"]})


@problem(
    "names", State.CROSS, "/x/protocols shadows the package 'protocols' of hilbench", "rename it, or take its folder"
)
def a_shadowing_folder(bench):
    intruder = UnavailableError(
        "shadows the package 'protocols' of hilbench", where="/x/protocols", hint="rename it, or take its folder off"
    )
    bench.change(intruder=intruder)


@problem("names", State.WARNING, "work/worlds shadows our package for 'python -m'", "export PYTHONSAFEPATH=1")
def a_folder_that_would_shadow(bench):
    (bench.root / "work/worlds").mkdir()


# --- the machine


@problem("pseudo-terminals", State.CROSS, "none can be opened: ", "sudo sysctl kernel.pty.max=4096")
def no_pty(bench):
    bench.change(open_pty=full(errno.ENOSPC))


@problem("pseudo-terminals", State.WARNING, "4090 of 4096 are in use", "sudo sysctl kernel.pty.max=8192")
def few_ptys_left(bench):
    bench.write("proc/sys/kernel/pty/nr", "4090\n")


@problem("descriptors", State.WARNING, "a process may have 64, few for many boards", "ulimit -n 1024")
def few_descriptors(bench):
    bench.change(file_limit=64)


@problem("clock", State.WARNING, "the kernel reads its time from hpet, which is slow", "echo tsc | sudo tee /sys/")
def a_slow_clock(bench):
    folder = "sys/devices/system/clocksource/clocksource0"
    bench.write(f"{folder}/current_clocksource", "hpet\n")
    bench.write(f"{folder}/available_clocksource", "hpet tsc acpi_pm\n")


@problem("punctuality", State.WARNING, "30.00 ms (99 %), 30.00 ms (the worst)", "cpupower frequency-set -g performance")
def a_machine_that_wakes_up_late(bench):
    bench.write("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "powersave\n")
    bench.change(lateness_ns=lambda: [50_000] * 90 + [30_000_000] * 10)


@problem("files", State.CROSS, "nothing can be written: disk full", "export TMPDIR=DIR")
def a_full_disk(bench):
    bench.change(write_error=lambda folder: "disk full" if folder.name == "tmp" else None)


@problem("files", State.WARNING, "calibrations cannot be kept: read-only", "export XDG_STATE_HOME=DIR")
def no_place_for_calibrations(bench):
    bench.change(write_error=lambda folder: "read-only" if folder.name == "state" else None)


@problem("files", State.WARNING, "calibrations cannot be kept: somebody has no home", "export XDG_STATE_HOME=DIR")
def no_home(bench):
    bench.change(state_folder=None)


# --- udev, groups, and who reaches for ports


@problem("udev rules", State.WARNING, "are not installed", INSTALL_BY)
def no_rules(bench):
    (bench.root / "etc/udev/rules.d/70-hilbench.rules").unlink()


@problem(
    "udev rules", State.CROSS, "are not installed: no access, names or quiet for a board that is plugged", INSTALL_BY
)
def no_rules_for_a_board(bench):
    no_rules(bench)
    bench.plug()


@problem("udev rules", State.WARNING, "/etc/udev/rules.d/70-hilbench.rules is not as this hilbench has it", INSTALL_BY)
def old_rules(bench):
    bench.write("etc/udev/rules.d/70-hilbench.rules", "# old\n")


@problem("udev rules", State.CROSS, "/etc/udev/rules.d/70-hilbench.rules:1: there is no label x", INSTALL_BY)
def broken_rules(bench):
    bench.write("etc/udev/rules.d/70-hilbench.rules", 'GOTO="x"\n')


@problem("group", State.WARNING, "somebody is not in dialout", 'sudo usermod -aG dialout "$USER", then log out and in')
def not_in_the_group(bench):
    bench.change_host(groups=frozenset(), groups_of_account=frozenset())


@problem("group", State.WARNING, "somebody is in dialout, but not in this session", "newgrp dialout")
def not_logged_in_again(bench):
    bench.change_host(groups=frozenset())


@problem(
    "ModemManager", State.WARNING, "runs, and sends AT commands into new ports", "sudo systemctl stop ModemManager"
)
def modem_manager(bench):
    no_rules(bench)
    bench.write("proc/7/comm", "ModemManager\n")


@problem(
    "brltty", State.CROSS, "runs, and takes FT232R, CP2102 and CH340 for braille displays", "systemctl stop brltty"
)
def brltty(bench):
    no_rules_for_a_board(bench)
    bench.write("proc/7/comm", "brltty\n")


@problem("brltty", State.WARNING, "runs; the udev rules keep udev from starting it, and do not stop it",
         "if nobody needs it here: sudo systemctl stop brltty")  # fmt: skip
def brltty_beside_the_rules(bench):
    bench.plug()
    bench.write("proc/7/comm", "brltty\n")


@problem("ModemManager", State.CROSS, "runs, and sends AT commands into new ports", INSTALL_BY)
def modem_manager_beside_old_rules(bench):
    old_rules(bench)
    bench.plug()
    bench.write("proc/7/comm", "ModemManager\n")


# --- ports


@problem("stale name", State.CROSS, "dev/hilbench/ftdi-A1-if00 leads to ../ttyUSB9, which is gone", "rm ")
def a_stale_name(bench):
    (bench.root / "dev/hilbench").mkdir()
    (bench.root / "dev/hilbench/ftdi-A1-if00").symlink_to("../ttyUSB9")


@problem("stale name", State.CROSS, "work/p2 leads to /dev/pts/99999, which is gone", "start the bench again")
def a_pty_whose_bench_has_ended(bench):
    (bench.root / "work/p2").symlink_to("/dev/pts/99999")
    (bench.root / "work/other").symlink_to("nowhere")


@problem("/dev/ttyUSB0", State.CROSS, "no access", 'sudo usermod -aG dialout "$USER", then log out and in again')
def a_port_without_permission(bench):
    bench.plug()
    bench.change_host(may_use=lambda path: path.name != "ttyUSB0", groups=frozenset(), groups_of_account=frozenset())


@problem("/dev/ttyUSB0", State.CROSS, "there is no /dev/ttyUSB0", "start it with --device /dev/ttyUSB0")
def a_container_without_the_port(bench):
    bench.plug()
    (bench.root / "dev/ttyUSB0").unlink()


@problem("/dev/ttyUSB0", State.WARNING, "it is in use", "stop minicom (8)")
def a_held_port(bench):
    bench.plug()
    bench.write("proc/8/comm", "minicom\n")
    (bench.root / "proc/8/fd").mkdir()
    (bench.root / "proc/8/fd/3").symlink_to("/dev/ttyUSB0")


@problem("/dev/ttyUSB0", State.CROSS, "it is in use", "stop minicom (8)", target="serial:usb=0403:6001")
def a_held_port_that_is_needed(bench):
    a_held_port(bench)


@problem("/dev/ttyUSB0", State.WARNING, "a program that has ended left a lock file", "sudo rm /run/lock/LCK..ttyUSB0")
def a_stale_lock(bench):
    bench.plug()
    bench.write("run/lock/LCK..ttyUSB0", "      9999\n")


@problem("/dev/ttyUSB0", State.WARNING, "what comes in waits up to 16 ms", "echo 1 | sudo tee /sys/x/latency_timer")
def a_slow_chip(bench):
    bench.plug(latency_ms=16, sysfs="/sys/x")


@problem("serial:/dev/ttyUSB7@9600", State.CROSS, "there is no such port", "there: /dev/ttyUSB0",
         target="serial:/dev/ttyUSB7@9600")  # fmt: skip
def no_such_port(bench):
    bench.plug()


@problem("serial:serial=B2", State.CROSS, "no port matches", "/dev/ttyUSB0 (usb=0403:6001, serial=A50285BI",
         target="serial:serial=B2")  # fmt: skip
def no_such_board(bench):
    bench.plug()


@problem("serial:usb=0403:6001", State.CROSS, "2 ports match", "say which", target="serial:usb=0403:6001")
def two_such_boards(bench):
    bench.plug()
    bench.plug("/dev/ttyUSB1")


@problem("serial:uzb=1", State.CROSS, "ports have no 'uzb='", "did you mean 'usb'?", target="serial:uzb=1")
def a_target_that_is_none(bench):
    pass


def wrong(findings):
    return [finding for finding in findings if finding.state is not State.FINE]


def test_nothing_is_wrong_with_a_machine_at_which_nothing_is_wrong(bench):
    bench.plug()
    findings = findings_of(bench.facts, "serial:/dev/ttyUSB0@9600")
    assert wrong(findings) == []
    assert is_fit(findings)


def test_there_are_enough_of_them():
    assert len(PROBLEMS) >= 15


@pytest.mark.parametrize("name", PROBLEMS)
def test_each_problem_is_named_with_its_fix(bench, name):
    make, subject, state, what, fix, target = PROBLEMS[name]
    make(bench)
    findings = findings_of(bench.facts, target)
    (found,) = {one for one in wrong(findings) if one.subject == subject and one.state is state}
    assert what in found.what
    assert fix in found.fix
    assert is_fit(findings) == all(one.state is not State.CROSS for one in findings)
    assert (state is State.CROSS) <= (not is_fit(findings))
    # A problem is blamed on nothing else: beside it only what comes of it, at the same place or for want of the rules.
    assert {one.subject for one in wrong(findings)} <= {subject, "udev rules", "group", "/dev/ttyUSB0"}


def test_a_group_that_was_chosen_is_as_right_as_another(bench):
    """Rules that give the ports to it stay, and it is this group that a user must be in."""
    bench.write("etc/group", (bench.root / "etc/group").read_text() + "robots:x:46:\n")
    bench.write(RULES, rules_text("robots"))
    bench.change_host(groups=frozenset({"robots"}), groups_of_account=frozenset({"robots"}))
    assert wrong(findings_of(bench.facts)) == []
    bench.write(RULES, "# old\n" + rules_text("robots"))
    (found,) = wrong(findings_of(bench.facts))
    assert (found.subject, found.fix) == ("udev rules", f"{INSTALL_BY} --group robots")
    bench.change_host(groups=frozenset())
    assert [one.fix for one in wrong(findings_of(bench.facts)) if one.subject == "group"] == [
        "log out and in again, or: newgrp robots"
    ]


def test_rules_for_a_group_that_is_not_there_are_not_right(bench):
    bench.write(RULES, rules_text("uucp"))
    (found,) = wrong(findings_of(bench.facts))
    assert (found.subject, found.fix) == ("udev rules", INSTALL_BY)


def test_root_needs_no_group(bench):
    bench.change_host(user_id=0, groups=frozenset(), groups_of_account=frozenset())
    assert wrong(findings_of(bench.facts)) == []


def test_a_soldered_port_that_is_shut_is_no_cross(bench):
    bench.plug("/dev/ttyS0", usb=None, latency_ms=None)
    bench.change_host(may_use=lambda _: False)
    assert [finding.state for finding in wrong(findings_of(bench.facts))] == [State.WARNING]
    assert not is_fit(findings_of(bench.facts, "/dev/ttyS0"))


def test_a_link_to_a_port_is_that_port(bench):
    bench.plug()
    (bench.root / "dev/hilbench").mkdir()
    (bench.root / "dev/hilbench/mine").symlink_to("../ttyUSB0")
    a_held = [one for one in findings_of(bench.facts, "serial:/dev/hilbench/mine") if one.subject == "/dev/ttyUSB0"]
    assert [one.state for one in a_held] == [State.FINE, State.FINE]


def test_what_was_measured_at_a_port_is_told(bench):
    kept = Calibration(
        key="k", target="x", measured_at="2026-01-01T00:00:00+00:00", baud=9600, round_trips=1, lost=0, wire_s=0.0,
        excess_p50_s=0.0, excess_p99_s=0.0, excess_max_s=0.0123, jitter_s=0.0, paced_bytes=1, paced_returned=1,
        paced_expected_s=0.0,
    )  # fmt: skip
    port = bench.plug()
    (found,) = [one for one in findings_of(bench.facts) if one.subject == port.device]
    assert found.what == "may be used, and is free (dialout 0660); how exact it is was not measured"
    bench.change(calibration=lambda device, ports: kept if (device, ports) == (port.device, [port]) else None)
    (found,) = [one for one in findings_of(bench.facts) if one.subject == port.device]
    assert found.what.endswith("; adds 12.30 ms to times, measured 2026-01-01T00:00:00+00:00")


def test_what_is_far_away_is_not_looked_at(bench):
    (found,) = [one for one in findings_of(bench.facts, "socket://host:8101") if "://" in one.subject]
    assert found.state is State.FINE


def test_with_rules_nobody_minds_who_runs(bench):
    bench.plug()
    bench.write("proc/7/comm", "ModemManager\n")
    assert wrong(findings_of(bench.facts)) == []


def test_it_is_printed_with_the_fix_below():
    findings = [fine("clock", "tsc"), warning("compiler", "none", "get one"), cross("wheels", "gone", "pip")]
    assert as_text(findings).splitlines() == [
        "ok     clock     tsc",
        "warn   compiler  none",
        "                 -> get one",
        "FAIL   wheels    gone",
        "                 -> pip",
        "1 problem, 1 warning",
    ]
    data = as_data(findings)
    assert data["fit"] is False
    assert data["findings"][0] == {"subject": "clock", "state": "fine", "what": "tsc", "fix": None}


def test_a_cross_without_a_fix_cannot_be_made():
    with pytest.raises(ValueError, match="has a fix"):
        Finding(subject="x", state=State.CROSS, what="y")
    with pytest.raises(ValueError, match="has a fix"):
        Finding(subject="x", state=State.FINE, what="y", fix="z")
