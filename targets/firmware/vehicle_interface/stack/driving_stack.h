// SPDX-License-Identifier: GPL-2.0-or-later
//
// The driving stack's task: its commands and requests to the control task, the car's state and mode back to it. It stands where
// the original has its micro-ROS client.

#pragma once

void driving_stack_task(void);
