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
    """Where the robot stands.

    Attributes:
        scene: name of a built-in scene, or the path of a scene file, seen from the bench file.
        vehicle: the body in it: that of a system, by its name.
        physics: ``bullet`` (PyBullet), ``mujoco``, or ``plane`` for an endless floor without rays and contacts; where
            it is not said, ``bullet`` if PyBullet is installed, else ``mujoco``.
        step_hz: physics steps per second.
    """

    scene: str = "empty"
    vehicle: str = "pioneer-2dx"
    physics: Literal["bullet", "mujoco", "plane"] = msgspec.field(default_factory=default_physics)
    step_hz: Annotated[int, msgspec.Meta(ge=50, le=10_000)] = 240


class StrapsEntry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Boot jumpers that are set otherwise than the board is delivered.

    Attributes:
        boot0: 0 boots from main flash; 1 from system memory or SRAM, by boot1.
        boot1: with boot0 at 1, 0 is system memory and 1 is SRAM.
    """

    boot0: Literal[0, 1] | UnsetType = UNSET
    boot1: Literal[0, 1] | UnsetType = UNSET


class TargetEntry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What answers at the far end of a link: a behavioural model, or an emulated board that runs firmware.

    Attributes:
        model: the behavioural model of it: one of a system, or that of a protocol which a plug-in brings, by its name.
        settings: what differs from a standard model, by the names that the model has for it.
        board: the emulated board: the name of a built-in one, or the path of a board file, seen from the bench file.
        chip: part number of the chip that the board has instead of its own, as boards are sold with several.
        firmware: the image that would be flashed (ELF, Intel HEX or raw binary), seen from the bench file.
        base: where a raw binary belongs, if not at the beginning of flash.
        timing: how many cycles instructions take: ``flat`` (one mean figure and the flash's wait states), or
            ``table`` (by instruction; exacter and slower).
        skip_idle: whether waiting loops are skipped; what the firmware does is the same.
        straps: boot jumpers that are set otherwise than the board is delivered.
        programs: other images for the same board, by what they do; a suite that checks them asks for them by name.
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
    """The two wires of an I2C bus at pins that the program moves bit by bit, or that any I2C interface may carry.

    Attributes:
        scl: the clock, ``NAME.PIN`` of a board.
        sda: the data, ``NAME.PIN`` of the same board.
    """

    scl: str
    sda: str


class PartEntry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A part between boards and the world, or between a board and a robot.

    Attributes:
        kind: what it is, such as ``distance-switch``, ``encoder-3bit``, ``motor-code``, ``gamepad``.
        pins: what its terminals are wired to, by their names: ``NAME.PIN`` of a board, ``3v3`` or ``gnd``.
        signals: what its quantities are, by their names: ``world.SIGNAL``, or ``NAME.QUANTITY`` of another part.
        buses: the I2C and SPI buses that it is soldered to, by its names for its ends: ``NAME.I2C1`` of a board, or
            for I2C two pins.
        settings: what differs from a standard part, by the names that its kind has for it.
    """

    kind: str
    pins: dict[str, str] = {}
    signals: dict[str, str] = {}
    buses: dict[str, str | BusPinsEntry] = {}
    settings: dict[str, Any] = {}


class LinkEntry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A serial line between two ends.

    Attributes:
        ends: ``peer``, where the checker or a served client sits, or ``peer.LINE`` where it has several lines, each
            with a name of your choosing; ``NAME.host`` of a model with one line, else by the names of its lines, such
            as ``NAME.usart2``; ``NAME.usart1`` of a board; a serial end of a part, as ``NAME.uart2``.
        baud: speed in bit/s of the end that is no emulated USART, which has its own; the usual one of a model, and that
            of the USART for ``peer`` and for a part without a rate of its own, if it is left out.
        protocol: what is spoken between ``peer`` and a board, by its name (``hilbench protocols``); a suite then has
            messages at its ``peer``. A model speaks its own.
    """

    ends: tuple[str, str]
    baud: Annotated[int, msgspec.Meta(ge=300, le=4_500_000)] | UnsetType = UNSET
    protocol: str | UnsetType = UNSET


class WireEntry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A piece of wire.

    Attributes:
        ends: what it joins: ``NAME.PIN`` of a board, by the name of the port pin (``PA0``) or the one printed on the
            board (``A0``); ``NAME.TERMINAL`` of a part; ``3v3`` and ``gnd``.
    """

    ends: Annotated[tuple[str, ...], msgspec.Meta(min_length=2)]


class PortEntry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How a real port is opened that takes the place of a target, and how the board behind it is reset.

    A hook is a list of steps: ``dtr on``, ``rts off``, ``dtr off rts on`` (both at once), ``break 250ms``, ``wait
    100ms``, ``run COMMAND`` (a relay, a probe).

    Attributes:
        dtr: level that DTR shall have when the port is open, true for asserted; as opening leaves it if not given.
        rts: likewise of RTS.
        parity: ``N``, ``E`` or ``O``.
        stop_bits: 1 or 2.
        boot: what is done once, when the port was opened for the first time.
        reset: what is done before each case.
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
    """A bench file as it is written.

    Attributes:
        version: version of this format.
        targets: what answers at the far end, by names of your choosing.
        parts: what stands between boards and the world, by names of your choosing.
        world: where a model, or the vehicle that parts drive, stands.
        links: the serial lines.
        wires: what joins pins of boards.
        faults: what goes wrong on the links.
        stimuli: what is done to the boards from outside, and when: lines such as ``1s:PC13=0`` (docs/stimuli.md).
        port: how a real port is opened that takes the place of a target.
        lockstep_us: how far one of several boards that wires join may be ahead of the others, in microseconds: an edge
            from one to another is that much late at most. Frames on lines between boards are never late.
        suites: what ``hilbench check`` runs on this bench where no suite is asked for: names of shipped suites, or
            paths of suite files or folders, seen from the bench file.
        variants: other benches, by names that cases of these suites use: paths of bench files, seen from this one.
        plugins: files that bring protocols, seen from the bench file; their code runs when the bench is opened.
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
