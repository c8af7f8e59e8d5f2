"""A clause: one rule that a peer follows or violates, where it is written, and of which profiles it is part."""

from __future__ import annotations

from dataclasses import dataclass

from protocols.common import clause

__all__ = ["Clause"]

TASK = "LMA-FEM-UNICAMP/microAutoware, taksControl.c StartTaskControl"
ISR = "LMA-FEM-UNICAMP/microAutoware, taksControl.c HAL_UART_RxCpltCallback"
EXTI = "LMA-FEM-UNICAMP/microAutoware, taksControl.c HAL_GPIO_EXTI_Callback"
UTILS = "LMA-FEM-UNICAMP/microAutoware, utils.c"
MICRO_ROS = "LMA-FEM-UNICAMP/microAutoware, microAutoware.c"
CALLBACKS = "LMA-FEM-UNICAMP/microAutoware, executorCallbacks.c control_mode_cmd_callback"
HEADER = "LMA-FEM-UNICAMP/microAutoware, taksControl.h"
V0 = "toffanetto/im420x, nucleo-H753ZI_TemplateAutoware_Serial, November 2024"
REPORT = "toffanetto/im420x, project/docs, corpo.tex"
NODE = "LMA-FEM-UNICAMP/carla_serial_bridge, carla_serial_bridge_node.cpp"
SERIAL_COM = "LMA-FEM-UNICAMP/carla_serial_bridge, serial_com.cpp"
CAB = "LMA-FEM-UNICAMP/Carla-Autoware-Bridge"
ACKERMANN = "carla-simulator/ros-bridge, carla_ackermann_control"
HAL = "STMicroelectronics/stm32h7xx_hal_driver, stm32h7xx_hal_uart.c; from reading, not measured"
LINE = "the nature of a serial line, which keeps no packet boundaries and damages bytes"
CHOICE = "choice: no source says"


@dataclass(frozen=True, slots=True, kw_only=True)
class Clause(clause.Clause):
    """One rule; see `protocols.common.clause.Clause`.

    Attributes:
        id: short name, unique in the catalogue: VB for the board, VS for the simulator's side; an H behind it marks
            what is asked instead of a hazard of the originals.
        profiles: names of the profiles that hold it, see profiles.py.
        twin: where shipped behaviour is a hazard, the clause that says what is asked instead; else None.
        needs: names of what a bench must be able to do for it to be checked: `board` or `simulator` under test; for a
            board `stack` (be its driving stack), `joystick` (hold it, press it), `lamps` (see them), `indicators` (see
            the turn indicators), `boot` (begin from power-up), `line errors` (make a framing error), `hang` (have its
            program do nothing more); for a simulator `car` (see what the car is commanded, and say what it does), `read
            errors` (make its reads fail). Of `stand_ins`: `car.reported` (the simulator's side tells what its car is
            commanded).
    """

    profiles: tuple[str, ...]
    twin: str | None = None
