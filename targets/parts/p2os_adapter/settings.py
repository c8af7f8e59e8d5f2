"""Everything about the adapter that can be different; the defaults are those of the published code."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from targets.parts.settings import check_settings, setting

__all__ = ["P2osAdapterSettings"]

_PINS = "pioneer_2DX-Interface code-esp32_d1 bluepill_comm.cpp"
_TASKS = "pioneer_2DX-Interface code-esp32_d1 task_controller.cpp"
_LIBRARY = "p2os-arduino p2os_comm.cpp"


@dataclass(frozen=True, slots=True, kw_only=True)
class P2osAdapterSettings:
    """The adapter. The defaults are those of the published one.

    Raises:
        ValueError: a value makes no adapter; the text begins with the name of the setting.
    """

    # who drives
    mode: Literal["bluepill", "gamepad", "pin"] = setting(
        "bluepill", "", f"choice; pin: {_TASKS}, the mode pin is read once at start, high is bluepill"
    )

    # its own program
    pass_ms: float = setting(1.0, "ms", f"{_TASKS}: a pass of the pin task waits one tick", least=0.1, greatest=20.0)
    dead_time_s: float = setting(1.0, "s", f"{_TASKS}: p2dx_con is not acted on before", least=0.0)
    connection_sample_ms: float = setting(
        10.0, "ms", "pinout_config.hpp: CONNECTION_SAMPLE_INTERVAL", least=1.0, greatest=100.0
    )

    # motor codes
    motor_reads: int = setting(5, "reads", _PINS, least=1, greatest=99)
    motor_read_spacing_us: float = setting(
        2.0, "us", "assumed: six digitalRead of an ESP32", least=0.0, greatest=1000.0
    )
    motor_order: Literal["lsb-first", "msb-first"] = setting(
        "lsb-first", "", f"{_PINS}; msb-first: bachelor-thesis, Listing 5.5"
    )
    speed_range_mm_s: int = setting(500, "mm/s for a sum of 8", _PINS, least=0, greatest=2000)
    turn_range_mrad_s: int = setting(340, "mrad/s for a difference of 8", _PINS, least=0, greatest=2000)
    turning: Literal["published", "differential"] = setting(
        "published", "", f"{_PINS}; differential: as two wheels would turn, eight times faster"
    )
    track_m: float = setting(2 / 0.0056 / 1000, "m", "AriaCoda params/p2dx.p: 2 / DiffConvFactor", least=0.01)
    integer_arithmetic: bool = setting(True, "", f"{_PINS} and {_LIBRARY}: C divides and casts toward zero")

    # game pad
    trigger_mm_s: int = setting(
        500, "mm/s", f"{_TASKS}: at a whole trigger; 400: bachelor-thesis, Fig. 23", least=0, greatest=2200
    )
    stick_mrad_s: int = setting(1700, "mrad/s", f"{_TASKS}: at a whole stick", least=0, greatest=8700)

    # what it sends
    speed_limit_mm_s: int = setting(500, "mm/s", "p2os-arduino p2os_config.hpp", least=0, greatest=65535)
    turn_limit_deg_s: int = setting(100, "deg/s", "p2os-arduino p2os_config.hpp", least=0, greatest=65535)
    change: float = setting(0.01, "m/s or rad/s", f"{_LIBRARY}: a smaller change is not sent", least=0.0)
    repeat_s: float = setting(2.0, "s", f"{_LIBRARY}: a motion is sent again after", least=0.01)
    pulse_s: float = setting(0.5, "s", "p2os-arduino p2os_config.hpp: PULSE_INTERVAL", least=0.01)
    enable_ms: float = setting(100.0, "ms", f"{_TASKS}: ENABLE is sent again after more than", least=1.0)
    whole_seconds: bool = setting(
        False, "", f"choice; true: {_LIBRARY}, millis2Sec cuts to whole seconds: PULSE after 1 s, repeats after 3 s"
    )

    # what it does when something is wrong
    safe_stop_s: float | None = setting(
        None, "s", f"{_PINS}: none; else stop when no motor wire and not p2dx_con changed for so long", least=0.01
    )
    reconnect_s: float | None = setting(
        1.0, "s", f"choice: try again after; none: {_TASKS}, only when p2dx_con changes", least=0.1
    )

    # encoder wires
    encoder_form: Literal["published", "wheel"] = setting(
        "published", "", f"{_PINS}: from the distance to the start, 8 numbers per rad; wheel: sectors of the wheels"
    )
    encoder_order: Literal["lsb-first", "msb-first"] = setting(
        "msb-first", "", f"{_PINS}: s1 is bit 2; lsb-first: bachelor-thesis, Fig. 22"
    )
    encoder_radius_m: float = setting(0.1, "m", f"{_PINS}, published form", least=0.001)
    encoder_base_m: float = setting(0.5, "m", f"{_PINS}, published form", least=0.0)
    wheel_radius_m: float = setting(
        0.0825, "m", "Pioneer 2 Operations Manual: wheels of 165 mm, wheel form", least=0.001
    )

    # distance wires
    distance_threshold_m: float = setting(
        1.0, "m", f"{_PINS} since 2024-12-17; 4.0 before; bachelor-thesis: half of the range", least=0.0
    )
    distance_sense: Literal["near", "far"] = setting(
        "near", "", f"{_PINS}: high if not beyond the threshold; far: high if beyond, as in November 2024"
    )
    dd1_forced_low: bool = setting(True, "", f"{_PINS}: DD1 is low whatever sonar 0 says")
    dd7_8_driven: bool = setting(False, "", f"{_PINS}: only DD1 to DD6 are outputs")

    def __post_init__(self) -> None:
        check_settings(self)
