// SPDX-License-Identifier: GPL-2.0-or-later

#include "vehicle_interface/exchange.h"

struct exchange exchange = {.mode = MODE_AUTOWARE};
struct events events, board_events;
