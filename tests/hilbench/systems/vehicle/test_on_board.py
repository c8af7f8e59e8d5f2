"""The bench of the emulated vehicle interface: its lines, its joystick, lights and reset, with our firmware."""

from __future__ import annotations

import pytest

from hilbench.benchfile.reader import open_bench
from hilbench.check import CheckOptions, Verdict, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.errors import InternalError
from hilbench.judging.provider import CaseInfo, CaseSetup
from hilbench.mcu.board_case import BoardCase
from hilbench.suites._vehicle import Vehicle, vehicle_bench
from hilbench.systems.vehicle.on_board import BoardHands, VehicleOnBoard, vehicle_hands_on
from protocols.autoware import ControlMode, HazardLights, HazardLightsCommand
from protocols.carla import Mode

OPTIONS = CheckOptions(bench="vehicle", suites=("vehicle-board",))


@pytest.fixture
def there():
    provider = make_provider(OPTIONS)
    info = CaseInfo(id="test", clause_ids=(), seed=0, setup=CaseSetup(program="hardened"))
    with provider.open_case(info) as case:
        assert isinstance(case, BoardCase)
        yield case
    provider.close()


def test_what_it_can_do():
    assert {*vehicle_hands_on(open_bench("vehicle"))} == {
        "CARLA",
        "board",
        "stack",
        "boot",
        "lamps",
        "indicators",
        "line errors",
        "joystick",
        "hang",
    }
    assert {*vehicle_hands_on(open_bench("rover"))} == set()
    assert {"PKT!", "P2OS"}.isdisjoint(make_provider(OPTIONS).capabilities)


def test_joystick_lights_lamps_and_reset(there):
    vehicle = Vehicle(vehicle_bench(there))
    vehicle.autoware()
    assert vehicle.light == "amber"
    assert vehicle.hands.lamps() == (False, False)
    assert vehicle.stack.request(ControlMode.MANUAL).success
    vehicle.hands.set_joystick(65_535, 33_580)
    vehicle.run(0.4)
    assert vehicle.light == "green"
    last = vehicle.frames()[-1].packet
    assert (last.mode, last.steering, last.speed) == (Mode.MANUAL, -1.0, 0.0)
    vehicle.stack.send(HazardLightsCommand(command=HazardLights.ENABLE))
    lit = set()
    for _ in range(10):
        vehicle.run(0.1)
        lit.add(vehicle.hands.lamps())
        if (True, True) in lit:
            break
    assert (True, True) in lit
    vehicle.hands.press()
    vehicle.run(0.4)
    assert vehicle.light == "amber"
    mark = vehicle.mark()
    vehicle.feed(status_hz=None, command_hz=None)
    vehicle.stack.online = False
    vehicle.hands.reset()
    vehicle.run(0.3)
    assert vehicle.light == "none"
    assert vehicle.frames(mark + 1) == []


@pytest.mark.exhaustive("starts the firmware once more; the gate has its joystick and its lamps")
def test_a_bench_without_a_joystick_says_so(there):
    with pytest.raises(InternalError, match="no joystick"):
        BoardHands(there, "").press()


def test_its_lines_are_told_apart_by_their_usarts(there):
    ends = VehicleOnBoard(there)
    assert (ends.simulator.port.name, ends.stack.port.name) == ("brain.usart2", "brain.usart3")


@pytest.mark.parametrize(
    ("clause", "image"),
    [
        ("VB25H", "vehicle-h2"),
        pytest.param(
            "VB19",
            "vehicle-v1",
            marks=pytest.mark.exhaustive("the gate finds the other image, and the same fault in the model"),
        ),
    ],
)
def test_a_faulty_image_is_found(clause, image):
    from hilbench.terminal.options import TargetChoice
    from targets.firmware import image_path

    choice = TargetChoice(name="brain.hardened", spec=f"nucleo-h753zi:{image_path(image)}")
    options = CheckOptions(
        bench="vehicle", suites=("vehicle-board",), targets=(choice,), select=f"{clause} and hardened"
    )
    (case,) = run_suites(options, make_provider(options)).cases
    assert case.verdict is Verdict.FAIL
    if image == "vehicle-v1":
        assert "frames of EMERGENCY" in case.cause
        assert "one every 1.6" in case.cause
