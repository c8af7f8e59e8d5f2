"""What a scripted server says of the robot that it stands in for, unless a case wants something else."""

from __future__ import annotations

from protocols.p2os import ConfigPacket, Identification, Sip

IDENTIFICATION = Identification(name="bench", subclass="p2dx")
"""Who the server says it is."""

CONFIG = ConfigPacket(
    robot_type="Pioneer",
    subtype="p2dx",
    serial="BENCH001",
    rot_vel_top_deg_s=360,
    trans_vel_top_mm_s=1600,
    rot_acc_top_deg_s2=300,
    trans_acc_top_mm_s2=2000,
    pwm_max=500,
    name="bench",
    sip_cycle_ms=100,
    front_sonar=1,
    low_battery_dv=110,
    revcount=16570,
    watchdog_ms=2000,
    stall_pwm=200,
    stall_count_ms=200,
    joy_vel_mm_s=500,
    joy_rot_vel_deg_s=100,
    rot_vel_max_deg_s=100,
    trans_vel_max_mm_s=600,
    rot_acc_deg_s2=100,
    rot_decel_deg_s2=100,
    rot_kp=40,
    rot_kv=20,
    trans_acc_mm_s2=300,
    trans_decel_mm_s2=300,
    trans_kp=40,
    trans_kv=30,
)
"""What the server says of its settings; the figures are made up, but such that a client can drive with them."""

STANDING = Sip(battery_dv=128, flags=0x0002, digin=0xFF)
"""The SIP of a robot that stands: 12.8 V, sonar on, motors off."""

MOVING = Sip(moving=True, battery_dv=128, flags=0x0003, left_raw=200, right_raw=200, digin=0xFF)
"""The SIP of a robot that drives."""
