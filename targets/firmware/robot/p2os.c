// SPDX-License-Identifier: GPL-2.0-or-later

#include "robot/p2os.h"

#define HEADER_0 0xFAu
#define HEADER_1 0xFBu

// Commands by number; the first three are SYNC0 to SYNC2 while no session is open.
#define PULSE 0
#define OPEN 1
#define CLOSE 2
#define ENABLE 4
#define VEL 11
#define RVEL 21
#define SONAR 28

#define POSITIVE 0x3B
#define NEGATIVE 0x1B

#define CLOSING_MS 100u     // for what the robot was still saying (choice)
#define ASK_AGAIN_MS 500u   // a SYNC that nobody has answered
#define PULSE_MS 500u       // the robot stops after 2 s without a word
#define SILENT_MS 3000u     // the robot is gone
#define TELL_AGAIN_MS 1000u
#define RANGE_MILLI 268u    // a unit of a sonar reading in thousandths of a millimetre (AriaCoda params/p2dx.p)

static uint16_t checksum(const uint8_t *body, uint32_t count)
{
    uint16_t sum = 0;
    for (; count > 1; count -= 2, body += 2)
        sum = (uint16_t)(sum + (body[0] << 8 | body[1]));
    return count ? sum ^ body[0] : sum;
}

static void send(struct p2os *p2os, const uint8_t *body, uint8_t count)
{
    uint8_t frame[3 + 6] = {HEADER_0, HEADER_1, (uint8_t)(count + 2)};
    for (uint32_t i = 0; i < count; ++i)
        frame[3 + i] = body[i];
    uint16_t sum = checksum(body, count);
    frame[3 + count] = (uint8_t)(sum >> 8);
    frame[4 + count] = (uint8_t)sum;
    p2os->send(frame, 5u + count);
}

static void send_plain(struct p2os *p2os, uint8_t command) { send(p2os, &command, 1); }

static void send_number(struct p2os *p2os, uint8_t command, int16_t value)
{
    uint16_t size = (uint16_t)(value < 0 ? -value : value);
    uint8_t body[4] = {command, value < 0 ? NEGATIVE : POSITIVE, (uint8_t)size, (uint8_t)(size >> 8)};
    send(p2os, body, sizeof body);
}

static void ask(struct p2os *p2os, enum p2os_state state, uint32_t now_ms)
{
    p2os->state = state;
    p2os->asked_ms = now_ms;
    send_plain(p2os, (uint8_t)state);
}

// The robot may be in a session that this program knows nothing of any more: there SYNC0 is a PULSE, so that the robot
// would drive on at its last speed for as long as it is asked. CLOSE stops it; without a session that is a SYNC2 out of
// order, from which SYNC0 begins anew.
static void begin(struct p2os *p2os, uint32_t now_ms)
{
    p2os->state = P2OS_CLOSING;
    p2os->asked_ms = now_ms;
    send_plain(p2os, CLOSE);
}

void p2os_start(struct p2os *p2os, void (*sender)(const uint8_t *data, uint32_t count), uint32_t now_ms)
{
    *p2os = (struct p2os){.send = sender};
    begin(p2os, now_ms);
}

// --- what comes

static uint16_t word_at(const uint8_t *at) { return (uint16_t)(at[0] | at[1] << 8); }

static void take_sonars(struct p2os *p2os, const uint8_t *at, uint32_t count, uint32_t now_ms)
{
    for (; count; --count, at += 3) {
        if (at[0] >= P2OS_SONARS)
            continue;
        p2os->sonar_mm[at[0]] = (uint16_t)(word_at(at + 1) * RANGE_MILLI / 1000u);
        p2os->sonar_ms[at[0]] = now_ms;
        p2os->sonars_heard |= 1u << at[0];
    }
}

// A SIP: status, x, y, heading, two speeds, battery, two of stalls and bumpers, control, flags, compass, sonars ...
static void take_sip(struct p2os *p2os, const uint8_t *body, uint32_t count, uint32_t now_ms)
{
    const uint32_t fixed = 20;
    if (count < fixed || count < fixed + 3u * body[19])
        return;
    p2os->motors_on = body[16] & 1;
    take_sonars(p2os, body + fixed, body[19], now_ms);
}

static void open_session(struct p2os *p2os, uint32_t now_ms)
{
    p2os->state = P2OS_OPEN;
    p2os->asked_ms = p2os->opened_ms = now_ms;
    p2os->sonars_heard = 0;
    send_plain(p2os, OPEN);
    send_number(p2os, ENABLE, 1);
    send_number(p2os, SONAR, 1);
    p2os->speed = p2os->turn = 0;
    p2os->told_ms = now_ms;
}

static void take_packet(struct p2os *p2os, const uint8_t *body, uint32_t count, uint32_t now_ms)
{
    p2os->heard_ms = now_ms;
    if (p2os->state == P2OS_OPEN) {
        if ((body[0] & 0xF0) == 0x30)
            take_sip(p2os, body, count, now_ms);
        return;
    }
    if (p2os->state == P2OS_CLOSING || body[0] != (uint8_t)p2os->state)
        return; // late, or of a session before
    if (p2os->state == P2OS_SYNC2)
        open_session(p2os, now_ms); // the names of the robot are in this packet
    else
        ask(p2os, p2os->state + 1, now_ms);
}

// Forgets the first byte of a packet that was none, and begins again with what is behind it.
static void resume(struct p2os *p2os)
{
    uint32_t begin = 1;
    while (begin < p2os->have && p2os->frame[begin] != HEADER_0)
        ++begin;
    p2os->have -= begin;
    for (uint32_t i = 0; i < p2os->have; ++i)
        p2os->frame[i] = p2os->frame[begin + i];
}

// Looks at what there is. False if it needs more bytes.
static bool look(struct p2os *p2os, uint32_t now_ms)
{
    const uint8_t *frame = p2os->frame;
    if (p2os->have == 0)
        return false;
    if (frame[0] != HEADER_0 || (p2os->have > 1 && frame[1] != HEADER_1) || (p2os->have > 2 && frame[2] < 3)) {
        resume(p2os);
        return true;
    }
    if (p2os->have < 3 || p2os->have < 3u + frame[2])
        return false;
    uint32_t count = frame[2] - 2u;
    if (checksum(frame + 3, count) == (frame[3 + count] << 8 | frame[4 + count])) {
        take_packet(p2os, frame + 3, count, now_ms);
        p2os->have = 0;
    } else {
        resume(p2os);
    }
    return true;
}

void p2os_take(struct p2os *p2os, uint8_t byte, uint32_t now_ms)
{
    p2os->frame[p2os->have++] = byte;
    while (look(p2os, now_ms)) {
    }
}

// --- what goes

void p2os_poll(struct p2os *p2os, uint32_t now_ms)
{
    uint32_t since_ms = now_ms - p2os->asked_ms;
    if (p2os->state == P2OS_OPEN) {
        if (now_ms - p2os->heard_ms >= SILENT_MS) {
            begin(p2os, now_ms);
        } else if (since_ms >= PULSE_MS) {
            p2os->asked_ms = now_ms;
            send_plain(p2os, PULSE);
        }
    } else if (p2os->state == P2OS_CLOSING) {
        if (since_ms >= CLOSING_MS)
            ask(p2os, P2OS_SYNC0, now_ms);
    } else if (since_ms >= ASK_AGAIN_MS) {
        begin(p2os, now_ms);
    }
}

void p2os_drive(struct p2os *p2os, int16_t speed, int16_t turn, uint32_t now_ms)
{
    bool again = now_ms - p2os->told_ms >= TELL_AGAIN_MS;
    if (p2os->state != P2OS_OPEN || (!again && speed == p2os->speed && turn == p2os->turn))
        return;
    if (again && !p2os->motors_on)
        send_number(p2os, ENABLE, 1); // a stall or an emergency stop may have taken it away
    send_number(p2os, VEL, speed);
    send_number(p2os, RVEL, turn);
    p2os->speed = speed;
    p2os->turn = turn;
    p2os->told_ms = now_ms;
}
