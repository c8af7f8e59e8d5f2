// SPDX-License-Identifier: GPL-2.0-or-later

#include "rover/sensors/nmea.h"

#define MAX_SENTENCE 82u // with $ and the end of the line
#define MAX_FIELDS 20u

static char sentence[MAX_SENTENCE]; // behind the $
static uint32_t count;
static bool inside; // of a sentence

static const char *fields[MAX_FIELDS];
static uint32_t field_count;

static int digit_of(char hex)
{
    if (hex >= '0' && hex <= '9')
        return hex - '0';
    if (hex >= 'A' && hex <= 'F')
        return hex - 'A' + 10;
    return -1;
}

// Behind the * stands the exclusive or of all in front of it, in two digits. The * is made the end of the text.
static bool is_sound(void)
{
    uint8_t sum = 0;
    uint32_t star = 0;
    for (; star < count && sentence[star] != '*'; ++star)
        sum ^= (uint8_t)sentence[star];
    if (star + 3 != count)
        return false;
    sentence[star] = 0;
    return digit_of(sentence[star + 1]) == sum >> 4 && digit_of(sentence[star + 2]) == (sum & 0xF);
}

static void split(void)
{
    field_count = 0;
    fields[field_count++] = sentence;
    for (char *at = sentence; *at; ++at) {
        if (*at == ',') {
            *at = 0;
            if (field_count < MAX_FIELDS)
                fields[field_count++] = at + 1;
        }
    }
}

static bool is_type(const char *type)
{
    const char *name = fields[0];
    return name[0] && name[1] && name[2] == type[0] && name[3] == type[1] && name[4] == type[2] && !name[5];
}

static bool is_digit(char c) { return c >= '0' && c <= '9'; }

// A number without sign. Double: 18000.12345 has more digits than a float.
static bool parse(const char *text, double *value)
{
    double whole = 0.0, place = 1.0;
    bool behind_point = false;
    if (!*text)
        return false;
    for (; *text; ++text) {
        if (*text == '.' && !behind_point) {
            behind_point = true;
        } else if (is_digit(*text)) {
            whole = whole * 10.0 + (*text - '0');
            place *= behind_point ? 10.0 : 1.0;
        } else {
            return false;
        }
    }
    *value = whole / place;
    return true;
}

// ddmm.mmmm or dddmm.mmmm, and the letter of the hemisphere.
static bool parse_angle(const char *text, const char *hemisphere, char negative, float *angle_deg)
{
    double number;
    if (!parse(text, &number))
        return false;
    double degrees = (double)(uint32_t)(number / 100.0);
    double angle = degrees + (number - 100.0 * degrees) / 60.0;
    *angle_deg = (float)(*hemisphere == negative ? -angle : angle);
    return true;
}

static bool parse_position(uint32_t at, struct position *position)
{
    return parse_angle(fields[at], fields[at + 1], 'S', &position->latitude_deg) &&
           parse_angle(fields[at + 2], fields[at + 3], 'W', &position->longitude_deg);
}

static bool take_sentence(struct position *position)
{
    bool fix;
    uint32_t at;
    if (is_type("GGA") && field_count > 6) { // time, latitude, longitude, quality ...
        fix = *fields[6] != '0' && *fields[6];
        at = 2;
    } else if (is_type("RMC") && field_count > 6) { // time, status, latitude, longitude ...
        fix = *fields[2] == 'A';
        at = 3;
    } else {
        return false;
    }
    struct position found = {0};
    position->valid = fix && parse_position(at, &found);
    if (position->valid) {
        position->latitude_deg = found.latitude_deg;
        position->longitude_deg = found.longitude_deg;
    }
    return true;
}

static bool end(struct position *position)
{
    inside = false;
    if (!is_sound())
        return false;
    split();
    return take_sentence(position);
}

bool nmea_take(uint8_t byte, struct position *position)
{
    if (byte == '$') {
        inside = true;
        count = 0;
    } else if (inside && (byte == '\r' || byte == '\n')) {
        return end(position);
    } else if (inside && count < MAX_SENTENCE - 1) {
        sentence[count++] = (char)byte;
    } else {
        inside = false;
    }
    return false;
}
