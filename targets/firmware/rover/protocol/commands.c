// SPDX-License-Identifier: GPL-2.0-or-later

#include "rover/protocol/commands.h"

#include <stdbool.h>

#include "rover/board/leds.h"
#include "rover/control/drive.h"
#include "rover/options.h"
#include "rover/protocol/bytes.h"
#include "rover/protocol/decoder.h"
#include "rover/protocol/reports.h"
#include "rover/protocol/telemetry.h"

#define SILENCE_US 1000000u // G2 config.h, HEARTBEAT_TIMEOUT_IN_MS
#define FULL_SPEED 255.0f   // of an int16, as duty of an 8-bit PWM (DOC, 0x03)

struct telemetry telemetry;

static uint32_t heard_us; // the last sound frame
static bool lost;

// --- what each command does; parameters stand behind the opcode

static void led_on(const uint8_t *parameters)
{
    (void)parameters;
    led_put(LED_TEST, true);
}

static void led_off(const uint8_t *parameters)
{
    (void)parameters;
    led_put(LED_TEST, false);
}

#if SCHEMA == SCHEMA_V2

static void update_motors(const uint8_t *parameters)
{
    drive_throttles(get_float(parameters), get_float(parameters + 4), parameters[8]);
}

#else

static float speed_at(const uint8_t *at)
{
    int16_t speed = SCHEMA == SCHEMA_V1 ? (int16_t)(at[0] << 8 | at[1]) : (int16_t)(at[1] << 8 | at[0]);
    return (float)speed / FULL_SPEED;
}

static void update_motors(const uint8_t *parameters)
{
    drive_throttles(speed_at(parameters), speed_at(parameters + 2), parameters[4]);
}

#endif

static __attribute__((unused)) void update_setpoints(const uint8_t *parameters)
{
    drive_setpoints(get_float(parameters), get_float(parameters + 4), parameters[8]);
}

static __attribute__((unused)) void reset_pid(const uint8_t *parameters)
{
    const uint8_t *gains = parameters + (DEFECT_PID_OFFSETS ? 4 : 0);
    drive_gains(get_float(gains), get_float(gains + 4), get_float(gains + 8)); // kp, kd, ki
}

static const struct command {
    void (*carry_out)(const uint8_t *parameters);
    uint8_t bytes; // of parameters; more are ignored
} COMMANDS[] = {
    [LED_ON] = {led_on, 0},
    [LED_OFF] = {led_off, 0},
    [UPDATE_MOTORS] = {update_motors, SCHEMA == SCHEMA_V2 ? 9 : 5},
#if SCHEMA != SCHEMA_V1
    [UPDATE_SETPOINTS] = {update_setpoints, 9},
#endif
#if SCHEMA == SCHEMA_V2
    [RESET_PID] = {reset_pid, 12},
#endif
};

#define COMMAND_COUNT (sizeof COMMANDS / sizeof *COMMANDS)

static enum error execute(const uint8_t *payload, uint32_t count)
{
    if (payload[0] >= COMMAND_COUNT)
        return UNKNOWN_OPCODE;
    const struct command *command = &COMMANDS[payload[0]];
    if (!DEFECT_NO_LEN_CHECK && count < 1u + command->bytes)
        return INVALID_LENGTH;
    command->carry_out(payload + 1);
    return SUCCESS;
}

// --- what is counted and told

static bool is_reported(uint8_t opcode)
{
    if (DEFECT_NO_0X81)
        return false;
    return !DEFECT_0X81_LEDS_ONLY || opcode == LED_ON || opcode == LED_OFF;
}

// Frames that come again do not bring the motors back: the next command does.
void commands_tick(uint32_t now_us)
{
    if (DEFECT_NO_LINK_TIMEOUT || lost || now_us - heard_us < SILENCE_US)
        return;
    lost = true;
    led_put(LED_ALARM, true);
    drive_stop();
}

void packet_received(const uint8_t *payload, uint32_t count, uint32_t now_us)
{
    if (!DEFECT_POLLED) // which takes what has come first, and looks at the time then
        commands_tick(now_us); // a host that comes back too late was lost, even if no tick has seen it
    heard_us = now_us;
    lost = false;
    led_put(LED_ALARM, false);
    if (payload[0] == REQUEST_TMY) {
        report_general();
        return;
    }
    ++telemetry.accepted;
    led_toggle(DEFECT_LED_SHARED ? LED_TEST : LED_ALIVE);
    telemetry.last_error = (uint8_t)execute(payload, count);
    telemetry.last_opcode = payload[0];
    if (is_reported(payload[0]))
        report_execution();
}

void packet_rejected(enum error error)
{
    ++telemetry.rejected;
    telemetry.last_error = (uint8_t)error;
}
