"""What Player's p2os driver and its descendant for ROS do on the line, as far as a robot can see it.

Sources: Player, server/drivers/mixed/p2os/p2os.cc; allenh1/p2os, p2os_driver/src/p2os.cpp, p2osnode.cpp, p2os_ptz.cpp.
"""

from __future__ import annotations

import struct

from . import packets as p

_BAUDS = (9600, 38400, 19200, 115200, 57600)
_PAUSE_S = 0.2
_PATIENCE_S = 5.0  # a read that waits longer than this would wait for ever: the program hangs
_DISTANCE_MM, _RANGE_MM = 0.84, 0.268


class FrozenError(Exception):
    """The program waits in a blocking read for a packet that does not come."""


class PlayerDriver:
    """Player's driver; by default it gives the speed of each wheel."""

    receiver = p.PlayerReceiver

    def __init__(self, line):
        self.line = line
        self.name = self.sip = None
        self.sips = 0
        self.x_mm = self.thrown_away = 0
        self.ranges_mm = {}
        self.longest_silence_s = 0.0
        self._wanted = (0, 0)
        self._received = bytearray()
        self._receiver = self.receiver()
        self._x_raw = None

    # --- connecting

    def connect(self):
        """Return whether the robot could be had."""
        if self.line.serial:
            self.line.set_baud(_BAUDS[0])
        self.line.flush()
        body = self._sync()
        if body is None:
            return False
        self.name, robot_class, subclass = p.identification(body)
        assert (robot_class.lower(), subclass.lower()) == ("pioneer", "p2dx")
        for number in (p.OPEN, p.PULSE):
            self._send(number)
            self.line.wait(_PAUSE_S)
        self.set_up()
        return True

    def _sync(self):
        number, more_tries, bauds, sent_close, blocking = 0, 3, list(_BAUDS[1:]), False, False
        while number <= p.SYNC2:
            self._send(number)
            blocking = blocking or number == p.SYNC1
            self.line.wait(_PAUSE_S if number else 2 * _PAUSE_S)
            body = self._blocking_read() if blocking else self._one_shot_read()
            if body is None and more_tries >= 0:
                more_tries -= 1
                self.line.wait(_PAUSE_S)
                continue
            if body is None:
                if not self._next_baud(bauds):
                    return None
                more_tries = 3
                continue
            if body[0] <= p.SYNC2:
                number = body[0] + 1
            elif not sent_close:
                self._send(p.CLOSE)
                sent_close, number = True, 0
                self.line.wait(2 * _PAUSE_S)
                self._flush()
            self.line.wait(_PAUSE_S)
        return body

    def _next_baud(self, bauds):
        if not bauds:
            return False
        try:
            self.line.set_baud(bauds.pop(0))
        except OSError:
            return False
        self._flush()
        return True

    def set_up(self):
        self._send_receive(None)
        self._send_receive(p.SONAR, 0)
        # The first who subscribes to the wheels: motors off, counters to zero.
        self._send_receive(p.ENABLE, 0)
        self._zero()

    def _zero(self):
        """Zero the counters, with an argument cut short."""
        self._x_raw = self.x_mm = 0
        self._send_receive(p.SETO, b"\x3b")

    # --- what a program asks of it

    def enable_motors(self):
        self._send_receive(p.ENABLE, 1)

    def enable_sonar(self):
        self._send_receive(p.SONAR, 1)

    def drive(self, speed_mm_s, turn_deg_s=0):
        self._wanted = (speed_mm_s, turn_deg_s)

    def stop(self):
        self.drive(0)

    def run(self, duration_s):
        """Let its loop turn, while a program asks for the same speed five times a second."""
        until_s = again_s = self.line.now_s
        until_s += duration_s
        while self.line.now_s < until_s:
            if self.line.now_s >= again_s:
                again_s = self.line.now_s + 0.2
                speed, turn = self._wanted
                half = turn * 3.14159 / 180 / (2 * 0.0056)  # RobotParams: DiffConvFactor of a p2dx
                wheels = (round((speed + half) / 20), round((speed - half) / 20))  # right first
                self._send_receive(p.VEL2, b"\x3b" + struct.pack("<bb", *wheels))
            self._send_receive(None)

    # --- leaving

    def disconnect(self):
        for number in (p.STOP, p.CLOSE):
            self._send(number)
            self.line.wait(_PAUSE_S)
        self.line.close()

    def die(self):
        self.line.close()

    # --- bytes

    def _send(self, number, argument=None):
        self.line.write(p.frame(number, argument))

    def _send_receive(self, number, argument=None):
        """One packet is read, however long it takes, for every command sent and for every turn of the loop."""
        if number is not None:
            self._send(number, argument)
        body = self._blocking_read()
        if 0x30 <= body[0] <= 0x34:
            self._keep(p.Sip.parse(body))

    def _one_shot_read(self):
        """What is not there in one piece is lost."""
        self._received += self.line.read()
        body = self._receiver.take(self._received)
        if body is None:
            self._received.clear()
        return body

    def _blocking_read(self):
        since_s = self.line.now_s
        while True:
            self._received += self.line.read()
            body = self._receiver.take(self._received)
            waited_s = self.line.now_s - since_s
            self.longest_silence_s = max(self.longest_silence_s, waited_s)
            if body is not None:
                return body
            if waited_s > _PATIENCE_S * self.line.patience:
                raise FrozenError
            self.line.wait(0.005)

    def _flush(self):
        self.line.flush()
        self._received.clear()

    def _keep(self, sip):
        """Its odometry: 12 bits, every step rounded to whole millimetres, steps beyond 100 mm thrown away."""
        raw = (sip.x_raw & 0xEFFF) % 4096
        if self._x_raw is not None:
            step_mm = round(p.wrapped(raw - self._x_raw, 4096) * _DISTANCE_MM)
            if abs(step_mm) <= 100:
                self.x_mm += step_mm
            else:
                self.thrown_away += 1
        self._x_raw = raw
        self.sip = sip
        self.sips += 1
        self.ranges_mm |= {disc: reading * _RANGE_MM for disc, reading in sip.ranges_raw.items()}


class RosDriver(PlayerDriver):
    """The driver for ROS: serial only, VEL and RVEL only when they change or are two seconds old, a camera at AUX1."""

    receiver = p.RosReceiver

    def __init__(self, line):
        super().__init__(line)
        self._sent = (0, 0)
        self._sent_s = line.now_s
        self.longest_without_command_s = 0.0
        self._last_command_s = line.now_s

    def set_up(self):
        self._send_receive(p.SONAR, 0)
        self._send_receive(p.SONAR, 1)
        for order in ("A031", "9030", "5830", "5233", "5233", "5233", "62"):
            self._camera(b"\xff\x30\x30\x00" + bytes.fromhex(order) + b"\xef")
            self.line.wait(0.3)
        self._zero()

    def run(self, duration_s):
        until_s = self.line.now_s + duration_s
        while self.line.now_s < until_s:
            age_s = self.line.now_s - self._sent_s
            if self._wanted != self._sent or (age_s > 2.0 and any(self._sent)):
                self._sent, self._sent_s = self._wanted, self.line.now_s
                self._send_receive(p.VEL, self._sent[0])
                self._send_receive(p.RVEL, self._sent[1])
            self._send_receive(None)

    def disconnect(self):
        for order in ("62", "B330", "A030"):
            self._camera(b"\xff\x30\x30\x00" + bytes.fromhex(order) + b"\xef")
            self.line.wait(0.3)
        super().disconnect()

    def _camera(self, order):
        self._send_receive(p.GETAUX, 0)
        self._send_receive(p.TTY2, b"\x2b" + bytes((len(order),)) + order)

    def _send(self, number, argument=None):
        now_s = self.line.now_s
        if self.sip is not None and self.sip.moving:
            self.longest_without_command_s = max(self.longest_without_command_s, now_s - self._last_command_s)
        self._last_command_s = now_s
        super()._send(number, argument)
