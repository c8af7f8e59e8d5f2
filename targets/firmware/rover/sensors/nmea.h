// SPDX-License-Identifier: GPL-2.0-or-later
//
// Sentences of a GPS receiver (u-blox 6 Receiver Description, GPS.G6-SW-10018, NMEA protocol): $..GGA and $..RMC of any talker,
// with a sound checksum.

#pragma once

#include <stdbool.h>
#include <stdint.h>

struct position {
    bool valid; // the receiver has a fix
    float latitude_deg, longitude_deg; // north and east are positive
};

// Takes a byte of the stream. True if it ends a sentence with a position, or with the word that there is none.
bool nmea_take(uint8_t byte, struct position *position);
