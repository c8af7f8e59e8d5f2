// SPDX-License-Identifier: GPL-2.0-or-later
//
// What only this chip has: its memories at all their addresses (RM0410, table 1), clocks up to 216 MHz (sections 4.1.4 and
// 5), the flash with its sectors and errors (section 3), EXTI by SYSCFG (sections 7 and 11), the signature.

#include "check.h"
#include "chip/cpu.h"
#include "f767/clock.h"
#include "f767/handlers.h"
#include "f767/registers.h"

#define SECTOR_11 0x081C0000u
#define ITCM_FLASH(axim) ((axim) - 0x08000000u + 0x00200000u)

enum { PIN = 12, BUTTON = 13 }; // lines of EXTI

static volatile uint32_t flash_interrupts, pin_interrupts;

void FLASH_IRQHandler(void)
{
    ++flash_interrupts;
    FLASH->SR = FLASH_SR_EOP | FLASH_SR_OPERR;
}

void EXTI15_10_IRQHandler(void)
{
    ++pin_interrupts;
    EXTI->PR = EXTI->PR & (1u << PIN | 1u << BUTTON);
}

static void memories(void)
{
    volatile uint32_t *itcm = (volatile uint32_t *)0x00003FFCu, *dtcm = (volatile uint32_t *)0x2001FFFCu;
    volatile uint32_t *sram1 = dtcm + 1, *sram2 = (volatile uint32_t *)0x2007C000u;
    *itcm = 0x11111111;
    *dtcm = 0x22222222;
    *sram1 = 0x33333333;
    *sram2 = 0x44444444;
    check_equal("itcm-ram", *itcm, 0x11111111);
    check_equal("end-of-dtcm", *dtcm, 0x22222222);
    check_equal("sram1-behind-it", *sram1, 0x33333333);
    check_equal("sram2", *sram2, 0x44444444);
    check_equal("flash-by-itcm", *(volatile uint32_t *)0x00200004u, *(volatile uint32_t *)0x08000004u);
    check_equal("device", DBGMCU_IDCODE & 0xFFF, 0x451);
    check_equal("kilobytes-of-flash", *(volatile uint16_t *)0x1FF0F442u, 2048);
    check("unique-id", UNIQUE_ID[0] != 0xFFFFFFFFu && (UNIQUE_ID[0] | UNIQUE_ID[1] | UNIQUE_ID[2]) != 0);
    check_equal("option-bytes", *(volatile uint16_t *)0x1FFF0000u, 0xAAFF);
    check_equal("boot-address", *(volatile uint16_t *)0x1FFF0010u, 0x0080);
}

static void reset_values(void)
{
    check_equal("CR", RCC->CR & 0xFF00FFu, 0x83);
    check_equal("PLLCFGR", RCC->PLLCFGR, 0x24003010);
    check_equal("CFGR", RCC->CFGR, 0);
    check_equal("AHB1ENR", RCC->AHB1ENR, 1u << 20);
    check_equal("ACR", FLASH->ACR, 0);
    check_equal("OPTCR", FLASH->OPTCR, 0xFFFFAAFD);
    check_equal("OPTCR1", FLASH->OPTCR1, 0x00400080);
    RCC->APB1ENR |= RCC_APB1_PWR;
    check_equal("CR1", PWR->CR1, 0xC000);
}

static void clocks(void)
{
    uint32_t start = DWT->CYCCNT;
    clock_start();
    uint32_t took = DWT->CYCCNT - start; // nearly all of it at 16 MHz
    check_range("us-to-216-mhz", took / 16, 300, 500);
    check_equal("over-drive", PWR->CSR1 & (PWR_CSR1_ODRDY | PWR_CSR1_ODSWRDY), PWR_CSR1_ODRDY | PWR_CSR1_ODSWRDY);
    uint32_t locked = RCC->PLLCFGR;
    RCC->PLLCFGR = locked + 1;
    check_equal("pll-settings-hold", RCC->PLLCFGR, locked);
    RCC->CR &= ~RCC_CR_PLLON;
    check("pll-holds", RCC->CR & RCC_CR_PLLON);
    PWR->CR1 &= ~PWR_CR1_VOS_SCALE1;
    check_equal("scale-holds", PWR->CR1 & PWR_CR1_VOS_SCALE1, PWR_CR1_VOS_SCALE1);
    GPIO('E')->PUPDR = 2;
    check_equal("gate-shut", GPIO('E')->PUPDR, 0);
    RCC->AHB1ENR |= RCC_AHB1_GPIO('E');
    DSB();
    check_equal("nothing-got-through", GPIO('E')->PUPDR, 0);
    GPIO('E')->PUPDR = 1;
    check_equal("gate-open", GPIO('E')->PUPDR, 1);
    RCC->AHB1RSTR = RCC_AHB1_GPIO('E');
    RCC->AHB1RSTR = 0;
    check_equal("reset-by-rcc", GPIO('E')->PUPDR, 0);
}

static uint32_t wait_for_flash(void)
{
    uint32_t start = DWT->CYCCNT;
    while (FLASH->SR & FLASH_SR_BSY) {
    }
    return (DWT->CYCCNT - start) / 216;
}

static uint32_t take_errors(void)
{
    uint32_t errors = FLASH->SR & 0xF0u;
    FLASH->SR = errors;
    return errors;
}

static void flash(void)
{
    volatile uint32_t *word = (volatile uint32_t *)SECTOR_11;
    *word = 0;
    DSB();
    check_equal("locked", *word, 0xFFFFFFFF);
    check_equal("ERSERR", take_errors(), FLASH_SR_ERSERR);
    FLASH->KEYR = 0x45670123;
    FLASH->KEYR = 0xCDEF89AB;
    check_equal("unlocked", FLASH->CR & FLASH_CR_LOCK, 0);
    FLASH->CR = FLASH_CR_PSIZE_32 | FLASH_CR_PG;
    *(volatile uint16_t *)SECTOR_11 = 0;
    DSB();
    check_equal("PGPERR", take_errors(), FLASH_SR_PGPERR);
    *word = 0x12345678;
    DSB();
    wait_for_flash();
    check_equal("programmed", *word, 0x12345678);
    check_equal("and-by-itcm", *(volatile uint32_t *)ITCM_FLASH(SECTOR_11), 0x12345678);
    *word = 0xFF00FF00;
    DSB();
    wait_for_flash();
    check_equal("only-ones-become-zeros", *word, 0x12005600);
    FLASH->CR = FLASH_CR_PSIZE_32 | FLASH_CR_SER | 11u << FLASH_CR_SNB_SHIFT | FLASH_CR_EOPIE;
    interrupt_enable(FLASH_IRQ, 4);
    FLASH->CR |= FLASH_CR_STRT;
    DSB();
    wait_for_flash();
    check_equal("erased", *word, 0xFFFFFFFF);
    check_equal("interrupt", flash_interrupts, 1);
    FLASH->CR = FLASH_CR_LOCK;
    FLASH->CR = FLASH_CR_PG;
    check_equal("locked-again", FLASH->CR, FLASH_CR_LOCK);
}

static void pull(uint32_t how) { GPIO('G')->PUPDR = how << 2 * PIN; }

// PG12 is moved by its pulls; nothing may be attached to it.
static void edges_of_a_pin(void)
{
    RCC->AHB1ENR |= RCC_AHB1_GPIO('G');
    pull(2);
    SYSCFG_EXTICR[PIN / 4] = (uint32_t)('G' - 'A') << PIN % 4 * 4;
    EXTI->FTSR = 1u << PIN;
    EXTI->IMR = 1u << PIN;
    pull(1);
    DSB();
    check_equal("rising-is-not-asked-for", pin_interrupts, 0);
    pull(2);
    DSB();
    check_equal("falling", pin_interrupts, 1);
    EXTI->IMR = 0;
    EXTI->FTSR = 0;
}

static void external_interrupts(void)
{
    RCC->APB2ENR |= RCC_APB2_SYSCFG;
    interrupt_enable(EXTI15_10_IRQ, 4);
    edges_of_a_pin();
    EXTI->IMR = 1u << BUTTON;
    EXTI->SWIER = 1u << BUTTON;
    DSB();
    check_equal("by-software", pin_interrupts, 2);
    check_equal("swier-cleared-by-pr", EXTI->SWIER, 0);
    EXTI->IMR |= 1u << 24;
    check_equal("lines", EXTI->IMR, 1u << 24 | 1u << BUTTON);
}

int main(void)
{
    DEMCR |= DEMCR_TRCENA;
    DWT_LAR = 0xC5ACCE55; // the debug blocks of a Cortex-M7 ignore writes otherwise
    DWT->CTRL |= 1;
    memories();
    reset_values();
    clocks();
    flash();
    external_interrupts();
    check_done();
}
