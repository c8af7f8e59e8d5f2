"""Calling functions of the rover's committed images, without a chip around them.

The code runs on Unicorn's Cortex-M7, from the very bytes of the image. Where it would touch the board (a byte to the
host, a throttle to the motors), the function of `rover/board` is caught instead. Time is an argument there, so a test
says what it is.
"""

from __future__ import annotations

import functools
import io
import struct
from collections import deque

import pytest
from elftools.elf.elffile import ELFFile
from unicorn import UC_ARCH_ARM, UC_HOOK_CODE, UC_MODE_THUMB, Uc
from unicorn import arm_const as arm

from targets.firmware import image_path

FLASH, FLASH_BYTES = 0x08000000, 0x20000
RAM, RAM_BYTES = 0x20000000, 0x20000
SYSTEM, SYSTEM_BYTES = 0xE0000000, 0x100000
STOP = FLASH + FLASH_BYTES - 0x1000  # where calls return to
SCRATCH = RAM + RAM_BYTES - 0x8000

TICK_US = 10_000
BUSY, DONE, FAILED = range(3)
FPU_ON = 1 << 30


@functools.cache
def elf_of(name):
    """The loadable segments and the symbols of an image."""
    elf = ELFFile(io.BytesIO(image_path(name).read_bytes()))
    loads = [segment for segment in elf.iter_segments() if segment["p_type"] == "PT_LOAD" and segment["p_filesz"]]
    segments = tuple((segment["p_paddr"], segment.data()) for segment in loads)
    table = elf.get_section_by_name(".symtab")
    return segments, {s.name: s["st_value"] for s in table.iter_symbols() if s.name}


def as_float(bits):
    return struct.unpack("<f", struct.pack("<I", bits))[0]


def as_bits(value):
    return struct.unpack("<I", struct.pack("<f", value))[0]


class Code:
    """An image in memory, whose functions can be called.

    Attributes:
        uc: the core.
        symbols: addresses by name.
    """

    def __init__(self, name):
        segments, self.symbols = elf_of(name)
        self.uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB)
        self.uc.ctl_set_cpu_model(arm.UC_CPU_ARM_CORTEX_M7)
        for base, size in ((FLASH, FLASH_BYTES), (RAM, RAM_BYTES), (SYSTEM, SYSTEM_BYTES)):
            self.uc.mem_map(base, size)
        for address, data in segments:
            self.uc.mem_write(address, data)
        start, end = self.symbols["ld_data_start"], self.symbols["ld_data_end"]
        self.uc.mem_write(start, bytes(self.uc.mem_read(self.symbols["ld_data_load"], end - start)))
        self.uc.reg_write(arm.UC_ARM_REG_FPEXC, FPU_ON)

    def catch(self, name, function):
        """Let `function(code)` stand in for one of the image's; what it returns is r0, unless it is None."""
        address = self.symbols[name] & ~1

        def hook(uc, _address, _size, _user):
            value = function(self)
            if value is not None:
                uc.reg_write(arm.UC_ARM_REG_R0, value)
            uc.reg_write(arm.UC_ARM_REG_PC, uc.reg_read(arm.UC_ARM_REG_LR))

        self.uc.hook_add(UC_HOOK_CODE, hook, begin=address, end=address)

    def call(self, name, *arguments, floats=()):
        """Call a function; integers and floats have registers of their own. Return r0."""
        for register, value in zip((arm.UC_ARM_REG_R0, arm.UC_ARM_REG_R1, arm.UC_ARM_REG_R2), arguments, strict=False):
            self.uc.reg_write(register, value & 0xFFFFFFFF)
        for number, value in enumerate(floats):
            self.uc.reg_write(arm.UC_ARM_REG_S0 + number, as_bits(value))
        self.uc.reg_write(arm.UC_ARM_REG_SP, SCRATCH)
        self.uc.reg_write(arm.UC_ARM_REG_LR, STOP | 1)
        self.uc.emu_start(self.symbols[name] | 1, STOP, count=5_000_000)
        assert self.uc.reg_read(arm.UC_ARM_REG_PC) & ~1 == STOP, f"{name} does not come back"
        return self.uc.reg_read(arm.UC_ARM_REG_R0)

    def argument(self, number):
        return self.uc.reg_read(arm.UC_ARM_REG_R0 + number)

    @property
    def float_argument(self):
        return as_float(self.uc.reg_read(arm.UC_ARM_REG_S0))

    @property
    def float_result(self):
        return self.float_argument

    def bytes_at(self, address, count):
        return bytes(self.uc.mem_read(address, count))

    def put(self, data, address=SCRATCH + 0x1000):
        """Write bytes where nothing else is, and return where."""
        self.uc.mem_write(address, data)
        return address

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
        self.code = Code(name)
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
    """Makes a `Code`: ``code(image)``."""
    return Code
