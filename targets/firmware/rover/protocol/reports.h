// SPDX-License-Identifier: GPL-2.0-or-later
//
// What the rover tells the host. Which of these a schema has, the tables of reports.c and schedule.c say.

#pragma once

void report_general(void);   // 0x80
void report_execution(void); // 0x81
void report_imu(void);       // 0x82
void report_motion(void);    // 0x83
void report_gps(void);       // 0x84
void report_pid(void);       // 0x85
