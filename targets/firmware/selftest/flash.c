// SPDX-License-Identifier: GPL-2.0-or-later
//
// Programming and erasing the flash memory (ST PM0075; times from DS5319, table 28), on its last page, which is left erased.
//
// The write protection is tested by programming the option bytes and resetting the chip, twice. Between erasing them and
// programming RDP again the chip is one power failure away from being read-protected; do not switch off a board here.

#include "check.h"
#include "chip/stm32f103.h"
#include "cycles.h"
#include "handlers.h"
#include "reset.h"
#include "startup.h"
#include "wait.h"

#define PAGE 0x0800FC00u
#define PAGE_BEFORE (PAGE - FLASH_PAGE_BYTES)
#define AT(address) (*(volatile uint16_t *)(address))
#define ALIAS(address) ((address) - FLASH_BASE) // the flash memory as seen at 0 (RM0008, 3.4)

#define CYCLES_PER_US 8u // this test stays on HSI, which the flash interface needs anyway
#define FLAGS (FLASH_SR_EOP | FLASH_SR_PGERR | FLASH_SR_WRPRTERR)

// --- A store that the bus refuses is noted, and skipped if the core says which one it was

static volatile uint32_t bus_faults;

void bus_fault_body(struct exception_frame *frame);

void bus_fault_body(struct exception_frame *frame)
{
    ++bus_faults;
    if (SCB->CFSR & CFSR_PRECISERR)
        frame->pc += AT(frame->pc) >> 11 >= 0x1D ? 4 : 2;
    SCB->CFSR = 0xFFFFFFFF;
}

__attribute__((naked)) void BusFault_Handler(void) { __asm volatile("mov r0, sp\n b bus_fault_body"); }

static uint32_t faults_of_store(volatile uint32_t *address, uint32_t value)
{
    bus_faults = 0;
    *address = value;
    DSB();
    return bus_faults;
}

// --- Operations. While one is under way any fetch from flash waits for its end (PM0075, 2.3): whoever wants to see BSY
// must run from RAM.

static volatile bool seen_busy;

static RAM_FUNCTION uint32_t wait_from_ram(void)
{
    uint32_t start = cycles();
    seen_busy = FLASH->SR & FLASH_SR_BSY;
    while (FLASH->SR & FLASH_SR_BSY) {
    }
    return cycles() - start;
}

static RAM_FUNCTION uint32_t program_from_ram(uint32_t address, uint16_t value)
{
    FLASH->CR = FLASH_CR_PG;
    AT(address) = value;
    seen_busy = FLASH->SR & FLASH_SR_BSY;
    uint32_t start = cycles();
    while (FLASH->SR & FLASH_SR_BSY) {
    }
    FLASH->CR = 0;
    return cycles() - start;
}

static RAM_FUNCTION uint32_t erase_from_ram(uint32_t page)
{
    FLASH->CR = FLASH_CR_PER;
    FLASH->AR = page;
    FLASH->CR = FLASH_CR_PER | FLASH_CR_STRT;
    uint32_t time = wait_from_ram();
    FLASH->CR = 0;
    return time;
}

static uint32_t take_flags(void)
{
    uint32_t flags = FLASH->SR & FLAGS;
    FLASH->SR = flags;
    return flags;
}

static void unlock(void)
{
    FLASH->KEYR = FLASH_KEY1;
    FLASH->KEYR = FLASH_KEY2;
}

// --- The first stage: everything that needs no reset

static void unlocking(void)
{
    check_equal("acr-reset", FLASH->ACR, FLASH_ACR_PRFTBE | FLASH_ACR_PRFTBS);
    FLASH->ACR = 0;
    check("prefetch-goes-off", wait_until(FLASH->ACR == 0));
    FLASH->ACR = FLASH_ACR_PRFTBE;
    check("prefetch-goes-on", wait_until(FLASH->ACR == (FLASH_ACR_PRFTBE | FLASH_ACR_PRFTBS)));
    check_equal("cr-reset", FLASH->CR, FLASH_CR_LOCK);
    check_equal("sr-reset", FLASH->SR, 0);
    check_equal("obr-unprotected", FLASH->OBR & (FLASH_OBR_OPTERR | FLASH_OBR_RDPRT), 0);
    unlock();
    check_equal("keys-unlock", FLASH->CR & FLASH_CR_LOCK, 0);
    FLASH->CR = FLASH_CR_LOCK;
    check_equal("lock-locks", FLASH->CR & FLASH_CR_LOCK, FLASH_CR_LOCK);
    FLASH->CR = FLASH_CR_PG;
    check_equal("locked-cr-keeps-its-value", FLASH->CR, FLASH_CR_LOCK);
    unlock();
    check_equal("keys-unlock-again", FLASH->CR & FLASH_CR_LOCK, 0);
}

static void erasing(void)
{
    AT(PAGE_BEFORE); // make sure that it is memory
    uint16_t neighbour = AT(PAGE_BEFORE + FLASH_PAGE_BYTES - 2);
    uint32_t time = erase_from_ram(PAGE + 6); // any address in the page will do
    check("erase-is-busy", seen_busy);
    check_range("erase-takes-20-to-40-ms", time, 20000 * CYCLES_PER_US - 20, 40000 * CYCLES_PER_US);
    check_equal("erase-ends-with-eop", take_flags(), FLASH_SR_EOP);
    uint32_t all = 0xFFFF;
    for (uint32_t address = PAGE; address < PAGE + FLASH_PAGE_BYTES; address += 2)
        all &= AT(address);
    check_equal("erase-leaves-ones", all, 0xFFFF);
    check_equal("erase-spares-neighbour", AT(PAGE_BEFORE + FLASH_PAGE_BYTES - 2), neighbour);
}

static void programming(void)
{
    uint32_t time = program_from_ram(PAGE, 0xA55A);
    check("program-is-busy", seen_busy);
    check_range("program-takes-40-to-70-us", time, 40 * CYCLES_PER_US - 20, 70 * CYCLES_PER_US);
    check_equal("program-ends-with-eop", take_flags(), FLASH_SR_EOP);
    check_equal("programmed", AT(PAGE), 0xA55A);
    check_equal("programmed-in-alias", AT(ALIAS(PAGE)), 0xA55A);
    check_equal("programmed-next-untouched", AT(PAGE + 2), 0xFFFF);

    program_from_ram(PAGE, 0xA550); // only ones would become zeros, but the interface asks for an erased half-word
    check_equal("program-twice-is-pgerr", take_flags() & FLASH_SR_PGERR, FLASH_SR_PGERR);
    check_equal("program-twice-changes-nothing", AT(PAGE), 0xA55A);
    program_from_ram(PAGE, 0); // the one exception
    check_equal("program-to-zero-is-no-error", take_flags(), FLASH_SR_EOP);
    check_equal("programmed-to-zero", AT(PAGE), 0);

    FLASH->CR = FLASH_CR_PG;
    AT(PAGE + 4) = 0x1234; // from flash: the core waits
    bool done = wait_until(!(FLASH->SR & FLASH_SR_BSY));
    FLASH->CR = 0;
    check("program-from-flash-ends", done);
    check_equal("programmed-from-flash", AT(PAGE + 4), 0x1234);
    take_flags();

    FLASH->CR = FLASH_CR_PG;
    check_equal("word-write-is-bus-fault", faults_of_store((volatile uint32_t *)(PAGE + 8), 0x11112222), 1);
    FLASH->CR = 0;
    take_flags();
    check_equal("word-write-changes-nothing", AT(PAGE + 8), 0xFFFF);
}

static void interrupts(void)
{
    FLASH->CR = FLASH_CR_PG | FLASH_CR_EOPIE;
    AT(PAGE + 12) = 0x4321;
    bool done = wait_until(!(FLASH->SR & FLASH_SR_BSY));
    check("program-with-eopie-ends", done);
    check("eopie-requests-interrupt", irq_is_pending(FLASH_IRQ));
    take_flags();
    irq_unpend(FLASH_IRQ);
    check("interrupt-gone-with-eop", !irq_is_pending(FLASH_IRQ));
    FLASH->CR = FLASH_CR_PG | FLASH_CR_ERRIE;
    AT(PAGE + 12) = 0x5555;
    wait_until(!(FLASH->SR & FLASH_SR_BSY));
    check("errie-requests-interrupt", irq_is_pending(FLASH_IRQ));
    FLASH->CR = 0;
    take_flags();
    irq_unpend(FLASH_IRQ);
}

static void signature(void)
{
    check("flash-size-is-64-kb-or-more", FLASH_SIZE_KB >= 64 && FLASH_SIZE_KB <= 128);
    check("unique-id-is-something", UNIQUE_ID[0] != 0xFFFFFFFF && (UNIQUE_ID[0] | UNIQUE_ID[1] | UNIQUE_ID[2]));
}

// --- Write protection: bit 7 of WRP1 stands for the last four pages of 64 KB, 0 for protected

static void option_wait(void)
{
    wait_from_ram();
    FLASH->CR = FLASH_CR_OPTWRE;
    take_flags();
}

// Erases the option bytes, and programs RDP and, if it protects anything, WRP1.
static void set_protection(uint16_t wrp1)
{
    unlock();
    FLASH->OPTKEYR = FLASH_KEY1;
    FLASH->OPTKEYR = FLASH_KEY2;
    check("option-keys-unlock", FLASH->CR & FLASH_CR_OPTWRE);
    FLASH->CR = FLASH_CR_OPTWRE | FLASH_CR_OPTER;
    FLASH->CR = FLASH_CR_OPTWRE | FLASH_CR_OPTER | FLASH_CR_STRT;
    option_wait();
    FLASH->CR = FLASH_CR_OPTWRE | FLASH_CR_OPTPG;
    *OPTION_RDP = OPTION_RDP_UNPROTECTED;
    option_wait();
    check_equal("rdp-and-its-complement", *OPTION_RDP, 0x5AA5);
    if (wrp1 == 0xFF)
        return;
    FLASH->CR = FLASH_CR_OPTWRE | FLASH_CR_OPTPG;
    *OPTION_WRP1 = wrp1;
    option_wait();
    check_equal("wrp1-and-its-complement", *OPTION_WRP1, (wrp1 | ~wrp1 << 8) & 0xFFFF);
}

static void protected_page(void)
{
    check_equal("wrpr-shows-protection", FLASH->WRPR, 0xFFFF7FFF);
    unlock();
    program_from_ram(PAGE + 16, 0x1234);
    check_equal("protected-program-is-wrprterr", take_flags() & FLASH_SR_WRPRTERR, FLASH_SR_WRPRTERR);
    check_equal("protected-program-changes-nothing", AT(PAGE + 16), 0xFFFF);
    erase_from_ram(PAGE);
    check_equal("protected-erase-is-wrprterr", take_flags() & FLASH_SR_WRPRTERR, FLASH_SR_WRPRTERR);
    check_equal("protected-erase-changes-nothing", AT(PAGE), 0);
}

// --- Wrong keys

static void wrong_key(void)
{
    check_equal("wrpr-shows-no-protection", FLASH->WRPR, 0xFFFFFFFF);
    unlock();
    erase_from_ram(PAGE);
    take_flags();
    check_equal("unprotected-page-erases", AT(PAGE), 0xFFFF);
    FLASH->CR = FLASH_CR_LOCK;
    check_equal("wrong-key-is-bus-fault", faults_of_store(&FLASH->KEYR, FLASH_KEY2), 1);
    bus_faults = 0;
    unlock();
    check_equal("locked-until-reset", FLASH->CR & FLASH_CR_LOCK, FLASH_CR_LOCK);
}

__attribute__((noreturn)) static void reset_into(uint32_t stage)
{
    check_next_stage(stage);
    reset_by_software();
}

int main(void)
{
    uint32_t stage = check_stage(reset_cause() & RCC_CSR_SFTRSTF);
    SCB->SHCSR = SHCSR_BUSFAULTENA;
    cycles_start();
    switch (stage) {
    case 0:
        signature();
        unlocking();
        erasing();
        programming();
        interrupts();
        set_protection(0x7F);
        reset_into(1);
    case 1:
        protected_page();
        set_protection(0xFF);
        reset_into(2);
    case 2:
        wrong_key();
        reset_into(3);
    default:
        unlock();
        check_equal("reset-lets-unlock", FLASH->CR & FLASH_CR_LOCK, 0);
        check_done();
    }
}
