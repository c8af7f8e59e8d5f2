// SPDX-License-Identifier: GPL-2.0-or-later
//
// The control task: which mode rules, and what the simulator is told in it.

#pragma once

void control_task(void);
