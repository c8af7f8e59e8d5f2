// SPDX-License-Identifier: GPL-2.0-or-later

#include "check.h"

#include "chip/cpu.h"
#include "console.h"
#include "startup.h"
#include "text.h"

#define TALLY_IS_MINE 0x7E57A11Eu

static struct {
    uint32_t mark; // TALLY_IS_MINE once the rest means something
    uint32_t stage;
    uint32_t ok;
    uint32_t failed;
} tally NOINIT;

static bool started; // since this reset

static void start(bool keep)
{
    if (started)
        return;
    started = true;
    if (keep && tally.mark == TALLY_IS_MINE)
        return;
    tally.mark = TALLY_IS_MINE;
    tally.stage = tally.ok = tally.failed = 0;
}

static void count(bool ok)
{
    start(false);
    ++*(ok ? &tally.ok : &tally.failed);
}

uint32_t check_stage(bool expected)
{
    start(expected);
    return tally.stage;
}

void check_next_stage(uint32_t stage) { tally.stage = stage; }

void check_keep(volatile uint32_t *registers)
{
    registers[0] = tally.ok;
    registers[1] = tally.failed;
}

void check_resume(volatile const uint32_t *registers)
{
    start(false);
    tally.ok = registers[0];
    tally.failed = registers[1];
}

static void finish_line(struct line *line)
{
    line_text(line, "\n");
    console_write(line->text);
}

static void report(bool ok, const char *name, uint32_t got, uint32_t low, uint32_t high)
{
    struct line line = EMPTY_LINE;
    count(ok);
    line_text(&line, ok ? "ok " : "FAIL ");
    line_text(&line, name);
    if (!ok) {
        line_text(&line, " got=");
        line_hex(&line, got);
        line_text(&line, " want=");
        line_hex(&line, low);
        if (high != low) {
            line_text(&line, "..");
            line_hex(&line, high);
        }
    }
    finish_line(&line);
}

void check_equal(const char *name, uint32_t got, uint32_t want) { report(got == want, name, got, want, want); }

void check_range(const char *name, uint32_t got, uint32_t low, uint32_t high)
{
    report(low <= got && got <= high, name, got, low, high);
}

void check_done(void)
{
    struct line line = EMPTY_LINE;
    start(false);
    tally.mark = 0;
    line_text(&line, "done ");
    line_decimal(&line, tally.ok);
    line_text(&line, " ok ");
    line_decimal(&line, tally.failed);
    line_text(&line, " failed");
    finish_line(&line);
    console_exit(tally.failed);
}

// A self-test that falls over says where: got is the address of the instruction, want the number of the exception.
void unhandled_exception(const struct exception_frame *frame)
{
    report(false, "unhandled-exception", frame->pc, READ_SPECIAL("ipsr"), READ_SPECIAL("ipsr"));
    check_done();
}
