"""What stands in a bench file, as it is written; `hilbench.benchfile.reader` reads it and finds out what it means."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

import msgspec
from msgspec import UNSET, UnsetType

from hilbench.benchfile.fault_entries import FaultEntry
from worlds import default_physics

if TYPE_CHECKING:
    from hilbench.links import LineSettings


class World(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The world around the robot.

    Attributes:
        scene: name of a built-in scene, or the path of a scene file, relative to the bench file.
        vehicle: the name of the vehicle in it.
        physics: ``bullet`` (PyBullet), ``mujoco``, or ``plane`` for an endless floor without rays and contacts. The
            default is ``bullet`` if PyBullet is installed, else ``mujoco``.
        step_hz: physics steps per second.
    """

    scene: str = "empty"
    vehicle: str = "pioneer-2dx"
    physics: Literal["bullet", "mujoco", "plane"] = msgspec.field(default_factory=default_physics)
    step_hz: Annotated[int, msgspec.Meta(ge=50, le=10_000)] = 240


class StrapsEntry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Boot jumpers whose setting differs from the delivered board.

    Attributes:
        boot0: 0 boots from main flash; 1 from system memory or SRAM, by boot1.
        boot1: with boot0 at 1, 0 is system memory and 1 is SRAM.
    """

    boot0: Literal[0, 1] | UnsetType = UNSET
    boot1: Literal[0, 1] | UnsetType = UNSET


class TargetEntry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A target: a behavioural model, or an emulated board that runs firmware.

    Attributes:
        model: the name of the behavioural model: that of a system, or the name of a protocol that has a model.
        settings: settings of the model that differ from their defaults, by name.
        board: the emulated board: the name of a built-in one, or the path of a board file, relative to the bench file.
        chip: part number of the chip, if it differs from that of the board.
        firmware: the image that would be flashed (ELF, Intel HEX or raw binary), relative to the bench file.
        base: load address of a raw binary; by default the beginning of flash.
        timing: how many cycles instructions take: ``flat`` (one mean figure and the flash's wait states), or
            ``table`` (by instruction; more exact and slower).
        skip_idle: whether waiting loops are skipped; this does not change what the firmware does.
        straps: boot jumpers whose setting differs from the delivered board.
        programs: other images for the same board, by name; a suite selects them by these names.
    """

    model: str | UnsetType = UNSET
    settings: dict[str, Any] = {}
    board: str | UnsetType = UNSET
    chip: str | UnsetType = UNSET
    firmware: str | UnsetType = UNSET
    base: Annotated[int, msgspec.Meta(ge=0, le=0xFFFF_FFFF)] | UnsetType = UNSET
    timing: Literal["flat", "table"] = "flat"
    skip_idle: bool = True
    straps: StrapsEntry = StrapsEntry()
    programs: dict[str, str] = {}


class BusPinsEntry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The two wires of an I2C bus at any two pins: for an I2C interface, or for firmware that drives the pins itself.

    Attributes:
        scl: the clock, ``NAME.PIN`` of a board.
        sda: the data, ``NAME.PIN`` of the same board.
    """

    scl: str
    sda: str


class PartEntry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A part between boards and the world, or between a board and a robot.

    Attributes:
        kind: its kind, such as ``distance-switch``, ``encoder-3bit``, ``motor-code``, ``gamepad``.
        pins: the pin of each terminal: ``NAME.PIN`` of a board, ``3v3`` or ``gnd``.
        signals: the source or sink of each quantity: ``world.SIGNAL``, or ``NAME.QUANTITY`` of another part.
        buses: the I2C or SPI bus of each bus end: ``NAME.I2C1`` of a board, or for I2C two pins.
        settings: settings of the part that differ from their defaults, by name.
    """

    kind: str
    pins: dict[str, str] = {}
    signals: dict[str, str] = {}
    buses: dict[str, str | BusPinsEntry] = {}
    settings: dict[str, Any] = {}


class LinkEntry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A serial line between two ends.

    Attributes:
        ends: the two ends. ``peer`` is the end of the checker or of a served client; with several lines they are
            ``peer.LINE``, with names of your choice. ``NAME.host`` is the line of a model with one line, else
            ``NAME.LINE``, such as ``NAME.usart2``. ``NAME.usart1`` is that of a board, ``NAME.uart2`` a serial end of a
            part.
        baud: rate in bit/s of an end that is not an emulated USART. The default is the usual rate of the model; for
            ``peer``, and for a part without a rate of its own, it is the rate of the USART.
        protocol: the protocol between ``peer`` and a board, by its name (``hilbench protocols``); ``peer`` in a suite
            then has messages. A model has its own protocol.
    """

    ends: tuple[str, str]
    baud: Annotated[int, msgspec.Meta(ge=300, le=4_500_000)] | UnsetType = UNSET
    protocol: str | UnsetType = UNSET


class WireEntry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A wire between pins.

    Attributes:
        ends: its ends: ``NAME.PIN`` of a board, with the name of the port pin (``PA0``) or the label on the board
            (``A0``); ``NAME.TERMINAL`` of a part; ``3v3`` and ``gnd``.
    """

    ends: Annotated[tuple[str, ...], msgspec.Meta(min_length=2)]


class PortEntry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How a real port is opened that is used instead of a target, and how its board is reset.

    A hook is a list of steps: ``dtr on``, ``rts off``, ``dtr off rts on`` (both at once), ``break 250ms``, ``wait
    100ms``, ``run COMMAND`` (a relay, a probe).

    Attributes:
        dtr: level of DTR while the port is open, true for asserted; by default it is left as it is.
        rts: the same for RTS.
        parity: ``N``, ``E`` or ``O``.
        stop_bits: 1 or 2.
        boot: the hook that is run once, after the port was opened for the first time.
        reset: the hook that is run before each case.
    """

    dtr: bool | UnsetType = UNSET
    rts: bool | UnsetType = UNSET
    parity: Literal["N", "E", "O"] = "N"
    stop_bits: Literal[1, 2] = 1
    boot: tuple[str, ...] = ()
    reset: tuple[str, ...] = ()

    @property
    def settings(self) -> LineSettings:
        """How the port is opened where the command line does not say."""
        from hilbench.links import LineSettings  # and pyserial, which whoever reads a bench file need not have

        dtr, rts = (None if level is UNSET else level for level in (self.dtr, self.rts))
        return LineSettings(dtr=dtr, rts=rts, parity=self.parity, stop_bits=self.stop_bits)


class BenchModel(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The top level of a bench file.

    Attributes:
        version: version of this format.
        targets: the targets, by names of your choice.
        parts: the parts between boards and the world, by names of your choice.
        world: the world of a model, or of the vehicle that parts drive.
        links: the serial lines.
        wires: the wires between pins.
        faults: the faults to inject into the links.
        stimuli: what is applied to the boards from outside, and when: lines such as ``1s:PC13=0`` (docs/stimuli.md).
        port: how a real port is opened that is used instead of a target.
        lockstep_us: how far one of several wired boards may run ahead of the others, in microseconds. An edge from one
            to another is late by this much at most. Frames on lines between boards are never late.
        suites: the suites that ``hilbench check`` runs by default: names of shipped suites, or paths of suite files or
            folders, relative to the bench file.
        variants: other benches that cases of these suites use, by name: paths of bench files, relative to this one.
        plugins: files that bring protocols or systems, relative to the bench file. Their code runs when the bench is
            opened.
    """

    version: Literal[1]
    targets: dict[str, TargetEntry]
    parts: dict[str, PartEntry] = {}
    world: World = World()
    links: tuple[LinkEntry, ...] = ()
    wires: tuple[WireEntry, ...] = ()
    faults: tuple[FaultEntry, ...] = ()
    stimuli: tuple[str, ...] = ()
    port: PortEntry = PortEntry()
    lockstep_us: Annotated[int, msgspec.Meta(ge=1, le=1000)] = 20
    suites: tuple[str, ...] = ()
    variants: dict[str, str] = {}
    plugins: tuple[str, ...] = ()
