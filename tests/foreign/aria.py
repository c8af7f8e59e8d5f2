"""What a program built on ARIA does on the line, as far as a robot can see it.

Source: AriaCoda, src/ArRobot.cpp and src/ArDeviceConnection.cpp, and its traffic with a robot that was played by hand.
"""

from __future__ import annotations

from . import packets as p

_BAUD_TOUR = (9600, 38400, 115200, 19200, 57600)
_MOTION_AGAIN_S = 0.5
_LOST_AFTER_S = 8.0
_DISTANCE_MM, _RANGE_MM = 0.84, 0.268  # p2dx.p: DistConvFactor, RangeConvFactor


class Aria:
    """A robot client on a line; `run` is its cycle of 100 ms."""

    def __init__(self, line):
        self.line = line
        self.name = self.config = self.sip = None
        self.sips = 0
        self.x_mm = 0.0
        self.ranges_mm = {}
        self.lost = False
        self.longest_silence_s = 0.0
        self._received = bytearray()
        self._receiver = p.AriaReceiver()
        self._motion = {}  # command number -> (value, when it was sent)
        self._sent_s = 0.0
        self._sip_s = 0.0

    # --- connecting

    def connect(self):
        """Return whether the robot could be had."""
        if self.line.serial:
            self.line.set_baud(9600)
            self.line.write(b"WMS2\r")
        self.line.flush()
        body = self._sync()
        if body is None:
            return False
        self.name, robot_class, subclass = p.identification(body)
        assert (robot_class, subclass) == ("Pioneer", "p2dx")
        self.line.wait(0.1)
        self._send(p.OPEN, 1)
        self._ask_config()
        self._send(p.BATTERYINFO, 1)
        self._send_limits()
        self._send(p.PULSE)
        self._sip_s = self.line.now_s
        return True

    def _sync(self):
        number = misses = 0
        answered = False
        for _ in range(50):
            self._send(number)
            body = self._packet(1.0 * self.line.patience)
            if body is None:
                misses += 1
                if misses == (11 if answered else 6):
                    return None
                self._shake(misses)
                continue
            answered = True
            if body[0] == p.STOPPED:
                self._close_old_session()
            elif body[0] == number == p.SYNC2:
                return body
            number = number + 1 if body[0] == number else 0
            self.line.wait(0.07)
        return None

    def _close_old_session(self):
        self._send(p.CLOSE, 1)
        until_s = self.line.now_s + 0.2
        while self.line.now_s < until_s:
            body = self._packet(until_s - self.line.now_s)
            if body is not None and body[0] == p.STOPPED:
                self._send(p.CLOSE, 1)

    def _shake(self, misses):
        if misses == 2 and self.line.serial:
            for baud in _BAUD_TOUR:
                self.line.set_baud(baud)
                self._send(p.CLOSE, 1)
                self.line.wait(0.003)
            self.line.set_baud(9600)
        if misses >= 4:
            self._send(p.OPEN, 1)

    def _ask_config(self):
        for _ in range(5):
            self._send(p.CONFIG, 1)
            until_s = self.line.now_s + 0.2
            while self.line.now_s < until_s:
                body = self._packet(until_s - self.line.now_s)
                if body is not None and body[0] == p.CONFIG_REPLY:
                    self.config = p.Config.parse(body)
                    return

    def _send_limits(self):
        if self.config is None:
            self._send(p.SETV, 2200)
            self._send(p.SETRV, 500)
            return
        self._send(p.SETV, self.config.translation_max)
        self._send(p.SETA, self.config.translation_accelerations[0])
        self._send(p.SETA, -self.config.translation_accelerations[1])
        self._send(p.SETRV, self.config.rotation_max)
        self._send(p.SETRA, self.config.rotation_accelerations[0])
        self._send(p.SETRA, -self.config.rotation_accelerations[1])

    # --- what a program asks of it

    def enable_motors(self):
        self._send(p.ENABLE, 1)

    def enable_sonar(self):
        self._send(p.SONAR, 1)

    def drive(self, speed_mm_s, turn_deg_s=0):
        self._motion = {p.VEL: (speed_mm_s, None), p.RVEL: (turn_deg_s, None)}

    def move(self, distance_mm):
        self._motion = {p.MOVE: (distance_mm, None)}

    def turn_to(self, heading_deg):
        self._motion = {p.HEAD: (heading_deg, None)}

    def stop(self):
        self._motion = {p.VEL: (0, None), p.RVEL: (0, None)}

    def run(self, duration_s):
        """Let its cycle turn."""
        until_s = self.line.now_s + duration_s
        while self.line.now_s < until_s:
            self.line.wait(0.1)
            while self._packet(0) is not None:
                pass
            silence_s = self.line.now_s - self._sip_s
            self.longest_silence_s = max(self.longest_silence_s, silence_s)
            self.lost = self.lost or silence_s > _LOST_AFTER_S
            self._send_motion()

    def _send_motion(self):
        now_s = self.line.now_s
        for number, (value, sent_s) in self._motion.items():
            if sent_s is None or self._is_due(number, value, now_s - sent_s):
                self._send(number, value)
                self._motion[number] = (value, now_s)
                self._sent_s = now_s
        if now_s - self._sent_s >= _MOTION_AGAIN_S:
            self._send(p.PULSE)
            self._sent_s = now_s

    def _is_due(self, number, value, age_s):
        if number == p.HEAD:
            return abs(p.wrapped(value - self.heading_deg, 360)) > 1
        return number in {p.VEL, p.RVEL} and age_s >= _MOTION_AGAIN_S

    @property
    def heading_deg(self):
        return self.sip.th_raw * 360 / 4096

    # --- leaving

    def disconnect(self):
        self._send(p.ENABLE, 0)
        self.line.wait(0.1)
        self._send(p.CLOSE, 1)
        self.line.wait(1.0)
        self.line.close()

    def die(self):
        self.line.close()

    # --- bytes

    def _send(self, number, argument=None):
        self.line.write(p.frame(number, argument))

    def _packet(self, within_s):
        """One packet, within so many seconds; what it says of the robot is kept."""
        until_s = self.line.now_s + within_s
        while True:
            self._received += self.line.read()
            body = self._receiver.take(self._received)
            if body is not None:
                if body[0] in {p.STOPPED, p.MOVING}:
                    self._keep(p.Sip.parse(body))
                return body
            if self.line.now_s >= until_s:
                return None
            self.line.wait(0.005)

    def _keep(self, sip):
        if self.sip is not None:
            self.x_mm += p.wrapped(sip.x_raw - self.sip.x_raw, 0x8000) * _DISTANCE_MM
        self.sip = sip
        self.sips += 1
        self._sip_s = self.line.now_s
        self.ranges_mm |= {disc: raw * _RANGE_MM for disc, raw in sip.ranges_raw.items()}
