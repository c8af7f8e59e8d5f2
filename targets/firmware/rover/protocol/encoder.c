// SPDX-License-Identifier: GPL-2.0-or-later

#include "rover/protocol/encoder.h"

#include "rover/board/link.h"
#include "rover/options.h"
#include "rover/protocol/body.h"
#include "rover/protocol/crc.h"

void encoder_send(const uint8_t *payload, uint32_t count)
{
    uint8_t frame[5 + MAX_REPORT + CRC_BYTES + 1] = {'P', 'K', 'T', '!'};
    uint8_t *to = frame + 4;
    if (!FRAMING_TERM)
        *to++ = (uint8_t)count;
    uint16_t crc = crc16(payload, count);
    for (uint32_t i = 0; i < count; ++i)
        *to++ = payload[i];
    *to++ = (uint8_t)(crc >> 8);
    *to++ = (uint8_t)crc;
    *to++ = NEWLINE;
    link_send(frame, (uint32_t)(to - frame));
}
