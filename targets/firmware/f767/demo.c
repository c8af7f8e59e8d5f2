// SPDX-License-Identifier: GPL-2.0-or-later
//
// The demonstration of a Nucleo-F767ZI, at 216 MHz with over-drive; see nucleo_demo.h.

#include "f767/clock.h"
#include "f767/handlers.h"
#include "f767/registers.h"

#define LD2_PORT 'B'
#define LD2 7
#define CORE_HZ HCLK_HZ
#define GREETING "Nucleo-F767ZI at 216 MHz\r\n"

static void open_port_gates(void)
{
    RCC->AHB1ENR |= RCC_AHB1_GPIO('B') | RCC_AHB1_GPIO('C') | RCC_AHB1_GPIO('D');
}

static void open_usart_gate(void)
{
    RCC->APB1ENR |= RCC_APB1_USART3;
}

#include "nucleo_demo.h"
