"""What each command does: one table from command number to a function that does it.

A function returns None when the command took effect, otherwise why it did not. A number that is not in the table is not
modelled: as on the real robot nothing answers, and it counts as traffic.
"""

from __future__ import annotations

from collections.abc import Callable

from protocols.p2os import Command, CommandNumber, vel2_speeds_mm_s
from targets.robots.pioneer.controller import Controller
from targets.robots.pioneer.events import CommandIgnored, CommandObeyed, HostBaudChanged, NotModelled, Refusal
from targets.robots.pioneer.motion import Mode
from targets.robots.pioneer.requests import Extra

Handler = Callable[[Controller, Command, int], Refusal | None]

_C = CommandNumber


class CommandTable:
    """Obeys commands on a controller and tells the journal what became of each."""

    def __init__(self, controller: Controller) -> None:
        self._controller = controller
        self._reported: set[int] = set()

    def obey(self, command: Command, now_ns: int) -> None:
        """Do what `command` says; the connection has made sure that its argument is of the right kind."""
        handler = HANDLERS.get(command.number)
        if handler is None:
            if command.number not in self._reported:
                self._reported.add(command.number)
                self._controller.tell(NotModelled(command=command.number))
            return
        refusal = handler(self._controller, command, now_ns)
        if refusal is None:
            if command.number not in _SESSION:
                self._controller.tell(CommandObeyed(command=command))
        else:
            self._controller.tell(CommandIgnored(command=command, reason=refusal))


def _nothing(_controller: Controller, _command: Command, _now_ns: int) -> None:
    """PULSE, OPEN, CLOSE and SAY: the connection or nobody acts on them."""


# --- motion -------------------------------------------------------------------------------------------------------


def _moved(controller: Controller, obeyed: bool) -> Refusal | None:
    if obeyed:
        controller.bumpers.release()
        return None
    return Refusal.EMERGENCY if controller.motion.mode is Mode.EMERGENCY else Refusal.MOTORS_OFF


def _velocity(controller: Controller, command: Command, _now_ns: int) -> Refusal | None:
    return _moved(controller, controller.motion.velocity(command.value))


def _move(controller: Controller, command: Command, _now_ns: int) -> Refusal | None:
    if not controller.settings.has_move:
        return Refusal.NOT_FITTED
    return _moved(controller, controller.motion.move(command.value))


def _rotate(controller: Controller, command: Command, _now_ns: int) -> Refusal | None:
    return _moved(controller, controller.motion.rotate(command.value))


def _head(controller: Controller, command: Command, _now_ns: int) -> Refusal | None:
    return _moved(controller, controller.motion.head(command.value, controller.odometer.zero_heading_deg))


def _turn_by(controller: Controller, command: Command, _now_ns: int) -> Refusal | None:
    return _moved(controller, controller.motion.turn_by(command.value))


def _turn_setpoint_by(controller: Controller, command: Command, _now_ns: int) -> Refusal | None:
    return _moved(controller, controller.motion.turn_setpoint_by(command.value))


def _wheels(controller: Controller, command: Command, _now_ns: int) -> Refusal | None:
    left, right = vel2_speeds_mm_s(command, unit_mm_s=controller.settings.vel2_unit_mm_s)
    return _moved(controller, controller.motion.wheels(left, right))


def _stop(controller: Controller, _command: Command, _now_ns: int) -> Refusal | None:
    return None if controller.motion.stop() else Refusal.MOTORS_OFF


def _emergency_stop(controller: Controller, _command: Command, _now_ns: int) -> Refusal | None:
    return None if controller.motion.emergency_stop() else Refusal.MOTORS_OFF


def _enable(controller: Controller, command: Command, _now_ns: int) -> None:
    controller.enable(command.value != 0)


def _origin(controller: Controller, _command: Command, _now_ns: int) -> None:
    controller.odometer.set_origin()


def _changed(changed: bool) -> Refusal | None:
    return None if changed else Refusal.BAD_ARGUMENT


def _acceleration(controller: Controller, command: Command, _now_ns: int) -> Refusal | None:
    return _changed(controller.limits.set_translation_acceleration(command.value))


def _speed(controller: Controller, command: Command, _now_ns: int) -> Refusal | None:
    return _changed(controller.limits.set_translation_speed(command.value))


def _rotation_speed(controller: Controller, command: Command, _now_ns: int) -> Refusal | None:
    return _changed(controller.limits.set_rotation_speed(command.value))


def _rotation_acceleration(controller: Controller, command: Command, _now_ns: int) -> Refusal | None:
    return _changed(controller.limits.set_rotation_acceleration(command.value))


def _gain(controller: Controller, command: Command, _now_ns: int) -> Refusal | None:
    if not 0 <= command.value <= 0xFFFF:
        return Refusal.BAD_ARGUMENT
    controller.gains[command.number - _C.ROTKP] = command.value
    return None


def _bump_stall(controller: Controller, command: Command, _now_ns: int) -> Refusal | None:
    if not 0 <= command.value <= 3:
        return Refusal.BAD_ARGUMENT
    controller.bumpers.mode = command.value
    return None


# --- sonar and user I/O -------------------------------------------------------------------------------------------


def _sonar(controller: Controller, command: Command, now_ns: int) -> None:
    controller.sonar.switch(bool(command.value & 1), now_ns)


def _polling(controller: Controller, command: Command, _now_ns: int) -> None:
    controller.sonar.poll(command.text)


def _digout(controller: Controller, command: Command, _now_ns: int) -> None:
    controller.io.write(command.value)


def _select_analog(controller: Controller, command: Command, _now_ns: int) -> Refusal | None:
    return _changed(controller.io.select(command.value))


# --- requests and accessories -------------------------------------------------------------------------------------


def _asks(extra: Extra) -> Handler:
    def ask(controller: Controller, command: Command, _now_ns: int) -> None:
        controller.requests.ask(extra, command.value)

    return ask


def _asks_once(extra: Extra) -> Handler:
    def ask(controller: Controller, _command: Command, _now_ns: int) -> None:
        controller.requests.ask(extra, 1)

    return ask


def _gyro(controller: Controller, command: Command, _now_ns: int) -> Refusal | None:
    if not controller.settings.gyro_fitted:
        return Refusal.NOT_FITTED
    controller.requests.ask(Extra.GYRO, 2 if command.value else 0)
    return None


def _joystick(controller: Controller, command: Command, _now_ns: int) -> Refusal | None:
    if not controller.settings.joystick_fitted:
        return Refusal.NOT_FITTED
    controller.requests.ask(Extra.JOYSTICK, command.value)
    return None


def _tcm2(controller: Controller, command: Command, _now_ns: int) -> Refusal | None:
    """0 off, 1 compass byte only, 2 one packet, 3 a stream; calibrations (4 to 7) are not modelled."""
    if not controller.settings.tcm2_fitted:
        return Refusal.NOT_FITTED
    if not 0 <= command.value <= 3:
        return Refusal.BAD_ARGUMENT
    controller.compass_on = command.value > 0
    controller.requests.ask(Extra.TCM2, max(0, command.value - 1))
    return None


def _gripper(controller: Controller, command: Command, now_ns: int) -> Refusal | None:
    if not controller.settings.gripper_fitted:
        return Refusal.NOT_FITTED
    return _changed(controller.gripper.command(command.value, now_ns))


def _battery_info(controller: Controller, command: Command, _now_ns: int) -> Refusal | None:
    if not controller.settings.answers_battery_info:
        return Refusal.NOT_FITTED
    controller.requests.ask(Extra.BATTERY, command.value)
    return None


def _battery_test(controller: Controller, command: Command, _now_ns: int) -> Refusal | None:
    if not 0 <= command.value <= 0xFF:
        return Refusal.BAD_ARGUMENT
    controller.battery_dv = command.value or controller.settings.battery_dv
    return None


def _sends_aux(port: int) -> Handler:
    def send(controller: Controller, command: Command, _now_ns: int) -> None:
        controller.aux_ports[port - 1].send(command.text)

    return send


def _fetches_aux(port: int) -> Handler:
    def fetch(controller: Controller, command: Command, _now_ns: int) -> Refusal | None:
        return _changed(controller.aux_ports[port - 1].want(command.value))

    return fetch


def _host_baud(controller: Controller, command: Command, now_ns: int) -> Refusal | None:
    if not controller.host_baud.request(command.value, now_ns):
        return Refusal.BAD_ARGUMENT
    controller.tell(HostBaudChanged(baud=controller.host_baud.baud, reverted=False))
    return None


_SESSION = frozenset((_C.PULSE, _C.OPEN, _C.CLOSE))

HANDLERS: dict[int, Handler] = {
    _C.PULSE: _nothing,
    _C.OPEN: _nothing,
    _C.CLOSE: _nothing,
    _C.POLLING: _polling,
    _C.ENABLE: _enable,
    _C.SETA: _acceleration,
    _C.SETV: _speed,
    _C.SETO: _origin,
    _C.MOVE: _move,
    _C.ROTATE: _rotate,
    _C.SETRV: _rotation_speed,
    _C.VEL: _velocity,
    _C.HEAD: _head,
    _C.DHEAD: _turn_by,
    _C.SAY: _nothing,
    _C.JOYINFO: _joystick,
    _C.CONFIG: _asks_once(Extra.CONFIG),
    _C.ENCODER: _asks(Extra.ENCODER),
    _C.RVEL: _rotate,
    _C.DCHEAD: _turn_setpoint_by,
    _C.SETRA: _rotation_acceleration,
    _C.SONAR: _sonar,
    _C.STOP: _stop,
    _C.DIGOUT: _digout,
    _C.VEL2: _wheels,
    _C.GRIPPER: _gripper,
    _C.ADSEL: _select_analog,
    _C.GRIPREQUEST: _asks(Extra.GRIPPER),
    _C.IOREQUEST: _asks(Extra.IO),
    _C.TTY2: _sends_aux(1),
    _C.GETAUX: _fetches_aux(1),
    _C.BUMPSTALL: _bump_stall,
    _C.TCM2: _tcm2,
    _C.HOSTBAUD: _host_baud,
    _C.E_STOP: _emergency_stop,
    _C.QSTOP: _emergency_stop,
    _C.GYRO: _gyro,
    _C.TTY3: _sends_aux(2),
    _C.TTY4: _sends_aux(3),
    _C.GETAUX2: _fetches_aux(2),
    _C.GETAUX3: _fetches_aux(3),
    _C.BATTERYINFO: _battery_info,
    _C.ROTKP: _gain,
    _C.ROTKV: _gain,
    _C.ROTKI: _gain,
    _C.TRANSKP: _gain,
    _C.TRANSKV: _gain,
    _C.TRANSKI: _gain,
    _C.PLAYLIST: _asks_once(Extra.PLAYLIST),
    _C.BATTEST: _battery_test,
}
