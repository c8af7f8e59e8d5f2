// SPDX-License-Identifier: GPL-2.0-or-later
//
// The known defects of the published firmwares, each of which an image can be built with: -DDEFECT_NAME=1. Their names are those
// of the quirks in protocols/carla/profiles.py, as far as these have them.
//
// Each says what goes wrong, and behind the bar where that is to be seen: V0 is the firmware of November 2024 (toffanetto/im420x,
// project/ws/nucleo-H753ZI_TemplateAutoware_Serial), V1 that of January 2025 (LMA-FEM-UNICAMP/microAutoware, src/HIL and
// src/microAutoware), DOC the report on V0. Those marked [v0] and [v1] are all in the images vehicle-v0 and vehicle-v1. H3 to
// H5 are the simulator's side.

#pragma once

// --- the simulator's line

// [v0] [v1] What a frame says is believed, not a number or beyond anything a car does | V0, V1 HAL_UART_RxCpltCallback
#ifndef DEFECT_H1
#define DEFECT_H1 0
#endif
// [v0] [v1] Blocks of 22 bytes, each read from its start: after a stray byte no frame is found again | V0, V1 taksControle.c
#ifndef DEFECT_H2
#define DEFECT_H2 0
#endif
// [v0] [v1] An overrun or a framing error ends reception | V0, V1: HAL aborts the DMA; there is no HAL_UART_ErrorCallback
#ifndef DEFECT_DIES_ON_ERROR
#define DEFECT_DIES_ON_ERROR 0
#endif

// --- commands

// [v0] [v1] One structure for both modes: a command that waited is sent as the joystick's | V0, V1 taksControle.c xControlAction
#ifndef DEFECT_H6
#define DEFECT_H6 0
#endif
// [v0] [v1] Without a command the one before is sent again, moving or not, for up to 1.1 s | V0, V1 osFlagsErrorTimeout
#ifndef DEFECT_H7
#define DEFECT_H7 0
#endif
// [v0] [v1] Before the first command, what was in memory is sent | V0, V1 ucTxMsgToCarla
#ifndef DEFECT_H8
#define DEFECT_H8 0
#endif
// [v0] [v1] The loss of the driving stack shows in missing commands alone, and it is not found again | V0, V1 microAutoware.c
#ifndef DEFECT_H9
#define DEFECT_H9 0
#endif
// The first deadlines: a single miss changes the mode, after 30 ms for a command | DOC, table of tasks; V0 until 4 November 2024
#ifndef DEFECT_ONE_MISS
#define DEFECT_ONE_MISS 0
#endif
// The NUL behind each frame is missing | DOC and the READMEs, where the pattern of 29 bytes is said to have 30
#ifndef DEFECT_NO_PADDING
#define DEFECT_NO_PADDING 0
#endif
// The steering without its factor of 1.2, which was the simulator side's at first | V0 before the factor was moved
#ifndef DEFECT_NO_FACTOR
#define DEFECT_NO_FACTOR 0
#endif

// --- modes

// [v1] In MANUAL the status is waited for at the driving stack's flag of the same number | V1 taksControl.c MANUAL block
#ifndef DEFECT_FLAG_CLASH
#define DEFECT_FLAG_CLASH 0
#endif
// [v0] [v1] While commands are missing nobody watches the simulator, and its statuses wait | V0, V1 AUTOWARE block
#ifndef DEFECT_UNWATCHED
#define DEFECT_UNWATCHED 0
#endif
// [v0] [v1] The driving stack can order a mode in EMERGENCY | V0, V1 taksControle.c: taken in any mode
#ifndef DEFECT_EMERGENCY_REQUESTS
#define DEFECT_EMERGENCY_REQUESTS 0
#endif
// [v0] [v1] Of two requests at once AUTOWARE is taken | V0, V1 taksControle.c: the branch for both comes last
#ifndef DEFECT_BOTH_AUTOWARE
#define DEFECT_BOTH_AUTOWARE 0
#endif

// --- reports

// [v0] [v1] At a missed status the old one is reported again | V0, V1 taksControle.c: VEHICLE_DATA_UPDATED_FLAG
#ifndef DEFECT_STALE_STATUS
#define DEFECT_STALE_STATUS DEFECT_FLAG_CLASH
#endif
// [v1] EMERGENCY is reported as MANUAL | V1 microAutoware.c MA_TO_EMERGENCY_MODE_FLAG
#ifndef DEFECT_EMERGENCY_MANUAL
#define DEFECT_EMERGENCY_MANUAL 0
#endif
// [v0] EMERGENCY is not reported: the mode before it stays | V0 microAutoware.c: the flag is not in the mask
#ifndef DEFECT_EMERGENCY_KEPT
#define DEFECT_EMERGENCY_KEPT 0
#endif

// --- the rest of the board

// [v0] [v1] Beyond its calibration the joystick asks for more than all | V0, V1 utils.c fGetJoyPostition
#ifndef DEFECT_NO_CLAMP
#define DEFECT_NO_CLAMP 0
#endif
// The joystick's axes are exchanged | DOC, schematic: X on PF11, Y on PF12
#ifndef DEFECT_AXES_SWAPPED
#define DEFECT_AXES_SWAPPED 0
#endif
// [v0] [v1] Turn indicators and hazard lights are not served | V0, V1 microAutoware.c: commented out; DOC asks for them
#ifndef DEFECT_NO_LAMPS
#define DEFECT_NO_LAMPS 0
#endif
// [v0] [v1] No watchdog: a task that hangs leaves the simulator with the last command | V0, V1 main.c
#ifndef DEFECT_NO_WATCHDOG
#define DEFECT_NO_WATCHDOG 0
#endif
