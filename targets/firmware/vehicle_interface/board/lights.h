// SPDX-License-Identifier: GPL-2.0-or-later
//
// The board's three lights (UM2407, section 6.5) show the mode; two lamps are the indicators. All are on while their pins are
// high.

#pragma once

#include <stdbool.h>

enum light {
    LIGHT_MANUAL,    // LD1, green, PB0
    LIGHT_AUTOWARE,  // LD2, amber, PE1
    LIGHT_EMERGENCY, // LD3, red, PB14
    LAMP_LEFT,       // PE7 (choice)
    LAMP_RIGHT,      // PE8 (choice)
    LIGHTS,
};

void lights_start(void);
void light_put(enum light light, bool on);
