// SPDX-License-Identifier: GPL-2.0-or-later
//
// The demonstration of a Nucleo-H753ZI, at 480 MHz with over-drive; see nucleo_demo.h.

#include "h753/clock.h"
#include "h753/handlers.h"
#include "h753/registers.h"

#define LD2_PORT 'E'
#define LD2 1
#define CORE_HZ CPU_HZ
#define GREETING "Nucleo-H753ZI at 480 MHz\r\n"

static void open_port_gates(void)
{
    RCC->AHB4ENR |= RCC_AHB4_GPIO('B') | RCC_AHB4_GPIO('C') | RCC_AHB4_GPIO('D') | RCC_AHB4_GPIO('E');
}

static void open_usart_gate(void)
{
    RCC->APB1LENR |= RCC_APB1L_USART3;
}

#include "nucleo_demo.h"
