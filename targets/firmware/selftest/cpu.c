// SPDX-License-Identifier: GPL-2.0-or-later
//
// The instructions that compilers lean on and emulators get wrong, by hand vectors from the ARMv7-M Architecture Reference
// Manual (DDI 0403; the chapter is named at each). Touches no peripheral, so it runs on any Cortex-M3.

#include "check.h"
#include "chip/stm32f103.h"
#include "startup.h"

#define N 0x80000000u
#define Z 0x40000000u
#define C 0x20000000u
#define V 0x10000000u
#define Q 0x08000000u
#define NZCV 0xF0000000u

// --- Conditions (A7.3): each IT condition under all sixteen settings of the flags, one bit of the result for each

#define CONDITION_TRUTH(condition)                                                                                      \
    ({                                                                                                                  \
        uint32_t truth_ = 0;                                                                                            \
        for (uint32_t flags_ = 0; flags_ < 16; ++flags_) {                                                              \
            uint32_t taken_ = 0;                                                                                        \
            __asm volatile("msr apsr_nzcvq, %1\n it " condition "\n mov" condition " %0, #1"                            \
                           : "+r"(taken_)                                                                               \
                           : "r"(flags_ << 28)                                                                          \
                           : "cc");                                                                                     \
            truth_ |= taken_ << flags_;                                                                                 \
        }                                                                                                               \
        truth_;                                                                                                         \
    })

static void conditions(void)
{
    check_equal("it-eq", CONDITION_TRUTH("eq"), 0xF0F0);
    check_equal("it-ne", CONDITION_TRUTH("ne"), 0x0F0F);
    check_equal("it-cs", CONDITION_TRUTH("cs"), 0xCCCC);
    check_equal("it-cc", CONDITION_TRUTH("cc"), 0x3333);
    check_equal("it-mi", CONDITION_TRUTH("mi"), 0xFF00);
    check_equal("it-pl", CONDITION_TRUTH("pl"), 0x00FF);
    check_equal("it-vs", CONDITION_TRUTH("vs"), 0xAAAA);
    check_equal("it-vc", CONDITION_TRUTH("vc"), 0x5555);
    check_equal("it-hi", CONDITION_TRUTH("hi"), 0x0C0C);
    check_equal("it-ls", CONDITION_TRUTH("ls"), 0xF3F3);
    check_equal("it-ge", CONDITION_TRUTH("ge"), 0xAA55);
    check_equal("it-lt", CONDITION_TRUTH("lt"), 0x55AA);
    check_equal("it-gt", CONDITION_TRUTH("gt"), 0x0A05);
    check_equal("it-le", CONDITION_TRUTH("le"), 0xF5FA);
}

// --- IT blocks (A7.7.38)

static uint32_t four_in_a_block(uint32_t value)
{
    uint32_t result = 0;
    __asm volatile("cmp %1, #10\n"
                   "ittee hi\n"
                   "addhi %0, #1\n"
                   "addhi %0, #2\n"
                   "addls %0, #4\n"
                   "addls %0, #8"
                   : "+r"(result)
                   : "r"(value)
                   : "cc");
    return result;
}

static uint32_t flags_after_add_in_block(void)
{
    uint32_t flags, sum = 0xFFFFFFFFu;
    __asm volatile("cmp %1, %1\n" // Z and C
                   "it eq\n"
                   "addeq %1, #1\n" // the 16-bit form: outside a block it would set the flags
                   "mrs %0, apsr"
                   : "=r"(flags), "+l"(sum)::"cc");
    return flags & NZCV;
}

static uint32_t compare_changes_the_block(void)
{
    uint32_t result = 0;
    __asm volatile("cmp %0, %0\n"
                   "itte eq\n"
                   "cmpeq %0, #1\n" // now NE: of what follows, only the else part runs
                   "addeq %0, #1\n"
                   "addne %0, #2"
                   : "+l"(result)::"cc");
    return result;
}

static uint32_t branch_ends_a_block(uint32_t value)
{
    uint32_t result = 1;
    __asm volatile("cmp %1, #0\n"
                   "itt ne\n"
                   "addne %0, #1\n"
                   "bne 1f\n"
                   "add %0, #8\n"
                   "1:"
                   : "+r"(result)
                   : "r"(value)
                   : "cc");
    return result;
}

static void it_blocks(void)
{
    check_equal("it-block-then", four_in_a_block(11), 3);
    check_equal("it-block-else", four_in_a_block(10), 12);
    check_equal("it-block-leaves-flags", flags_after_add_in_block(), Z | C);
    check_equal("it-block-obeys-new-flags", compare_changes_the_block(), 2);
    check_equal("it-block-branch-taken", branch_ends_a_block(1), 2);
    check_equal("it-block-branch-skipped", branch_ends_a_block(0), 9);
}

// --- Arithmetic and flags (A2.2.1): run one instruction on two values with the carry given, see result and flags

struct outcome {
    uint32_t result, flags;
};

#define RUN(instruction, first, second, carry)                                                                          \
    ({                                                                                                                  \
        struct outcome outcome_;                                                                                        \
        __asm volatile("msr apsr_nzcvq, %4\n" instruction "\n mrs %1, apsr"                                             \
                       : "=&r"(outcome_.result), "=&r"(outcome_.flags)                                                  \
                       : "r"((uint32_t)(first)), "r"((uint32_t)(second)), "r"((carry) ? C : 0u)                         \
                       : "cc");                                                                                         \
        outcome_.flags &= NZCV | Q;                                                                                     \
        outcome_;                                                                                                       \
    })

static void expect(const char *name, struct outcome got, uint32_t result, uint32_t flags)
{
    if (got.result != result)
        check_equal(name, got.result, result);
    else
        check_equal(name, got.flags, flags);
}

static void arithmetic(void)
{
    expect("adds-carry", RUN("adds %0, %2, %3", 0xFFFFFFFF, 1, 0), 0, Z | C);
    expect("adds-overflow", RUN("adds %0, %2, %3", 0x7FFFFFFF, 1, 0), 0x80000000, N | V);
    expect("adds-both", RUN("adds %0, %2, %3", 0x80000000, 0x80000000, 0), 0, Z | C | V);
    expect("adcs-carry-in", RUN("adcs %0, %2, %3", 0xFFFFFFFF, 0, 1), 0, Z | C);
    expect("adcs-overflow-by-carry", RUN("adcs %0, %2, %3", 0x7FFFFFFF, 0, 1), 0x80000000, N | V);
    expect("subs-no-borrow", RUN("subs %0, %2, %3", 5, 5, 0), 0, Z | C);
    expect("subs-borrow", RUN("subs %0, %2, %3", 0, 1, 0), 0xFFFFFFFF, N);
    expect("subs-overflow", RUN("subs %0, %2, %3", 0x80000000, 1, 0), 0x7FFFFFFF, C | V);
    expect("sbcs-borrow-in", RUN("sbcs %0, %2, %3", 5, 4, 0), 0, Z | C);
    expect("sbcs-no-borrow-in", RUN("sbcs %0, %2, %3", 5, 5, 1), 0, Z | C);
    expect("rsbs", RUN("rsbs %0, %2, #0", 0x80000000, 0, 0), 0x80000000, N | V);
    expect("logic-keeps-v", RUN("ands %0, %2, %3", 0xF0, 0x0F, 1), 0, Z | C);
    expect("ands-carry-of-immediate", RUN("ands %0, %2, #0x80000000", 0xFFFFFFFF, 0, 0), 0x80000000, N | C);
    expect("movs-keeps-carry", RUN("movs %0, #0", 0, 0, 1), 0, Z | C);
}

// --- Shifts (A2.2.1, A7.4): the amounts at which a shifter's carry is special

static void shifts(void)
{
    expect("lsls-by-0", RUN("lsls %0, %2, %3", 0x80000001, 0, 1), 0x80000001, N | C);
    expect("lsls-by-1", RUN("lsls %0, %2, %3", 0x80000001, 1, 0), 2, C);
    expect("lsls-by-32", RUN("lsls %0, %2, %3", 1, 32, 0), 0, Z | C);
    expect("lsls-by-33", RUN("lsls %0, %2, %3", 0xFFFFFFFF, 33, 1), 0, Z);
    expect("lsls-by-256", RUN("lsls %0, %2, %3", 3, 256, 0), 3, 0); // only the low byte counts
    expect("lsrs-immediate-32", RUN("lsrs %0, %2, #32", 0x80000000, 0, 0), 0, Z | C);
    expect("lsrs-by-33", RUN("lsrs %0, %2, %3", 0x80000000, 33, 1), 0, Z);
    expect("asrs-by-255", RUN("asrs %0, %2, %3", 0x80000000, 255, 0), 0xFFFFFFFF, N | C);
    expect("rors-by-32", RUN("rors %0, %2, %3", 0x80000001, 32, 0), 0x80000001, N | C);
    expect("rors-by-4", RUN("rors %0, %2, %3", 0x0000000F, 4, 0), 0xF0000000, N | C);
    expect("rrx", RUN("rrxs %0, %2", 1, 0, 1), 0x80000000, N | C);
    expect("shifted-operand", RUN("adds %0, %2, %3, asr #4", 1, 0xFFFFFF00, 0), 0xFFFFFFF1, N);
}

// --- Multiply and divide (A7.7.40, A7.7.127, A7.7.195); the division by zero gives zero while CCR.DIV_0_TRP is clear

static void multiply_and_divide(void)
{
    uint32_t low = 1, high = 1;
    __asm volatile("umlal %0, %1, %2, %2" : "+r"(low), "+r"(high) : "r"(0xFFFFFFFFu));
    check_equal("umlal-low", low, 2);
    check_equal("umlal-high", high, 0xFFFFFFFF);
    __asm volatile("smull %0, %1, %2, %3" : "=&r"(low), "=&r"(high) : "r"(0x80000000u), "r"(3));
    check_equal("smull-low", low, 0x80000000);
    check_equal("smull-high", high, 0xFFFFFFFE);
    __asm volatile("mls %0, %1, %2, %3" : "=r"(low) : "r"(7), "r"(6), "r"(50));
    check_equal("mls", low, 8);
    expect("muls-keeps-c-and-v", RUN("mov %0, %2\n muls %0, %3, %0", 0x10000, 0x10000, 1), 0, Z | C);
    expect("udiv", RUN("udiv %0, %2, %3", 0xFFFFFFFF, 10, 0), 429496729, 0);
    expect("udiv-by-zero", RUN("udiv %0, %2, %3", 7, 0, 0), 0, 0);
    expect("sdiv-towards-zero", RUN("sdiv %0, %2, %3", -7, 2, 0), (uint32_t)-3, 0);
    expect("sdiv-by-zero", RUN("sdiv %0, %2, %3", -7, 0, 0), 0, 0);
    expect("sdiv-overflow", RUN("sdiv %0, %2, %3", 0x80000000, -1, 0), 0x80000000, 0);
}

// --- Saturation and Q (A7.7.152, A7.7.213)

static void saturation(void)
{
    expect("ssat-inside", RUN("ssat %0, #8, %2", 127, 0, 0), 127, 0);
    expect("ssat-high", RUN("ssat %0, #8, %2", 128, 0, 0), 127, Q);
    expect("ssat-low", RUN("ssat %0, #8, %2", -129, 0, 0), (uint32_t)-128, Q);
    expect("ssat-shift", RUN("ssat %0, #16, %2, lsl #4", 0x1000, 0, 0), 0x7FFF, Q);
    expect("ssat-32-bits", RUN("ssat %0, #32, %2", 0x80000000, 0, 0), 0x80000000, 0);
    expect("usat-negative", RUN("usat %0, #8, %2", -1, 0, 0), 0, Q);
    expect("usat-high", RUN("usat %0, #8, %2, asr #4", 0x1000, 0, 0), 255, Q);
    expect("usat-to-0-bits", RUN("usat %0, #0, %2", 5, 0, 0), 0, Q);
    expect("q-is-sticky", RUN("ssat %0, #8, %2\n ssat %0, #8, %3", 500, 1, 0), 1, Q);
}

// --- Bit fields, reversal, extension (A7.7)

static void bits(void)
{
    expect("bfi", RUN("mov %0, %2\n bfi %0, %3, #4, #8", 0xFFFFFFFF, 0xA5, 0), 0xFFFFFA5F, 0);
    expect("bfc-all", RUN("mov %0, %2\n bfc %0, #0, #32", 0xFFFFFFFF, 0, 0), 0, 0);
    expect("ubfx", RUN("ubfx %0, %2, #28, #4", 0xF0000000, 0, 0), 0xF, 0);
    expect("sbfx", RUN("sbfx %0, %2, #4, #4", 0x80, 0, 0), 0xFFFFFFF8, 0);
    expect("clz-of-0", RUN("clz %0, %2", 0, 0, 0), 32, 0);
    expect("clz-of-1", RUN("clz %0, %2", 1, 0, 0), 31, 0);
    expect("rbit", RUN("rbit %0, %2", 0x00000005, 0, 0), 0xA0000000, 0);
    expect("rev", RUN("rev %0, %2", 0x11223344, 0, 0), 0x44332211, 0);
    expect("rev16", RUN("rev16 %0, %2", 0x11223344, 0, 0), 0x22114433, 0);
    expect("revsh", RUN("revsh %0, %2", 0x000080FF, 0, 0), 0xFFFFFF80, 0);
    expect("sxtb-rotated", RUN("sxtb.w %0, %2, ror #16", 0x00800000, 0, 0), 0xFFFFFF80, 0);
    expect("uxth-rotated", RUN("uxth.w %0, %2, ror #8", 0x11223344, 0, 0), 0x2233, 0);
    expect("movw-movt", RUN("movw %0, #0x5678\n movt %0, #0x1234", 0, 0, 0), 0x12345678, 0);
}

// --- Loads and stores (A6.4 to A6.6)

static void loads_and_stores(void)
{
    static uint32_t memory[8];
    uint32_t a, b, *at = memory;
    __asm volatile("strd %1, %2, [%0], #8" : "+r"(at) : "r"(0x11), "r"(0x22) : "memory");
    check("strd-post-index", at == memory + 2 && memory[0] == 0x11 && memory[1] == 0x22);
    __asm volatile("ldrd %0, %1, [%2, #-8]!" : "=&r"(a), "=&r"(b), "+r"(at)::"memory");
    check("ldrd-pre-index", at == memory && a == 0x11 && b == 0x22);
    at = memory + 2;
    __asm volatile("mov r4, #0x33\n mov r5, #0x44\n stmdb %0!, {r4, r5}" : "+r"(at)::"r4", "r5", "memory");
    check("stmdb", at == memory && memory[0] == 0x33 && memory[1] == 0x44);
    __asm volatile("ldmia %2!, {r4, r5}\n mov %0, r4\n mov %1, r5" : "=&r"(a), "=&r"(b), "+r"(at)::"r4", "r5", "memory");
    check("ldmia", at == memory + 2 && a == memory[0] && b == memory[1]);

    memory[0] = 0x8899AABB;
    memory[1] = 0xCCDDEEFF;
    uint8_t *byte = (uint8_t *)memory;
    __asm volatile("ldrsb %0, [%1, #3]" : "=r"(a) : "r"(byte) : "memory");
    check_equal("ldrsb", a, 0xFFFFFF88);
    __asm volatile("ldrsh %0, [%1], #2" : "=r"(a), "+r"(byte)::"memory");
    check_equal("ldrsh", a, 0xFFFFAABB);
    check("ldrsh-post-index", byte == (uint8_t *)memory + 2);

    byte = (uint8_t *)memory + 1; // unaligned words and half-words are allowed while CCR.UNALIGN_TRP is clear (A3.2.1)
    __asm volatile("ldr %0, [%1]" : "=r"(a) : "r"(byte) : "memory");
    check_equal("ldr-unaligned", a, 0xFF8899AA);
    __asm volatile("ldrh %0, [%1, #2]" : "=r"(a) : "r"(byte) : "memory");
    check_equal("ldrh-unaligned", a, 0xFF88);
    __asm volatile("str %0, [%1]" ::"r"(0x12345678), "r"(byte) : "memory");
    check("str-unaligned", memory[0] == 0x345678BB && memory[1] == 0xCCDDEE12);
}

// --- Table branches (A7.7.185)

static uint32_t table_branch(uint32_t index)
{
    uint32_t result = 0;
    __asm volatile("tbb [pc, %1]\n"
                   "0: .byte (1f - 0b) / 2, (2f - 0b) / 2, (3f - 0b) / 2\n"
                   ".align 1\n"
                   "1: add %0, #1\n"
                   "2: add %0, #2\n"
                   "3: add %0, #4\n"
                   : "+r"(result)
                   : "r"(index)
                   : "cc");
    return result;
}

static uint32_t table_branch_halfword(uint32_t index)
{
    uint32_t result = 0;
    __asm volatile("tbh [pc, %1, lsl #1]\n"
                   "0: .hword (1f - 0b) / 2, (2f - 0b) / 2\n"
                   "1: add %0, #1\n"
                   "2: add %0, #2\n"
                   : "+r"(result)
                   : "r"(index)
                   : "cc");
    return result;
}

static void branches(void)
{
    check_equal("tbb-first", table_branch(0), 7);
    check_equal("tbb-last", table_branch(2), 4);
    check_equal("tbh-first", table_branch_halfword(0), 3);
    check_equal("tbh-last", table_branch_halfword(1), 2);
}

// --- Exclusive access (A3.4): STREX gives 0 when it stored

static void exclusives(void)
{
    static uint32_t word;
    uint32_t loaded, failed;
    __asm volatile("ldrex %0, [%2]\n add %0, #1\n strex %1, %0, [%2]" : "=&r"(loaded), "=&r"(failed) : "r"(&word) : "memory");
    check("strex-stores", failed == 0 && word == 1);
    __asm volatile("strex %0, %1, [%2]" : "=&r"(failed) : "r"(9), "r"(&word) : "memory");
    check("strex-alone-fails", failed == 1 && word == 1);
    __asm volatile("ldrex %0, [%2]\n clrex\n strex %1, %0, [%2]" : "=&r"(loaded), "=&r"(failed) : "r"(&word) : "memory");
    check("strex-after-clrex-fails", failed == 1);
    uint8_t byte = 7;
    __asm volatile("ldrexb %0, [%2]\n add %0, #1\n strexb %1, %0, [%2]"
                   : "=&r"(loaded), "=&r"(failed)
                   : "r"(&byte)
                   : "memory");
    check("strexb-stores", failed == 0 && byte == 8);
}

// --- The bit-band alias of RAM (B3.1; RM0008, 3.3.1)

static void bit_band(void)
{
    static volatile uint32_t word;
    word = 0;
    *bit_of(&word, 31) = 1;
    check_equal("bit-band-set", word, 0x80000000);
    *bit_of(&word, 4) = 0xFFFFFFFF; // only bit 0 of what is written counts
    check_equal("bit-band-set-by-bit-0", word, 0x80000010);
    *bit_of(&word, 31) = 0xFFFFFFFE;
    check_equal("bit-band-clear", word, 0x10);
    check_equal("bit-band-reads-1", *bit_of(&word, 4), 1);
    check_equal("bit-band-reads-0", *bit_of(&word, 5), 0);
    *(volatile uint8_t *)bit_of(&word, 9) = 1;
    check_equal("bit-band-byte-access", word, 0x210);
}

// --- Special registers (B1.4, B5.2.2)

static void special_registers(void)
{
    WRITE_SPECIAL("apsr_nzcvq", NZCV | Q);
    check_equal("apsr-keeps-flags", READ_SPECIAL("apsr"), NZCV | Q);
    check_equal("epsr-reads-0", READ_SPECIAL("epsr"), 0);
    check_equal("ipsr-is-0-in-thread", READ_SPECIAL("ipsr"), 0);
    check_equal("control-is-0-after-reset", READ_SPECIAL("control"), 0);
    check_equal("primask-is-0-after-reset", READ_SPECIAL("primask"), 0);
    WRITE_SPECIAL("primask", 1);
    check_equal("primask-keeps-1", READ_SPECIAL("primask"), 1);
    WRITE_SPECIAL("primask", 0);
    WRITE_SPECIAL("faultmask", 1);
    check_equal("faultmask-keeps-1", READ_SPECIAL("faultmask"), 1);
    WRITE_SPECIAL("faultmask", 0);
    WRITE_SPECIAL("basepri", 0xF0);
    check_equal("basepri-keeps-4-bits", READ_SPECIAL("basepri"), 0xF0);
    WRITE_SPECIAL("basepri_max", 0x40);
    check_equal("basepri-max-lowers", READ_SPECIAL("basepri"), 0x40);
    WRITE_SPECIAL("basepri_max", 0x80);
    check_equal("basepri-max-does-not-raise", READ_SPECIAL("basepri"), 0x40);
    WRITE_SPECIAL("basepri_max", 0);
    check_equal("basepri-max-ignores-0", READ_SPECIAL("basepri"), 0x40);
    WRITE_SPECIAL("basepri", 0);
    uint32_t kept = READ_SPECIAL("psp");
    WRITE_SPECIAL("psp", 0x20000100);
    check_equal("psp-keeps-a-word-address", READ_SPECIAL("psp"), 0x20000100);
    WRITE_SPECIAL("psp", kept);
}

// --- Code in RAM, also when it is changed between two runs (A3.7.3: DSB and ISB make the change seen)

static RAM_FUNCTION uint32_t in_ram(uint32_t value) { return value * 3 + 1; }

static void code_in_ram(void)
{
    check("function-lies-in-ram", ((uint32_t)(uintptr_t)in_ram & 0xFF000000u) == RAM_BASE);
    check_equal("code-in-ram", in_ram(5), 16);

    static uint16_t code[2] = {0x2001, 0x4770}; // movs r0, #1; bx lr
    uint32_t (*function)(void) = (uint32_t(*)(void))((uintptr_t)code | 1);
    check_equal("code-made-by-hand", function(), 1);
    for (uint32_t number = 2; number < 5; ++number) {
        *(volatile uint16_t *)code = (uint16_t)(0x2000 | number);
        DSB();
        ISB();
        check_equal("code-changed-in-place", function(), number);
    }
}

int main(void)
{
    special_registers();
    conditions();
    it_blocks();
    arithmetic();
    shifts();
    multiply_and_divide();
    saturation();
    bits();
    loads_and_stores();
    branches();
    exclusives();
    bit_band();
    code_in_ram();
    check_done();
}
