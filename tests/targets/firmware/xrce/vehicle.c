// SPDX-License-Identifier: GPL-2.0-or-later
//
// The vehicle interface's end of the client, for a test on the host: a task that fetches its messages every 10 ms, keeps them
// for the test, and answers requests. What it keeps are payloads of messages (stack/messages.h), by their id.

#include <string.h>

#define VEHICLE_IMAGE
#include "vehicle_interface/stack/messages.c"
#include "vehicle_interface/stack/micro_ros.c"

#define ROOM (1u << 20)
#define TASK_MS 10u

struct kept {
    uint32_t endpoint, count, big_endian;
    uint8_t data[XRCE_WHOLE];
};

static struct {
    uint32_t tick;
    uint8_t in[ROOM], out[ROOM];
    uint32_t in_put, in_got, out_count;
    struct kept heard[256];
    uint32_t heard_count;
} here;

uint32_t kernel_tick(void) { return here.tick; }

bool stack_line_get(uint8_t *byte)
{
    if (here.in_got == here.in_put)
        return false;
    *byte = here.in[here.in_got++ % ROOM];
    return true;
}

void stack_line_send(const uint8_t *data, uint32_t count)
{
    if (here.out_count + count > ROOM)
        return;
    memcpy(here.out + here.out_count, data, count);
    here.out_count += count;
}

// A library has one vehicle interface in its life: copy it for another one.
void begin(int domain, uint32_t lost, uint32_t now)
{
    (void)domain, (void)lost;
    here.tick = now;
}

void receive(const uint8_t *data, uint32_t count, uint32_t now)
{
    here.tick = now;
    for (uint32_t i = 0; i < count; ++i)
        here.in[here.in_put++ % ROOM] = data[i];
}

int write_sample(uint32_t endpoint, const uint8_t *data, uint32_t count, uint32_t now)
{
    struct board_message message = {.id = (uint8_t)endpoint};
    uint8_t frame[MAX_FRAME];
    here.tick = now;
    memcpy((uint8_t *)&message + 1, data, count < sizeof message - 1 ? count : sizeof message - 1);
    micro_ros_make(frame, (const uint8_t *)&message, message_bytes(message.id));
    return 1;
}

static void take(const struct agent_message *message, uint32_t count)
{
    struct kept *one = &here.heard[here.heard_count++ % 256];
    *one = (struct kept){.endpoint = message->id, .count = count};
    memcpy(one->data, message, count);
    if (message->id == MODE_REQUEST)
        write_sample(MODE_RESPONSE, (const uint8_t[]){message->request.sequence, message->request.mode == 1}, 2, here.tick);
}

uint32_t advance(uint32_t now)
{
    uint8_t byte;
    const uint8_t *payload;
    here.tick = now;
    while (micro_ros_get(&byte)) {
        uint32_t count = micro_ros_take(0, byte, &payload);
        take((const struct agent_message *)payload, count);
    }
    return TASK_MS;
}

int state(void) { return client.state; }

uint32_t unacknowledged(void) { return client.output.count; }

uint32_t take_out(uint8_t *to)
{
    uint32_t count = here.out_count;
    memcpy(to, here.out, count);
    here.out_count = 0;
    return count;
}

uint32_t take_heard(struct kept *to)
{
    uint32_t count = here.heard_count;
    memcpy(to, here.heard, sizeof here.heard);
    here.heard_count = 0;
    return count;
}
