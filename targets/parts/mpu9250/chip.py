"""The MPU-9250 as a register file and a sample clock (RM-MPU-9250A-00, PS-MPU-9250A-01).

Samples are taken at exact times: the first one a start-up time after the sensors were switched on, the others a
sample period apart. What a sample is depends on its number and its time only; so as long as nobody needs every one
(FIFO, interrupt, wake on motion, auxiliary master) only that is computed which is read.

The clock is the part's own: it goes at its own rate, and does not wait for the program. When the program starts it or
changes the sample rate, some share of the new period has gone already (`phase`). So a program that reads another
register shortly before INT_STATUS, with INT_ANYRD_2CLEAR set, sees new data only now and then: at 200 Hz and 0.2 ms
between the two, in one of 25 reads on average (RM sections 4.4, 4.23 and 4.25).

Choices where the manuals are silent: a change of a filter or a full scale acts from the next sample on, without
transients; an axis that is switched off keeps its last value; the accelerometer is ready in time for the first sample
of the gyroscope; a reset takes no time; what is read in one message is of one sample, that of the message's address
byte.
"""

from __future__ import annotations

from collections.abc import Callable

from targets.parts.mpu9250.ak8963 import Ak8963
from targets.parts.mpu9250.aux_master import EXTERNAL_BYTES, AuxMaster
from targets.parts.mpu9250.fifo import Fifo
from targets.parts.mpu9250.individual import Individual
from targets.parts.mpu9250.interrupts import FIFO_OVERFLOW, RAW_DATA_READY, WAKE_ON_MOTION, Interrupts
from targets.parts.mpu9250.model import Model
from targets.parts.mpu9250.notes import Notes
from targets.parts.mpu9250.rates import ACCEL_LSB_PER_G, Rates
from targets.parts.mpu9250.registers import LAST_ADDRESS, Reg
from targets.parts.mpu9250.sensing import Sensing

__all__ = ["Chip"]

_KEPT_NS = 120_000_000
"""How much of the past is kept: the longest delay of a filter, and what a sample may be late (choice)."""

_LATE_NS = 20_000_000
"""A sample of a slower clock is computed when it is due, for its past would be forgotten before it is read."""

_SLEEP, _CYCLE, _GYRO_STANDBY, _THERMOMETER_OFF, _RESET = 0x40, 0x20, 0x10, 0x08, 0x80
_CLOCK_STOPPED = 7
_ACCEL_OFF, _GYRO_OFF = 0x38, 0x07
_FIFO_ON, _MASTER_ON, _SPI_ONLY = 0x40, 0x20, 0x10
_FIFO_RESET, _MASTER_RESET, _SIGNALS_RESET = 0x04, 0x02, 0x01
_BYPASS = 0x02
_MOTION_ON, _MOTION_DIFFERENCE = 0x80, 0x40
_WORDS = 7
_NOTHING = (0,) * _WORDS
_OUTPUTS = range(Reg.ACCEL_XOUT_H, Reg.EXT_SENS_DATA_00)
_EXTERNALS = range(Reg.EXT_SENS_DATA_00, Reg.EXT_SENS_DATA_00 + EXTERNAL_BYTES)
_DMP = range(0x6D, 0x72)
_SLAVE_CONTROLS = (Reg.I2C_SLV0_CTRL, Reg.I2C_SLV1_CTRL, Reg.I2C_SLV2_CTRL, Reg.I2C_SLV3_CTRL)
_CLOCKED = (
    Reg.SMPLRT_DIV,
    Reg.CONFIG,
    Reg.GYRO_CONFIG,
    Reg.ACCEL_CONFIG2,
    Reg.LP_ACCEL_ODR,
    Reg.PWR_MGMT_1,
    Reg.PWR_MGMT_2,
)
_MG_PER_STEP = 4


class Chip:
    """See the module. Times never go back; one that does counts as the latest.

    Args:
        model: which of the family it is.
        sensing: what it senses.
        individual: which part it is.
        ak8963: the magnetometer behind it, if there is one.
        interrupts: its interrupt pin.
        notes: takes what is not modelled.
        phase: the share of a sample period that its clock has gone when it starts or changes for the n-th time.
    """

    def __init__(
        self,
        model: Model,
        sensing: Sensing,
        individual: Individual,
        ak8963: Ak8963 | None,
        interrupts: Interrupts,
        notes: Notes,
        *,
        phase: Callable[[int], float],
    ) -> None:
        self._model = model
        self._sensing = sensing
        self._individual = individual
        self._ak8963 = ak8963
        self._interrupts = interrupts
        self._notes = notes
        self._phase = phase
        self._clock_changes = 0
        self._now_ns = 0
        self._values = self._reset_values()
        self._master = AuxMaster(ak8963, self._values.__getitem__)
        self._fifo = Fifo(model.fifo_bytes)
        self._first_ns: int | None = None
        self._started_ns = 0
        self._period_ns = 1
        self._accel_every = 1
        self._taken = 0
        self._clock_base = 0
        self._frozen: tuple[int, bytes] | None = None
        self._computed: tuple[int, tuple[int, ...]] = (0, _NOTHING)
        self._latched_count = 0
        self._reference: tuple[int, ...] | None = None
        self._readers: dict[int, Callable[[], int]] = {
            Reg.INT_STATUS: lambda: self._interrupts.read_status(self._now_ns),
            Reg.I2C_MST_STATUS: self._master.read_status,
            Reg.I2C_SLV4_DI: lambda: self._master.slave_4_in,
            Reg.FIFO_COUNTH: self._latch_count,
            Reg.FIFO_COUNTL: lambda: self._latched_count & 0xFF,
            Reg.FIFO_R_W: self._fifo.take,
        }

    # --- time

    @property
    def next_event_ns(self) -> int | None:
        """When its interrupt pin may change next; None if it will not by itself."""
        times_ns = [self._interrupts.pulse_end_ns]
        wanted = self._interrupts.enabled & (RAW_DATA_READY | WAKE_ON_MOTION | FIFO_OVERFLOW)
        if wanted and not self._interrupts.waits_for_reader:
            times_ns.append(self._next_sample_ns)
        return min((ns for ns in times_ns if ns is not None), default=None)

    def advance(self, now_ns: int) -> None:
        """Let time pass: take the samples that are due, at their times."""
        self._now_ns = now_ns = max(now_ns, self._now_ns)
        if not self._needs_every_sample:
            self._skip_to(now_ns)
        while (due_ns := self._next_due_ns()) is not None and due_ns <= now_ns:
            if due_ns == self._interrupts.pulse_end_ns:
                self._interrupts.end_pulse(due_ns)
            else:
                self._take_sample(due_ns)
        if self._ak8963 is not None:
            self._ak8963.advance(now_ns)

    def keep_up(self, now_ns: int) -> None:
        """As `advance`, and forget the past that nobody can ask for any more."""
        self.advance(now_ns)
        if self._period_ns > _LATE_NS:
            self._words(self._taken)
        self._sensing.forget(now_ns - _KEPT_NS)

    def power_on(self, now_ns: int) -> None:
        """Supply is there."""
        self._now_ns = max(now_ns, self._now_ns)
        self._reset()

    @property
    def _needs_every_sample(self) -> bool:
        control = self._values[Reg.USER_CTRL]
        return bool(
            self._interrupts.enabled
            or (control & _FIFO_ON and self._fifo_wanted)
            or control & _MASTER_ON
            or self._values.get(Reg.ACCEL_INTEL_CTRL, 0) & _MOTION_ON
        )

    @property
    def _next_sample_ns(self) -> int | None:
        return None if self._first_ns is None else self._first_ns + (self._taken - self._clock_base) * self._period_ns

    def _next_due_ns(self) -> int | None:
        times_ns = (self._next_sample_ns, self._interrupts.pulse_end_ns)
        return min((ns for ns in times_ns if ns is not None), default=None)

    def _skip_to(self, now_ns: int) -> None:
        """Count the samples until then without taking them."""
        next_ns = self._next_sample_ns
        if next_ns is not None and next_ns <= now_ns:
            self._taken += (now_ns - next_ns) // self._period_ns + 1
            self._interrupts.happen(RAW_DATA_READY, now_ns)

    # --- samples, numbered from 1 since power-on

    def _take_sample(self, at_ns: int) -> None:
        self._taken += 1
        if self._values[Reg.USER_CTRL] & _MASTER_ON and self._master.visit_all(self._taken, at_ns):
            self._values[Reg.I2C_SLV4_CTRL] &= 0x7F
        self._interrupts.happen(RAW_DATA_READY | self._motion(), at_ns)
        if self._values[Reg.USER_CTRL] & _FIFO_ON and self._fifo_wanted:
            self._fifo.keeps_old = bool(self._values[Reg.CONFIG] & 0x40)
            if self._fifo.put(self._packet()):
                self._interrupts.happen(FIFO_OVERFLOW, at_ns)

    def _words(self, number: int) -> tuple[int, ...]:
        """What a sample has measured; axes that are off have what they had."""
        known, held = self._computed
        if number == known or self._first_ns is None:
            return held
        since = number - 1 - self._clock_base
        at_ns, accel_ns = (
            self._first_ns + count * self._period_ns for count in (since, since - since % self._accel_every)
        )
        fresh = self._sensing.words(number, at_ns, accel_ns)
        off = self._axes_off
        words = tuple(
            old if off >> index & 1 else new for index, (old, new) in enumerate(zip(held, fresh, strict=True))
        )
        self._computed = number, words
        return words

    @property
    def _axes_off(self) -> int:
        """Bits of the words that do not move: PWR_MGMT_2 counts its axes from the other end."""
        off = self._values[Reg.PWR_MGMT_2]
        found = sum(
            1 << index for index, bit in enumerate((5, 4, 3, None, 2, 1, 0)) if bit is not None and off >> bit & 1
        )
        if self._values[Reg.PWR_MGMT_1] & _THERMOMETER_OFF:
            found |= 0x08
        return found if self._gyro_on else found | 0x70

    def _motion(self) -> int:
        """Wake on motion: an axis differs from the sample before, or from the first one, by more than the threshold."""
        control = self._values.get(Reg.ACCEL_INTEL_CTRL, 0)
        if not control & _MOTION_ON:
            return 0
        accel = self._words(self._taken)[:3]
        before = self._reference or accel
        if self._reference is None or control & _MOTION_DIFFERENCE:
            self._reference = accel
        counts_per_g = ACCEL_LSB_PER_G[self._values[Reg.ACCEL_CONFIG] >> 3 & 3]
        threshold = self._values[Reg.WOM_THR] * _MG_PER_STEP * counts_per_g / 1000
        moved = any(abs(new - old) > threshold for new, old in zip(accel, before, strict=True))
        return WAKE_ON_MOTION if moved else 0

    # --- FIFO

    @property
    def _fifo_wanted(self) -> int:
        """FIFO_EN, and above it the bit for slave 3."""
        return self._values[Reg.FIFO_EN] | (self._values[Reg.I2C_MST_CTRL] & 0x20) << 3

    def _packet(self) -> bytes:
        """What a sample puts into the FIFO, in the order of the registers."""
        wanted, words = self._fifo_wanted, self._words(self._taken)
        chosen = [*words[:3]] if wanted & 0x08 else []
        chosen += [word for bit, word in zip((0x80, 0x40, 0x20, 0x10), words[3:], strict=True) if wanted & bit]
        external = (self._master.chunk(number) for number, bit in enumerate((0x01, 0x02, 0x04, 0x100)) if wanted & bit)
        return _bytes_of(chosen) + b"".join(external)

    def _latch_count(self) -> int:
        """FIFO_COUNTH is read: that latches both bytes (RM section 4.36)."""
        self._latched_count = self._fifo.count
        return self._latched_count >> 8

    # --- registers

    @property
    def bypassed(self) -> bool:
        """The pins of the auxiliary bus are joined to those of the outer one."""
        return bool(self._values[Reg.INT_PIN_CFG] & _BYPASS and not self._values[Reg.USER_CTRL] & _MASTER_ON)

    @property
    def deaf(self) -> bool:
        """USER_CTRL has switched the I2C interface off."""
        return bool(self._values[Reg.USER_CTRL] & _SPI_ONLY)

    def freeze(self, now_ns: int) -> None:
        """A message begins: the output registers stay as they are."""
        self.advance(now_ns)
        self._frozen = self._taken, self._master.external

    def thaw(self, now_ns: int) -> None:
        """The message is over."""
        self._frozen = None
        self.advance(now_ns)

    def read(self, address: int, now_ns: int) -> int:
        """Read a register, with everything that a read does."""
        self.advance(now_ns)
        value = self._read(address)
        if address != Reg.INT_STATUS:
            self._interrupts.any_read(self._now_ns)
        return value

    def _read(self, address: int) -> int:
        if address in _OUTPUTS:
            word, low = divmod(address - Reg.ACCEL_XOUT_H, 2)
            number = self._taken if self._frozen is None else self._frozen[0]
            return self._words(number)[word] >> (0 if low else 8) & 0xFF
        if address in _EXTERNALS:
            external = self._master.external if self._frozen is None else self._frozen[1]
            return external[address - Reg.EXT_SENS_DATA_00]
        if address in _DMP:
            self._notes.note("the digital motion processor is not modelled: its registers read 0")
        reader = self._readers.get(address)
        return reader() if reader else self._values.get(address, 0)

    def write(self, address: int, value: int, now_ns: int) -> None:
        """Write a register, with everything that a write does."""
        self.advance(now_ns)
        register = self._model.registers.get(address)
        if register is None or not register.writable | register.acts:
            self._note_lost(address)
            return
        self._words(self._taken)
        changed = (self._values.get(address, 0) ^ value) & register.writable
        self._values[address] = self._values.get(address, 0) & ~register.writable | value & register.writable
        self._act(address, value, changed)

    def _act(self, address: int, value: int, changed: int) -> None:
        if address == Reg.PWR_MGMT_1 and value & _RESET:
            self._reset()
        elif address in _CLOCKED and changed:
            self._set_clock()
        elif address in (Reg.INT_PIN_CFG, Reg.INT_ENABLE):
            self._configure_interrupts()
        elif address == Reg.USER_CTRL:
            self._control(value)
        elif address == Reg.FIFO_R_W:
            self._fifo.put(bytes((value,)))
        elif address == Reg.ACCEL_INTEL_CTRL:
            self._reference = None
        elif address in _SLAVE_CONTROLS:
            self._master.controls_changed()
        self._configure_sensing()
        self._note_absent(address, value)

    def _reset(self) -> None:
        self._interrupts.reset(self._now_ns)
        self._values |= self._reset_values()
        self._fifo.clear()
        self._master.reset()
        self._reference = None
        self._computed = self._taken, _NOTHING
        self._first_ns = None
        self._set_clock()
        self._configure_sensing()

    def _reset_values(self) -> dict[int, int]:
        found = {address: register.reset for address, register in self._model.registers.items()}
        return {**found, **self._individual.factory}

    def _control(self, value: int) -> None:
        if value & _FIFO_RESET:
            self._fifo.clear()
        if value & _MASTER_RESET:
            self._master.reset()
        if value & _SIGNALS_RESET:
            self._computed = self._taken, _NOTHING

    def _configure_interrupts(self) -> None:
        self._interrupts.configure(self._values[Reg.INT_PIN_CFG], self._values[Reg.INT_ENABLE], self._now_ns)

    def _configure_sensing(self) -> None:
        rates = self._rates()
        self._accel_every = max(1, rates.accel_ns // rates.sample_ns)
        self._sensing.configure(self._values, rates)

    # --- sample clock

    @property
    def _gyro_on(self) -> bool:
        power = self._values[Reg.PWR_MGMT_1]
        return not power & (_GYRO_STANDBY | _CYCLE) and self._values[Reg.PWR_MGMT_2] & _GYRO_OFF != _GYRO_OFF

    @property
    def _runs(self) -> bool:
        power = self._values[Reg.PWR_MGMT_1]
        accel_on = self._values[Reg.PWR_MGMT_2] & _ACCEL_OFF != _ACCEL_OFF
        return not power & _SLEEP and power & 7 != _CLOCK_STOPPED and (self._gyro_on or accel_on)

    def _rates(self) -> Rates:
        low_power = bool(self._values[Reg.PWR_MGMT_1] & _CYCLE)
        return self._model.rates(self._values, gyro_on=self._gyro_on, low_power=low_power)

    def _set_clock(self) -> None:
        """Start, stop or restart the sample clock, if that is what the registers ask for now."""
        period_ns = max(1, round(self._rates().sample_ns / (1 + self._individual.clock_error)))
        if self._runs and self._first_ns is not None and period_ns == self._period_ns:
            return
        self._clock_changes += 1
        gone_ns = int(self._phase(self._clock_changes) * period_ns)
        if not self._runs:
            first_ns: int | None = None
        elif self._first_ns is None:
            self._started_ns = self._now_ns + self._model.start_ns(self._gyro_on)
            first_ns = self._started_ns + gone_ns
        else:
            first_ns = max(self._now_ns + period_ns - gone_ns, self._started_ns)
        self._first_ns, self._period_ns, self._clock_base = first_ns, period_ns, self._taken

    # --- what is lost or missing

    def _note_lost(self, address: int) -> None:
        if address in _DMP:
            self._notes.note("the digital motion processor is not modelled: what is written to its registers is lost")
        elif address in self._model.registers:
            self._notes.note(f"{self._model.registers[address].name} is read-only: what is written there is lost")
        else:
            self._notes.note(f"register 0x{address & LAST_ADDRESS:02X} is reserved: what is written there is lost")

    def _note_absent(self, address: int, value: int) -> None:
        for where, mask, text in _ABSENT:
            if address == where and value & mask:
                self._notes.note(text)


_ABSENT = (
    (Reg.CONFIG, 0x38, "EXT_SYNC_SET: the pin FSYNC is not modelled, and reads low"),
    (Reg.INT_ENABLE, 0x08, "FSYNC_INT_EN: the pin FSYNC is not modelled"),
    (Reg.USER_CTRL, 0x88, "the digital motion processor is not modelled: DMP_EN and DMP_RST do nothing"),
    (Reg.USER_CTRL, _SPI_ONLY, "I2C_IF_DIS: the SPI interface is not modelled, the sensor is deaf from now on"),
    (Reg.I2C_MST_CTRL, 0x40, "WAIT_FOR_ES: transfers of the auxiliary bus take no time here, so nothing waits"),
)


def _bytes_of(words: list[int]) -> bytes:
    return b"".join(word.to_bytes(2, "big", signed=True) for word in words)
