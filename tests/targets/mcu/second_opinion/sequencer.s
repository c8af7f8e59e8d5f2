@ SPDX-License-Identifier: GPL-2.0-or-later
@
@ Carries out a list of accesses to registers and keeps what it reads; sequencer.hex is this, assembled:
@   arm-none-eabi-gcc -c -mcpu=cortex-m3 -mthumb sequencer.s && arm-none-eabi-objcopy -O binary -j .text sequencer.o
@
@ An operation is three words: what to do (the index into the table below), address, value. Each gives one word: what was
@ read, 0 for a write, 0xBADFA017 for an access that faults. An interrupt is noted elsewhere, as the number of the
@ operation in flight and, in the lower half-word, of the exception; it is then disabled. At the end, the word before the
@ results is set to 1.

.syntax unified
.cpu cortex-m3
.thumb
.text
reset:                          @ at 0x08000200
    ldr r4, =0x08001000         @ the next operation
    ldr r5, =0x20000404         @ where the next result goes
    ldr r7, =0x20003000         @ where the next interrupt is noted
next:                           @ at 0x08000206
    ldmia r4!, {r0, r1, r2}
    tbb [pc, r0]
table:
    .byte (end - table) / 2, (read4 - table) / 2, (write4 - table) / 2, (read2 - table) / 2
    .byte (write2 - table) / 2, (read1 - table) / 2, (write1 - table) / 2, (delay - table) / 2
    .byte (wait - table) / 2, 0
end:
    ldr r0, =0x20000400
    movs r1, #1
    str r1, [r0]
    b .
read4:
    ldr r0, [r1]
    b result
read2:
    ldrh r0, [r1]
    b result
read1:
    ldrb r0, [r1]
    b result
write4:
    str r2, [r1]
    b written
write2:
    strh r2, [r1]
    b written
write1:
    strb r2, [r1]
    b written
delay:                          @ value: turns
    subs r2, #1
    bne delay
written:
    movs r0, #0
    b result
wait:                           @ value: bits that must all be set
    movw r3, #10000
again:
    ldr r0, [r1]
    ands r6, r0, r2
    cmp r6, r2
    beq result
    subs r3, #1
    bne again
    ldr r0, =0x71BE0007
result:
    stmia r5!, {r0}
    b next
    .align 2
fault:
    ldr r0, =0xBADFA017
    stmia r5!, {r0}
    ldr r0, =0x08000206
    str r0, [sp, #24]
    bx lr
    .align 2
interrupt:
    ldr r0, =0x20000404
    subs r0, r5, r0
    lsls r0, #14
    mrs r1, ipsr
    orrs r0, r1
    stmia r7!, {r0}
    subs r0, r1, #16
    bmi system
    ldr r1, =0xE000E180         @ NVIC_ICER0
    movs r2, #1
    lsr r3, r0, #5
    and r0, #31
    lsls r2, r0
    str r2, [r1, r3, lsl #2]
    bx lr
system:
    ldr r1, =0xE000E010         @ STK_CTRL
    movs r2, #0
    str r2, [r1]
    bx lr
    .pool
