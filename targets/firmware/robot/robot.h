// SPDX-License-Identifier: GPL-2.0-or-later
//
// The robot's connector: eight distance switches, two motors and two encoders of three wires each, a line that asks for
// the connection, one that resets the adapter, and three lamps.
//
//   distance 1..8      in    PA4 PA5 PA6 PA7 PB0 PB1 PB10 PB11     high: something is near
//   motor 1 (left)     out   PB7 PB6 PB5                           comm1..3, comm3 is the sign
//   motor 2 (right)    out   PA1 PA2 PA3                           likewise
//   encoder 1 (left)   in    PB4 PB3 PA15                          s1..3, s1 is bit 0; pins of the debug port
//   encoder 2 (right)  in    PC13 PC14 PC15                        likewise
//   connection, reset  out   PB12 PB13
//   lamps              out   PA0 PA11 PA12
//
// Pins of the connector as in the schematic of the adapter board (qemu-gazebo-sim/bachelor-thesis, src/files); USART1
// (PA9, PA10) is there as well and is where these programs say what they do, 115200 8N1.

#pragma once

#include <stdbool.h>
#include <stdint.h>

#define CODE_LEAST (-4)
#define CODE_MOST 3

enum side { LEFT, RIGHT };

// Everything above, the motors at 0, and a tick of 10 ms. What drives nothing reads as 0 (pull-downs).
void robot_start(void);

// Sets the wires of one motor, all three at once.
void robot_motor(enum side side, int code);
void robot_drive(int left, int right);

// The distance switches, switch 1 in bit 0.
uint8_t robot_obstacles(void);

// The number on an encoder's wires, 0..7.
unsigned robot_encoder(enum side side);

// Asks the adapter for the connection to the robot, or no longer.
void robot_connect(bool wanted);

void robot_lamp(unsigned number, bool on);

// Bench time since robot_start in milliseconds, in steps of the tick; sleeping until the next tick, or for longer.
uint32_t robot_now_ms(void);
void robot_wait_tick(void);
void robot_wait_ms(uint32_t span_ms);

// Text over USART1; waits for what has been said before, sleeping.
void robot_say(const char *text);
