// SPDX-License-Identifier: GPL-2.0-or-later
//
// What only this chip has: its memories at all their addresses (RM0433, section 2.3), the supply and clocks up to 480 MHz
// (sections 6.4.1, 6.6.2 and 8.5), both banks of flash with their flash words and errors (section 4), EXTI by SYSCFG
// (sections 12 and 20), semaphores (section 10), the signature.

#include "check.h"
#include "chip/cpu.h"
#include "h753/clock.h"
#include "h753/handlers.h"
#include "h753/registers.h"

#define SECTOR_7_OF_BANK_2 0x081E0000u

enum { PIN = 12, BUTTON = 13 }; // lines of EXTI

static volatile uint32_t flash_interrupts, pin_interrupts, hsem_interrupts, rcc_interrupts;

void FLASH_IRQHandler(void)
{
    ++flash_interrupts;
    FLASH(2)->CCR = FLASH_SR_EOP;
}

void RCC_IRQHandler(void)
{
    ++rcc_interrupts;
    RCC->CICR = RCC->CIFR;
}

void EXTI15_10_IRQHandler(void)
{
    ++pin_interrupts;
    EXTI->CPUPR1 = EXTI->CPUPR1 & (1u << PIN | 1u << BUTTON);
}

void HSEM_IRQHandler(void)
{
    ++hsem_interrupts;
    HSEM->C1ICR = HSEM->C1MISR;
}

static void memory(const char *name, uint32_t address, uint32_t value)
{
    *(volatile uint32_t *)address = value;
    check_equal(name, *(volatile uint32_t *)address, value);
}

static void memories(void)
{
    memory("itcm-ram", 0x0000FFFC, 0x11111111);
    memory("end-of-dtcm", 0x2001FFFC, 0x22222222);
    memory("axi-sram", 0x24000000, 0x33333333);
    memory("end-of-axi-sram", 0x2407FFFC, 0x44444444);
    memory("sram1", 0x30000000, 0x55555555);
    memory("end-of-sram3", 0x30047FFC, 0x66666666);
    memory("sram4", 0x3800FFFC, 0x77777777);
    check_equal("sram1-alias", *(volatile uint32_t *)0x10000000u, 0x55555555);
    check_equal("itcm-is-still-itself", *(volatile uint32_t *)0x0000FFFCu, 0x11111111);
    check_equal("device", DBGMCU_IDC, 0x20036450);
    check_equal("kilobytes-of-flash", FLASH_KB, 2048);
    check("unique-id", UNIQUE_ID[0] != 0xFFFFFFFFu && (UNIQUE_ID[0] | UNIQUE_ID[1] | UNIQUE_ID[2]) != 0);
}

static void reset_values(void)
{
    check_equal("CR", RCC->CR & 0xFF0000FFu, 0x25);
    check_equal("PLLCKSELR", RCC->PLLCKSELR, 0x02020200);
    check_equal("PLLCFGR", RCC->PLLCFGR, 0x01FF0000);
    check_equal("PLL1DIVR", RCC->PLL[0].DIVR, 0x01010280);
    check_equal("APB4ENR", RCC->APB4ENR, 1u << 16);
    check_equal("ACR", FLASH_ACR, 0x37);
    check_equal("read-protection", FLASH_OPTSR_CUR >> 8 & 0xFF, 0xAA);
    check_equal("boot-addresses", FLASH_BOOT_CURR, 0x1FF00800);
    check_equal("CR3", PWR->CR3, PWR_CR3_SCUEN | PWR_CR3_LDOEN);
    check_equal("no-voltage-is-ready", PWR->CSR1 & PWR_CSR1_ACTVOSRDY, 0);
    check_equal("D3CR", PWR->D3CR, 0x4000);
}

static void supply_once(void)
{
    PWR->D3CR = PWR_D3CR_VOS_SCALE1;
    for (int turn = 0; turn < 1000; ++turn)
        __asm volatile("nop");
    check_equal("VOS-waits-for-the-supply", PWR->D3CR & PWR_D3CR_VOSRDY, 0);
    PWR->D3CR = 0x4000;
}

static void gates(void)
{
    GPIO('E')->PUPDR = 2;
    check_equal("gate-shut", GPIO('E')->PUPDR, 0);
    RCC->AHB4ENR |= RCC_AHB4_GPIO('E');
    DSB();
    check_equal("nothing-got-through", GPIO('E')->PUPDR, 0);
    GPIO('E')->PUPDR = 1;
    check_equal("gate-open", GPIO('E')->PUPDR, 1);
    RCC->AHB4RSTR = RCC_AHB4_GPIO('E');
    RCC->AHB4RSTR = 0;
    check_equal("reset-by-rcc", GPIO('E')->PUPDR, 0);
    RCC_C1_AHB4ENR |= RCC_AHB4_GPIO('F');
    check("the-same-for-cpu-1", RCC->AHB4ENR & RCC_AHB4_GPIO('F'));
}

static void clocks(void)
{
    interrupt_enable(RCC_IRQ, 4);
    RCC->CIER = 1u << 6; // PLL1 is ready
    uint32_t start = DWT->CYCCNT;
    clock_start();
    uint32_t took = DWT->CYCCNT - start; // nearly all of it at 64 MHz
    check_range("us-to-480-mhz", took / 64, 100, 300);
    check_equal("pll-interrupt", rcc_interrupts, 1);
    check_equal("supply-is-locked", PWR->CR3 & (PWR_CR3_SCUEN | PWR_CR3_LDOEN), PWR_CR3_LDOEN);
    PWR->CR3 = PWR_CR3_SCUEN;
    check_equal("and-stays", PWR->CR3 & (PWR_CR3_SCUEN | PWR_CR3_LDOEN), PWR_CR3_LDOEN);
    uint32_t locked = RCC->PLL[0].DIVR;
    RCC->PLL[0].DIVR = locked + 1;
    check_equal("pll-settings-hold", RCC->PLL[0].DIVR, locked);
    RCC->CR &= ~RCC_CR_PLL1ON;
    check("pll-holds", RCC->CR & RCC_CR_PLL1ON);
    RCC->CR &= ~RCC_CR_CSION;
    check("what-feeds-it-holds", RCC->CR & RCC_CR_CSION);
}

static void wait_for_flash(void)
{
    while (FLASH(2)->SR & FLASH_SR_QW) {
    }
}

static uint32_t take_errors(void)
{
    uint32_t errors = FLASH(2)->SR & 0x002E0000u;
    FLASH(2)->CCR = errors;
    return errors;
}

static void flash_errors(volatile uint32_t *word)
{
    word[0] = 0;
    DSB();
    check_equal("PGSERR", take_errors(), FLASH_SR_PGSERR);
    FLASH(2)->KEYR = 0x45670123;
    FLASH(2)->KEYR = 0xCDEF89AB;
    check_equal("unlocked", FLASH(2)->CR & FLASH_CR_LOCK, 0);
    check_equal("bank-1-is-not", FLASH(1)->CR & FLASH_CR_LOCK, FLASH_CR_LOCK);
    FLASH(2)->CR = FLASH_CR_PSIZE_64 | FLASH_CR_PG;
    word[0] = 0;
    word[8] = 0;
    DSB();
    check_equal("INCERR", take_errors(), FLASH_SR_INCERR);
    word[1] = 0;
    word[1] = 0;
    DSB();
    check_equal("STRBERR", take_errors(), FLASH_SR_STRBERR);
    check_equal("nothing-was-programmed", word[0] & word[1] & word[8], 0xFFFFFFFF);
}

static void flash(void)
{
    volatile uint32_t *word = (volatile uint32_t *)SECTOR_7_OF_BANK_2;
    flash_errors(word);
    for (uint32_t index = 0; index < 7; ++index)
        word[index] = 0x01010101u * index;
    DSB();
    check_equal("buffer-is-not-empty", FLASH(2)->SR & (FLASH_SR_WBNE | FLASH_SR_BSY), FLASH_SR_WBNE);
    check_equal("not-before-it-is-full", word[1], 0xFFFFFFFF);
    word[7] = 0x77777777;
    DSB();
    check("busy", FLASH(2)->SR & FLASH_SR_QW);
    wait_for_flash();
    check_equal("programmed", word[1] | word[6] << 8, 0x06060606u << 8 | 0x01010101u);
    word[8] = 0x12345678;
    FLASH(2)->CR |= FLASH_CR_FW;
    DSB();
    wait_for_flash();
    check_equal("forced", word[8], 0x12345678);
    check_equal("the-rest-is-erased", word[9], 0xFFFFFFFF);
    FLASH(2)->CCR = FLASH_SR_EOP;
    FLASH(2)->CR = FLASH_CR_PSIZE_64 | FLASH_CR_SER | 7u << FLASH_CR_SNB_SHIFT | FLASH_CR_EOPIE;
    interrupt_enable(FLASH_IRQ, 4);
    uint32_t start = DWT->CYCCNT;
    FLASH(2)->CR |= FLASH_CR_START;
    DSB();
    uint32_t answer = DWT->CYCCNT - start;
    check_range("bank-1-runs-on", answer, 1, 1000);
    wait_for_flash();
    check_equal("erased", word[1] & word[8], 0xFFFFFFFF);
    check_equal("interrupt", flash_interrupts, 1);
    FLASH(2)->CR = FLASH_CR_LOCK;
    FLASH(2)->CR = FLASH_CR_PG;
    check_equal("locked-again", FLASH(2)->CR & 3u, FLASH_CR_LOCK);
}

static void pull(uint32_t how) { GPIO('G')->PUPDR = how << 2 * PIN; }

// PG12 is moved by its pulls; nothing may be attached to it.
static void edges_of_a_pin(void)
{
    RCC->AHB4ENR |= RCC_AHB4_GPIO('G');
    GPIO('G')->MODER &= ~(3u << 2 * PIN); // pins are analog after a reset
    pull(2);
    SYSCFG_EXTICR[PIN / 4] = (uint32_t)('G' - 'A') << PIN % 4 * 4;
    EXTI->FTSR1 = 1u << PIN;
    EXTI->CPUIMR1 |= 1u << PIN;
    pull(1);
    DSB();
    check_equal("rising-is-not-asked-for", pin_interrupts, 0);
    pull(2);
    DSB();
    check_equal("falling", pin_interrupts, 1);
    EXTI->CPUIMR1 &= ~(1u << PIN);
    EXTI->FTSR1 = 0;
}

static void external_interrupts(void)
{
    interrupt_enable(EXTI15_10_IRQ, 4);
    edges_of_a_pin();
    EXTI->CPUIMR1 |= 1u << BUTTON;
    EXTI->SWIER1 = 1u << BUTTON;
    DSB();
    check_equal("by-software", pin_interrupts, 2);
    check_equal("swier-cleared-by-pr", EXTI->SWIER1, 0);
    EXTI->RTSR1 = 0xFFFFFFFF;
    check_equal("configurable-lines", EXTI->RTSR1, 0x003FFFFF);
    EXTI->RTSR1 = 0;
    check_equal("direct-lines-are-unmasked", EXTI->CPUIMR1 & 0xFFC00000u, 0xFFC00000);
}

static void semaphores(void)
{
    RCC->AHB4ENR |= RCC_AHB4_HSEM;
    interrupt_enable(HSEM_IRQ, 4);
    HSEM->C1IER = 1u << 3;
    check_equal("taken-by-one-read", HSEM->RLR[3], HSEM_TAKEN | HSEM_CPU);
    HSEM->R[3] = HSEM_TAKEN | HSEM_CPU | 5u;
    check_equal("not-by-another", HSEM->R[3], HSEM_TAKEN | HSEM_CPU);
    HSEM->R[3] = HSEM_CPU | 5u;
    check("nor-released", HSEM->R[3] & HSEM_TAKEN);
    HSEM->R[3] = HSEM_CPU;
    DSB();
    check_equal("released", HSEM->R[3], 0);
    check_equal("hsem-interrupt", hsem_interrupts, 1);
}

int main(void)
{
    DEMCR |= DEMCR_TRCENA;
    DWT_LAR = 0xC5ACCE55; // the debug blocks of a Cortex-M7 ignore writes otherwise
    DWT->CTRL |= 1;
    memories();
    reset_values();
    supply_once();
    clocks();
    gates();
    flash();
    external_interrupts();
    semaphores();
    check_done();
}
