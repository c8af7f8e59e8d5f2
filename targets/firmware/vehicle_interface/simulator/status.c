// SPDX-License-Identifier: GPL-2.0-or-later

#include "vehicle_interface/simulator/status.h"

#include "vehicle_interface/numbers.h"

#define UNFINISHED_TICKS 100u // after that a frame is given up (choice: one deadline)

struct __attribute__((packed)) field {
    char letter;
    float value;
};

struct __attribute__((packed)) status_frame {
    char start;
    struct field longitudinal, lateral, heading_rate, steering;
    char end;
};

_Static_assert(sizeof(struct status_frame) == STATUS_FRAME_BYTES, "a status has 22 bytes");

// What has to stand there; 0 if anything may.
static char letter_at(uint32_t place)
{
    if (place == 0)
        return '#';
    if (place == STATUS_FRAME_BYTES - 1)
        return '$';
    return place % 5 == 1 ? (char)('A' + place / 5) : 0;
}

static bool fits(uint32_t place, uint8_t byte) { return letter_at(place) == 0 || letter_at(place) == byte; }

// Drops the first byte, and with it all up to the next place where a frame may have begun.
static void give_up(struct status_reader *reader)
{
    uint32_t count = reader->count;
    for (uint32_t first = 1; first < count; ++first) {
        uint32_t length = 0;
        while (first + length < count && fits(length, reader->bytes[first + length]))
            ++length;
        if (first + length < count)
            continue;
        for (uint32_t i = 0; i < length; ++i) {
            reader->bytes[i] = reader->bytes[first + i];
            reader->ticks[i] = reader->ticks[first + i];
        }
        reader->count = length;
        return;
    }
    reader->count = 0;
}

bool status_take(struct status_reader *reader, uint8_t byte, uint32_t tick, struct status *status)
{
    while (reader->count && tick - reader->ticks[0] >= UNFINISHED_TICKS)
        give_up(reader);
    if (reader->count == 0 && byte != '#')
        return false;
    bool right = fits(reader->count, byte);
    reader->ticks[reader->count] = tick;
    reader->bytes[reader->count++] = byte;
    if (!right)
        give_up(reader);
    if (reader->count < STATUS_FRAME_BYTES)
        return false;
    const struct status_frame *frame = (const struct status_frame *)reader->bytes;
    *status = (struct status){frame->longitudinal.value, frame->lateral.value, frame->heading_rate.value,
                              frame->steering.value};
    reader->count = 0;
    return true;
}

static uint8_t *field_of(struct status *status, uint8_t letter)
{
    float *const FIELDS[] = {&status->longitudinal, &status->lateral, &status->heading_rate, &status->steering};
    return letter >= 'A' && letter <= 'D' ? (uint8_t *)FIELDS[letter - 'A'] : 0;
}

bool status_take_block(const volatile uint8_t *block, struct status *status)
{
    bool begun = false, complete = false;
    for (uint32_t at = 0; at < STATUS_FRAME_BYTES; ++at) {
        uint8_t byte = block[at], *field = begun ? field_of(status, byte) : 0;
        if (!begun) {
            begun = byte == '#';
        } else if (field) {
            for (uint32_t i = 0; i < sizeof(float) && ++at < STATUS_FRAME_BYTES; ++i)
                field[i] = block[at];
        } else {
            complete |= byte == '$';
            begun = false;
        }
    }
    return complete;
}

bool status_plausible(const struct status *status)
{
    return within(status->longitudinal, 150.0f) && within(status->lateral, 150.0f) && within(status->heading_rate, 20.0f) &&
           within(status->steering, 2.0f);
}
