"""Calling functions of the rover's committed images, without a chip around them.

The code runs on Unicorn's Cortex-M7, from the very bytes of the image. Where it would touch the board (a byte to the
host, a throttle to the motors), the function of `rover/board` is caught instead. Time is an argument there, so a test
says what it is.
"""

from __future__ import annotations

import struct
from collections import deque

import pytest

from tests.targets.firmware.calls import Code

TICK_US = 10_000
BUSY, DONE, FAILED = range(3)


class RoverCode(Code):
    """An image of the rover."""

    @property
    def quaternion(self):
        """The attitude as it stands in memory: x, y, z, w."""
        w, *xyz = struct.unpack("<4f", self.bytes_at(self.symbols["attitude"], 16))
        return *xyz, w


class Slave:
    """The I2C bus: registers of devices by address. Who is not there refuses; a hanging bus never ends a transfer.

    Attributes:
        devices: values of registers, by number, by address of the device.
        carry_out: does a transfer otherwise: (address, register, count, value or None) -> bytes, or None if refused.
        hanging: see above.
        recovered: how often the program has let go of the bus and begun anew.
        pending: a transfer has ended, and the program does not know yet.
    """

    def __init__(self):
        self.devices = {}
        self.carry_out = self._from_registers
        self.hanging = False
        self.recovered = 0
        self.pending = False
        self._state = DONE

    def read(self, code):
        address, reg, to, count = (code.argument(number) for number in range(4))
        found = self._begin(address, reg, count, None)
        if found is not None:
            code.put(found, to)

    def write(self, code):
        address, reg, value = (code.argument(number) for number in range(3))
        self._begin(address, reg, 0, value)

    def state(self, _code):
        self.pending = False
        return self._state

    def recover(self, _code):
        self.recovered += 1
        self._state = FAILED

    def _begin(self, address, reg, count, value):
        if self.hanging:
            self._state = BUSY
            return None
        found = self.carry_out(address, reg, count, value)
        self._state = FAILED if found is None else DONE
        self.pending = True
        return found

    def _from_registers(self, address, reg, count, value):
        device = self.devices.get(address)
        if device is None:
            return None
        if value is not None:
            device[reg] = value
        return bytes(device.get(reg + number, 0) for number in range(count))


def _nothing(_code):
    return None


class Rover:
    """The rover's program on a time base: bytes in, frames out.

    Attributes:
        sent: what it has sent and was not fetched yet.
        motors: throttles as they reach the pins, left and right.
        leds: by number.
        slave: the I2C bus.
        now_us: the time.
        tick: the next tick.
    """

    def __init__(self, name="rover", *, at_us=0, sensors=True):
        self.code = RoverCode(name)
        self.sent = bytearray()
        self.motors = [0.0, 0.0]
        self.leds = [False, False, False]
        self.slave = Slave()
        self.now_us = at_us
        self.tick = 0
        self._epoch_us = at_us
        self._link, self._gps = deque(), deque()
        self._catch_board()
        self._sensors = sensors
        if not sensors:  # neither good nor bad: STATUS stays 0
            self._catch(dict.fromkeys(("imu_tick", "imu_poll", "gps_tick"), _nothing))
        self.code.call("rover_start")
        self.run(0)

    def _catch(self, functions):
        """Let these stand in for functions of the image, as far as it has them."""
        for name, function in functions.items():
            if name in self.code.symbols:
                self.code.catch(name, function)

    def _catch_board(self):
        slave = self.slave
        self._catch(
            {
                "link_get": lambda code: self._get(code, self._link),
                "link_waiting": lambda _code: len(self._link),
                "link_send": self._send,
                "gps_line_start": _nothing,
                "gps_line_get": lambda code: self._get(code, self._gps),
                "motors_put": self._put_motor,
                "led_put": lambda code: self._put_led(code.argument(0), bool(code.argument(1))),
                "led_toggle": lambda code: self._put_led(code.argument(0), not self.leds[code.argument(0)]),
                "i2c_start": _nothing,
                "i2c_read": slave.read,
                "i2c_write": slave.write,
                "i2c_state": slave.state,
                "i2c_recover": slave.recover,
            }
        )

    def _get(self, code, queue):
        if not queue:
            return 0
        code.put(bytes((queue.popleft(),)), code.argument(0))
        return 1

    def _send(self, code):
        self.sent += code.bytes_at(code.argument(0), code.argument(1))

    def _put_motor(self, code):
        self.motors[code.argument(0)] = code.float_argument

    def _put_led(self, number, on):
        self.leds[number] = on

    def _due_us(self):
        return self._epoch_us + self.tick * TICK_US

    def run(self, seconds):
        """Let time pass, with all ticks that fall into it."""
        until_us = self.now_us + round(seconds * 1e6)
        while self._due_us() <= until_us:
            self.now_us = self._due_us()
            self.code.call("rover_tick", self.tick, self.now_us)
            self.tick += 1
            while self._sensors and self.slave.pending:
                self.poll()
        self.now_us = until_us
        return self

    def poll(self):
        self.code.call("rover_poll", self.now_us)

    def write(self, data):
        """Bytes from the host, now."""
        self._link += data
        self.poll()
        return self

    def hear(self, text):
        """Bytes from the GPS receiver, now."""
        self._gps += text.encode()
        self.poll()
        return self

    def turn(self, wheel):
        """A slot passes a tachometer, now."""
        self.code.call("wheels_edge", wheel, self.now_us)

    def fetch(self):
        """What was sent since the last call."""
        data = bytes(self.sent)
        self.sent.clear()
        return data


@pytest.fixture
def rover():
    """Makes a `Rover`: ``rover(image, at_us=...)``."""
    return Rover


@pytest.fixture(scope="session")
def rover_factory():
    """The same for property tests, which may use no fixture that is made anew for each test."""
    return Rover


@pytest.fixture
def code():
    """Makes a `RoverCode`: ``code(image)``."""
    return RoverCode
