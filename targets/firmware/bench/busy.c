// SPDX-License-Identifier: GPL-2.0-or-later
//
// A core that never rests: CRC by table-less bits, an 8x8 matrix product, a bubble sort, a linked list, a state machine in a
// switch, divisions. PA0 toggles after each round; PC13 goes low for good if a round ever gives another result than the
// first. Apart from the two pins no peripheral is touched, and rounds is the number of rounds so far.

#include "chip/stm32f103.h"
#include "clock.h"
#include "pin.h"

#define SIZE 8

static uint32_t random_state;

static uint32_t next_random(void)
{
    random_state = random_state * 1664525u + 1013904223u;
    return random_state >> 8;
}

static uint32_t crc(uint32_t value)
{
    for (int bit = 0; bit < 32; ++bit)
        value = value & 1 ? value >> 1 ^ 0xEDB88320u : value >> 1;
    return value;
}

static uint32_t crcs(void)
{
    uint32_t sum = 0xFFFFFFFFu;
    for (int i = 0; i < 64; ++i)
        sum = crc(sum ^ next_random());
    return sum;
}

static uint32_t matrix(void)
{
    static int32_t a[SIZE][SIZE], b[SIZE][SIZE], product[SIZE][SIZE];
    for (int i = 0; i < SIZE; ++i)
        for (int j = 0; j < SIZE; ++j) {
            a[i][j] = (int32_t)(next_random() & 0xFF);
            b[i][j] = (int32_t)(next_random() & 0xFF) - 128;
        }
    uint32_t sum = 0;
    for (int i = 0; i < SIZE; ++i)
        for (int j = 0; j < SIZE; ++j) {
            int32_t cell = 0;
            for (int k = 0; k < SIZE; ++k)
                cell += a[i][k] * b[k][j];
            product[i][j] = cell;
            sum += (uint32_t)product[i][j];
        }
    return sum;
}

static uint32_t sort(void)
{
    static uint16_t values[48];
    for (unsigned i = 0; i < 48; ++i)
        values[i] = (uint16_t)next_random();
    for (unsigned end = 47; end; --end)
        for (unsigned i = 0; i < end; ++i)
            if (values[i] > values[i + 1]) {
                uint16_t kept = values[i];
                values[i] = values[i + 1];
                values[i + 1] = kept;
            }
    return values[0] | (uint32_t)values[47] << 16;
}

static uint32_t list(void)
{
    static struct node {
        struct node *next;
        uint32_t value;
    } nodes[32];
    struct node *head = 0;
    for (unsigned i = 0; i < 32; ++i) {
        nodes[i] = (struct node){head, next_random()};
        head = &nodes[i];
    }
    struct node *reversed = 0;
    while (head) {
        struct node *next = head->next;
        head->next = reversed;
        reversed = head;
        head = next;
    }
    uint32_t sum = 0;
    for (; reversed; reversed = reversed->next)
        sum = sum * 31 + reversed->value;
    return sum;
}

static uint32_t machine(void)
{
    uint32_t state = 0, result = 0;
    for (int i = 0; i < 200; ++i) {
        switch (state) {
        case 0:
            state = next_random() & 7;
            break;
        case 1:
        case 2:
            result += state;
            state += 3;
            break;
        case 3:
            result ^= result << 5;
            state = 6;
            break;
        case 4:
            result -= 7;
            state = 1;
            break;
        case 5:
            result = result << 1 | result >> 31;
            state = 0;
            break;
        case 6:
            result += next_random() & 0xF;
            state = 7;
            break;
        default:
            state = 0;
            break;
        }
    }
    return result;
}

static uint32_t divisions(void)
{
    uint32_t sum = 0;
    for (uint32_t i = 1; i < 64; ++i)
        sum += next_random() / i + next_random() % i;
    return sum;
}

volatile uint32_t rounds;

int main(void)
{
    clock_72mhz();
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_GPIOC;
    pin_mode(GPIOA, 0, PIN_OUTPUT);
    pin_write(GPIOC, 13, true);
    pin_mode(GPIOC, 13, PIN_OUTPUT);
    for (uint32_t first = 0;;) {
        random_state = 1;
        uint32_t result = crcs() ^ matrix() ^ sort() ^ list() ^ machine() ^ divisions();
        if (rounds == 0)
            first = result;
        else if (result != first)
            pin_write(GPIOC, 13, false);
        rounds = rounds + 1;
        pin_toggle(GPIOA, 0);
    }
}
