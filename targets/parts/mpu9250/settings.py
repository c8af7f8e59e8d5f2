"""Which MPU-9250 it is, how it is soldered in, and where it stands."""

from __future__ import annotations

from dataclasses import dataclass

from targets.parts.settings import check_settings, setting

__all__ = ["InertialSettings", "Mpu9250Settings"]

_PS = "PS-MPU-9250A-01"
_WMM = "WMM2020 for 34.6175 S, 58.3683 W (Buenos Aires), height 20 m, September 2021"


@dataclass(frozen=True, slots=True, kw_only=True)
class InertialSettings:
    """What each sensor of the family has."""

    clock_error_percent: float = setting(0.0, "%", "choice: beyond what is drawn", least=-5, greatest=5)
    clock_phase_percent: float = setting(
        100.0,
        "%",
        "choice: how much of a sample period its clock may have gone when the program starts or changes it, seeded",
        least=0,
        greatest=100,
    )
    temperature_degc: float = setting(25.0, "degC", "choice: room temperature", least=-40, greatest=85)
    mount_roll_deg: float = setting(
        0.0, "deg", "choice: the sensor's axes are those of the body", least=-180, greatest=180
    )
    mount_pitch_deg: float = setting(0.0, "deg", "choice; turned about z, then y, then x", least=-180, greatest=180)
    mount_yaw_deg: float = setting(0.0, "deg", "choice", least=-180, greatest=180)


@dataclass(frozen=True, slots=True, kw_only=True)
class Mpu9250Settings(InertialSettings):
    """See the module. What is seeded is drawn once for each part: normal, a third of the tolerance, cut off at it.

    Raises:
        ValueError: a value makes no sensor.
    """

    ad0: bool = setting(False, "", f"{_PS} section 4.4: AD0 low is address 0x68, high 0x69")
    ready_ms: float = setting(
        11.0, "ms", f"{_PS} section 3.4.2, typical: no acknowledge after power-on before", least=0
    )
    clock_tolerance_percent: float = setting(
        1.0, "%", f"{_PS} sections 3.4.2 and 4.15: with the PLL of the gyroscope, seeded", least=0, greatest=5
    )
    accel_noise_ug_rthz: float = setting(300.0, "ug/rtHz", f"{_PS} section 3.2, low noise mode", least=0)
    gyro_noise_dps_rthz: float = setting(0.01, "dps/rtHz", f"{_PS} section 3.1", least=0)
    mag_noise_ut: float = setting(0.3, "uT rms", "assumed: two steps of the 16-bit output", least=0)
    zero_g_xy_mg: float = setting(60.0, "mg", f"{_PS} section 3.2: tolerance of x and y, seeded", least=0)
    zero_g_z_mg: float = setting(80.0, "mg", f"{_PS} section 3.2: tolerance of z, seeded", least=0)
    zero_rate_dps: float = setting(5.0, "dps", f"{_PS} section 3.1: tolerance, seeded", least=0)
    sensitivity_percent: float = setting(3.0, "%", f"{_PS} sections 3.1 and 3.2: tolerance, seeded", least=0)
    zero_field_ut: float = setting(
        30.0, "uT", f"assumed tolerance, seeded; {_PS} section 3.3 allows 500 LSB of 0.6 uT", least=0
    )
    hard_iron_x_ut: float = setting(0.0, "uT", "choice: a magnet on the board, in the axes of the accelerometer")
    hard_iron_y_ut: float = setting(0.0, "uT", "choice")
    hard_iron_z_ut: float = setting(0.0, "uT", "choice")
    field_north_nt: float = setting(17030.0, "nT", _WMM)
    field_east_nt: float = setting(-2872.0, "nT", _WMM)
    field_down_nt: float = setting(-14749.0, "nT", _WMM)
    x_axis_bearing_deg: float = setting(90.0, "deg", "choice: the world's x axis points east, its y axis north")

    def __post_init__(self) -> None:
        check_settings(self)
