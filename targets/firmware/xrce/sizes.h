// SPDX-License-Identifier: GPL-2.0-or-later
//
// What a client has room for; a project may define others before.

#pragma once

#ifndef XRCE_MTU
#define XRCE_MTU 512u // bytes of the longest message; that of micro-ROS's serial transports
#endif
#ifndef XRCE_WINDOW
#define XRCE_WINDOW 8u // messages of a reliable stream on their way, and such as came too early: 1 to 16
#endif
#ifndef XRCE_WHOLE
#define XRCE_WHOLE 1024u // bytes of a message that comes in fragments
#endif
