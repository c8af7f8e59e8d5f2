"""The packets the robot sends, made from the state of its parts."""

from __future__ import annotations

import math
from collections.abc import Callable

from protocols.p2os import (
    BatteryPacket,
    BatteryReading,
    ConfigPacket,
    EncoderPacket,
    GripperPacket,
    GyroPacket,
    GyroReading,
    IoPacket,
    JoystickPacket,
    PlaylistPacket,
    ServerPacket,
    Sip,
    SonarReading,
    Tcm2Packet,
)
from targets.robots.pioneer.controller import Controller
from targets.robots.pioneer.hostbaud import RATES
from targets.robots.pioneer.requests import Extra
from targets.robots.pioneer.sonar import ARRAY

POSITION_MASK = 0x7FFF
"""Positions are free-running counters of 15 bits (reedhedges/AriaCoda src/ArRobot.cpp masks them so)."""

_BATTERY_CELLS_DV = 105, 130
"""Empty and full of a 12 V lead battery as this model reports charge, 0.1 V (choice)."""
_GYRO_STILL, _GYRO_COUNTS_PER_DEG_S, _GYRO_TEMPERATURE = 512, 2.0, 60
"""Raw gyro values; the scale is assumed."""


def make_sip(controller: Controller, now_ns: int) -> Sip:
    """The SIP of this cycle. Takes the sonar readings that are new.

    The status says "moving" exactly when a wheel speed in the same packet is not zero. Wheel speeds are measured from
    the encoders, so a stalled or blocked robot stands still.
    """
    s, pose = controller.settings, controller.odometer.pose
    left, right = (_signed16(v / s.speed_unit_mm_s) for v in controller.odometer.wheel_speeds_mm_s())
    control_deg = controller.motion.heading_setpoint_deg - controller.odometer.zero_heading_deg
    stall_rear, stall_front = _stall_bytes(controller)
    return Sip(
        moving=bool(left or right),
        x_raw=round(pose.x_mm / s.distance_unit_mm) & POSITION_MASK,
        y_raw=round(pose.y_mm / s.distance_unit_mm) & POSITION_MASK,
        th_raw=_heading_raw(controller, pose.heading_deg),
        left_raw=left,
        right_raw=right,
        battery_dv=controller.battery_dv,
        stall_rear=stall_rear,
        stall_front=stall_front,
        control_raw=_heading_raw(controller, control_deg),
        flags=controller.motion.motors_on | controller.sonar.on << 1,
        compass_raw=round(_compass_deg(controller) / 2) % 180 if controller.compass_on else 0,
        sonars=_take_sonars(controller),
        timer=controller.io.selected_port | _gripper_state(controller, now_ns) << 8,
        analog=controller.io.selected_analog,
        digin=controller.io.digital_in,
        digout=controller.io.digital_out,
    )


def make_extra(controller: Controller, extra: Extra, now_ns: int) -> ServerPacket:
    """A packet that was asked for."""
    return _MAKERS[extra](controller, now_ns)


def _stall_bytes(controller: Controller) -> tuple[int, int]:
    """Bytes 15 and 16: a stall bit (wheel stalled, or stopped by a bumper) below the bumper segments."""
    front, rear = controller.bumpers.segments()
    bumped = controller.bumpers.latched
    left, right = (stall.stalled or bumped for stall in controller.stalls)
    return left | rear << 1, right | front << 1


def _take_sonars(controller: Controller) -> tuple[SonarReading, ...]:
    unit_mm = controller.settings.range_unit_mm
    return tuple(
        SonarReading(number=echo.disc, range_raw=min(0xFFFF, round(echo.range_mm / unit_mm)))
        for echo in controller.sonar.take_fresh()
    )


def _heading_raw(controller: Controller, heading_deg: float) -> int:
    turn = controller.settings.heading_units_per_turn
    return (round(heading_deg * turn / 360) + turn // 2) % turn - turn // 2


def _compass_deg(controller: Controller) -> float:
    """Compass heading, clockwise; north is where the robot started (the model knows no magnetic field)."""
    return -controller.odometer.travel.rotation_deg % 360


def _gripper_state(controller: Controller, now_ns: int) -> int:
    return controller.gripper.state(now_ns) if controller.settings.gripper_fitted else 0


def _signed16(value: float) -> int:
    return max(-0x8000, min(0x7FFF, round(value)))


def _config(controller: Controller, _now_ns: int) -> ConfigPacket:
    s, limits = controller.settings, controller.limits
    rot_kp, rot_kv, rot_ki, trans_kp, trans_kv, trans_ki = controller.gains
    return ConfigPacket(
        robot_type=s.robot_class,
        subtype=s.subclass,
        serial=s.serial,
        rot_vel_top_deg_s=round(s.rotation_top_deg_s),
        trans_vel_top_mm_s=round(s.translation_top_mm_s),
        rot_acc_top_deg_s2=round(s.rotation_acceleration_top_deg_s2),
        trans_acc_top_mm_s2=round(s.translation_acceleration_top_mm_s2),
        pwm_max=s.pwm_max,
        name=s.name,
        sip_cycle_ms=s.sip_cycle_ms,
        host_baud=RATES.index(controller.host_baud.baud),
        aux1_baud=s.aux1_baud,
        gripper=int(s.gripper_fitted),
        front_sonar=int(any(disc < ARRAY for disc in s.sonar_discs)),
        rear_sonar=int(any(disc >= ARRAY for disc in s.sonar_discs)),
        low_battery_dv=s.low_battery_dv,
        revcount=s.encoder_ticks_per_half_turn,
        watchdog_ms=s.watchdog_ms,
        p2mpacs=s.motor_packets,
        stall_pwm=s.stall_pwm,
        stall_count_ms=s.stall_wait_ms,
        joy_vel_mm_s=s.joystick_mm_s,
        joy_rot_vel_deg_s=s.joystick_deg_s,
        rot_vel_max_deg_s=round(limits.rotation.speed),
        trans_vel_max_mm_s=round(limits.translation.speed),
        rot_acc_deg_s2=round(limits.rotation.acceleration),
        rot_decel_deg_s2=round(limits.rotation.deceleration),
        rot_kp=rot_kp,
        rot_kv=rot_kv,
        rot_ki=rot_ki,
        trans_acc_mm_s2=round(limits.translation.acceleration),
        trans_decel_mm_s2=round(limits.translation.deceleration),
        trans_kp=trans_kp,
        trans_kv=trans_kv,
        trans_ki=trans_ki,
    )


def _encoder(controller: Controller, _now_ns: int) -> EncoderPacket:
    left, right = (_signed32(ticks) for ticks in controller.odometer.ticks)
    return EncoderPacket(left_ticks=left, right_ticks=right)


def _signed32(value: int) -> int:
    return (value + 0x8000_0000) % 0x1_0000_0000 - 0x8000_0000


def _io(controller: Controller, _now_ns: int) -> IoPacket:
    io = controller.io
    return IoPacket(digin=(io.digital_in,), digout=(io.digital_out,), analog=tuple(io.analog))


def _gripper(controller: Controller, now_ns: int) -> GripperPacket:
    return GripperPacket(kind=int(controller.settings.gripper_fitted), state=_gripper_state(controller, now_ns))


def _gyro(controller: Controller, _now_ns: int) -> GyroPacket:
    left, right = controller.odometer.wheel_speeds_mm_s()
    turn_deg_s = math.degrees((right - left) / 2 / controller.settings.believed_half_track_mm)
    rate = max(0, min(1023, round(_GYRO_STILL + turn_deg_s * _GYRO_COUNTS_PER_DEG_S)))
    return GyroPacket(readings=(GyroReading(rate_raw=rate, temperature_raw=_GYRO_TEMPERATURE),))


def _joystick(_controller: Controller, _now_ns: int) -> JoystickPacket:
    return JoystickPacket()


def _tcm2(controller: Controller, _now_ns: int) -> Tcm2Packet:
    return Tcm2Packet(heading_ddeg=round(_compass_deg(controller) * 10) % 3600)


def _playlist(_controller: Controller, _now_ns: int) -> PlaylistPacket:
    return PlaylistPacket()


def _battery(controller: Controller, _now_ns: int) -> BatteryPacket:
    empty, full = _BATTERY_CELLS_DV
    percent = round(100 * max(0.0, min(1.0, (controller.battery_dv - empty) / (full - empty))))
    return BatteryPacket(batteries=(BatteryReading(relative_percent=percent, absolute_percent=percent),))


_MAKERS: dict[Extra, Callable[[Controller, int], ServerPacket]] = {
    Extra.CONFIG: _config,
    Extra.ENCODER: _encoder,
    Extra.IO: _io,
    Extra.GRIPPER: _gripper,
    Extra.GYRO: _gyro,
    Extra.JOYSTICK: _joystick,
    Extra.TCM2: _tcm2,
    Extra.PLAYLIST: _playlist,
    Extra.BATTERY: _battery,
}
