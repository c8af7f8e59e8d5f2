// SPDX-License-Identifier: GPL-2.0-or-later
//
// The vehicle interface of microAutoware, on a NUCLEO-H753ZI: it stands between a driving stack and a simulated car; built with
// the options of defects.h, as it was published. Two tasks, as in the original; their priorities are AboveNormal and Normal.

#include "vehicle_interface/board/clock.h"
#include "vehicle_interface/board/joystick.h"
#include "vehicle_interface/board/lights.h"
#include "vehicle_interface/board/simulator_line.h"
#include "vehicle_interface/board/stack_line.h"
#include "vehicle_interface/board/watchdog.h"
#include "vehicle_interface/control/control.h"
#include "vehicle_interface/kernel/kernel.h"
#include "vehicle_interface/stack/driving_stack.h"

#define STACK(name, bytes) static uint64_t name[(bytes) / 8] __attribute__((section(".stacks")))

STACK(control_stack, 4096);
STACK(driving_stack_stack, 4096);
STACK(interrupt_stack, 4096);

static struct task control, driving_stack;

int main(void)
{
    clock_start();
    lights_start();
    joystick_start();
    simulator_line_start();
    stack_line_start();
    task_create(&control, control_stack, sizeof control_stack, control_task, 32);
    task_create(&driving_stack, driving_stack_stack, sizeof driving_stack_stack, driving_stack_task, 24);
    watchdog_start();
    kernel_start(CORE_HZ, interrupt_stack + sizeof interrupt_stack / sizeof *interrupt_stack);
}
