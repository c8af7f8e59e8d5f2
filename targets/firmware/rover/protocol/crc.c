// SPDX-License-Identifier: GPL-2.0-or-later

#include "rover/protocol/crc.h"

#define POLYNOMIAL 0x1021u

uint16_t crc16(const uint8_t *data, uint32_t count)
{
    uint32_t crc = 0xFFFF;
    while (count--) {
        crc ^= (uint32_t)*data++ << 8;
        for (int bit = 0; bit < 8; ++bit)
            crc = crc & 0x8000 ? crc << 1 ^ POLYNOMIAL : crc << 1;
    }
    return (uint16_t)crc;
}
