// SPDX-License-Identifier: GPL-2.0-or-later

#include "vehicle_interface/stack/crc.h"

#define POLYNOMIAL 0xA001u

uint16_t crc_add(uint16_t crc, uint8_t byte)
{
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit)
        crc = (uint16_t)(crc >> 1 ^ (crc & 1 ? POLYNOMIAL : 0));
    return crc;
}
