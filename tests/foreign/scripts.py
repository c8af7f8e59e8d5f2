"""What a person does with a robot, as scripts that run the same in bench time and in real time.

No step has a duration that must suffice: a host that is busy only takes longer.
"""

from __future__ import annotations


def until(client, condition, within_s=20.0):
    """Let the program run until its robot is as it should be."""
    for _ in range(round(within_s * client.line.patience / 0.1)):
        if client.sip is not None and condition(client.sip):
            return
        client.run(0.1)
    raise AssertionError(f"it never happened; the last packet was {client.sip}")


def at_speed(speed_mm_s):
    return lambda sip: abs(sip.left_mm_s - speed_mm_s) <= 10 and abs(sip.right_mm_s - speed_mm_s) <= 10


def drive_a_little(client, speed_mm_s=200, until_mm=200):
    """Connect, enable, drive, stop; the robot does what it was told and says so."""
    assert client.connect()
    assert client.name == "hilbench"
    client.enable_motors()
    client.drive(speed_mm_s)
    until(client, at_speed(speed_mm_s))
    assert client.sip.motors
    assert client.sip.moving
    until(client, lambda sip: client.x_mm > until_mm)
    client.stop()
    until(client, lambda sip: not sip.moving)
    assert client.sip.motors


def die_while_driving(client, speed_mm_s=300):
    """Connect, drive, and vanish without a word."""
    assert client.connect()
    drive_and_die(client, speed_mm_s)


def drive_and_die(client, speed_mm_s=300):
    client.enable_motors()
    client.drive(speed_mm_s)
    until(client, at_speed(speed_mm_s))
    client.die()


def find_the_robot_at_rest(client):
    """Connect as if nothing had ever happened."""
    assert client.connect()
    until(client, lambda sip: not (sip.moving or sip.motors or sip.left_mm_s or sip.right_mm_s), 0.3)
