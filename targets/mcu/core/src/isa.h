/* The instruction set of ARMv7-M and ARMv7E-M as data: encodings, operands, what they do, what they take.
 *
 * Each row is one encoding of the Architecture Reference Manual (DDI0403, sections A5.2 and A5.3, chapter A7):
 *
 *   ROW("pattern", FORM, OPERATION, where, m3, m7)
 *
 * pattern: 16 or 32 bits, blanks aside. 0 and 1 stand for themselves, '-' for a bit that does not matter (those in
 *   parentheses in the manual), a letter for a field, whose bits are taken together in the order in which they stand.
 * FORM: how the fields become operands; see decode.c.
 * OPERATION: of `OPERATIONS` below. Where it can set the flags, the one behind it does the same without.
 * where: BASE, or what the core must have: DSP, FP.
 * m3, m7: cycles in the timing model "table", without the refill of the pipeline after a branch taken.
 *
 * The first row that fits counts; what fits none is UNDEFINED.
 *
 * Cycles of the Cortex-M3: its Technical Reference Manual (r2p1, table 3-1). Where that gives a range, one number is
 * taken, and that is a choice: a division of 2 to 12 is 7, UMULL and SMULL of 3 to 5 are 4, UMLAL and SMLAL of 4 to 7
 * are 6, MSR and CPS of 1 to 2 are 2. Cycles of the Cortex-M7 are a choice throughout, for Arm publishes none: how it
 * runs if nothing is issued beside an instruction. Loads and stores of several words take half as many cycles as words,
 * for the paths to memory are 64 bits wide; divisions and roots what the radix of the dividers suggests. */
#ifndef HIL_ISA_H
#define HIL_ISA_H

/* Cycles that depend on the list of registers: one more than there are, and one for each two. */
#define EACH 101
#define PAIRS 102

/* Operations of data processing, each with a shifted register, a plain register and a constant. */
#define WITH_FLAGS_AND_WITHOUT(X, operation)                                                                          \
  X(operation##_REG) X(operation##_REG_NF) X(operation##_SHIFT) X(operation##_SHIFT_NF) X(operation##_IMM)            \
  X(operation##_IMM_NF)
#define FLAGS_ALONE(X, operation) X(operation##_REG) X(operation##_SHIFT) X(operation##_IMM)

#define ADDRESSED(X, operation) X(operation##_OFFSET) X(operation##_INDEX) X(operation##_BEFORE) X(operation##_AFTER)

#define OPERATIONS(X)                                                                                                 \
  X(UNDECODED) X(VERIFY) X(TO_SP) X(HOOK) X(END_OF_MEMORY) X(UNDEFINED) X(NOP)                                        \
  WITH_FLAGS_AND_WITHOUT(X, AND) WITH_FLAGS_AND_WITHOUT(X, BIC) WITH_FLAGS_AND_WITHOUT(X, ORR)                        \
  WITH_FLAGS_AND_WITHOUT(X, ORN) WITH_FLAGS_AND_WITHOUT(X, EOR) WITH_FLAGS_AND_WITHOUT(X, ADD)                        \
  WITH_FLAGS_AND_WITHOUT(X, ADC) WITH_FLAGS_AND_WITHOUT(X, SBC) WITH_FLAGS_AND_WITHOUT(X, SUB)                        \
  WITH_FLAGS_AND_WITHOUT(X, RSB) WITH_FLAGS_AND_WITHOUT(X, MOV) WITH_FLAGS_AND_WITHOUT(X, MVN)                        \
  FLAGS_ALONE(X, TST) FLAGS_ALONE(X, TEQ) FLAGS_ALONE(X, CMP) FLAGS_ALONE(X, CMN)                                     \
  X(LSL_IMM) X(LSL_IMM_NF) X(LSR_IMM) X(LSR_IMM_NF) X(ASR_IMM) X(ASR_IMM_NF)                                          \
  X(LSL_BY) X(LSL_BY_NF) X(LSR_BY) X(LSR_BY_NF) X(ASR_BY) X(ASR_BY_NF) X(ROR_BY) X(ROR_BY_NF)                         \
  X(MUL) X(MUL_NF) X(MLA) X(MLS) X(SMULL) X(UMULL) X(SMLAL) X(UMLAL) X(SDIV) X(UDIV)                                  \
  X(ADD_HIGH) X(CMP_HIGH) X(MOV_HIGH) X(MOVT) X(PKH)                                                                  \
  X(SXTH) X(SXTB) X(UXTH) X(UXTB) X(REV) X(REV16) X(REVSH) X(RBIT) X(CLZ)                                             \
  X(SBFX) X(UBFX) X(BFI) X(BFC) X(SSAT) X(USAT)                                                                       \
  X(B) X(BEQ) X(BNE) X(BCS) X(BCC) X(BMI) X(BPL) X(BVS) X(BVC) X(BHI) X(BLS) X(BGE) X(BLT) X(BGT) X(BLE)              \
  X(BL) X(BX) X(BLX) X(CBZ) X(CBNZ) X(TBB) X(TBH) X(IT)                                                               \
  ADDRESSED(X, LDR) ADDRESSED(X, LDRH) ADDRESSED(X, LDRB) ADDRESSED(X, LDRSH) ADDRESSED(X, LDRSB)                     \
  ADDRESSED(X, STR) ADDRESSED(X, STRH) ADDRESSED(X, STRB)                                                             \
  X(LDR_LITERAL) X(LDRH_LITERAL) X(LDRB_LITERAL) X(LDRSH_LITERAL) X(LDRSB_LITERAL)                                    \
  X(LDR_PC) X(LDR_PC_LITERAL) X(LDM) X(STM) X(LDRD) X(LDRD_LITERAL) X(STRD)                                           \
  X(LDREX) X(STREX) X(CLREX) X(SVC) X(BKPT) X(WFI) X(WFE) X(SEV) X(MSR) X(MRS) X(CPS)                                 \
  X(DSP) X(SMLAX) X(SMLALX) X(UMAAL)                                                                                  \
  X(VLDR) X(VLDR_LITERAL) X(VSTR) X(VLDM) X(VSTM) X(VMRS) X(VMSR) X(VMOV_FROM_CORE) X(VMOV_TO_CORE)                   \
  X(VMOV_PAIR_FROM_CORE) X(VMOV_PAIR_TO_CORE) X(FLOAT)

#define ENCODINGS                                                                                                     \
  /* 16 bits: shift, add, subtract, move, compare (A5.2.1) */                                                         \
  ROW("000 00 iiiii mmm ddd", SHIFT_NARROW, LSL_IMM, BASE, 1, 1)                                                      \
  ROW("000 01 iiiii mmm ddd", SHIFT_NARROW, LSR_IMM, BASE, 1, 1)                                                      \
  ROW("000 10 iiiii mmm ddd", SHIFT_NARROW, ASR_IMM, BASE, 1, 1)                                                      \
  ROW("0001100 mmm nnn ddd", NARROW, ADD_REG, BASE, 1, 1)                                                             \
  ROW("0001101 mmm nnn ddd", NARROW, SUB_REG, BASE, 1, 1)                                                             \
  ROW("0001110 iii nnn ddd", NARROW, ADD_IMM, BASE, 1, 1)                                                             \
  ROW("0001111 iii nnn ddd", NARROW, SUB_IMM, BASE, 1, 1)                                                             \
  ROW("00100 ddd iiiiiiii", NARROW, MOV_IMM, BASE, 1, 1)                                                              \
  ROW("00101 nnn iiiiiiii", PLAIN, CMP_IMM, BASE, 1, 1)                                                               \
  ROW("00110 ddd iiiiiiii", NARROW_TO_SELF, ADD_IMM, BASE, 1, 1)                                                      \
  ROW("00111 ddd iiiiiiii", NARROW_TO_SELF, SUB_IMM, BASE, 1, 1)                                                      \
  /* 16 bits: data processing (A5.2.2) */                                                                             \
  ROW("010000 0000 mmm ddd", NARROW_TO_SELF, AND_REG, BASE, 1, 1)                                                     \
  ROW("010000 0001 mmm ddd", NARROW_TO_SELF, EOR_REG, BASE, 1, 1)                                                     \
  ROW("010000 0010 mmm ddd", NARROW_TO_SELF, LSL_BY, BASE, 1, 1)                                                      \
  ROW("010000 0011 mmm ddd", NARROW_TO_SELF, LSR_BY, BASE, 1, 1)                                                      \
  ROW("010000 0100 mmm ddd", NARROW_TO_SELF, ASR_BY, BASE, 1, 1)                                                      \
  ROW("010000 0101 mmm ddd", NARROW_TO_SELF, ADC_REG, BASE, 1, 1)                                                     \
  ROW("010000 0110 mmm ddd", NARROW_TO_SELF, SBC_REG, BASE, 1, 1)                                                     \
  ROW("010000 0111 mmm ddd", NARROW_TO_SELF, ROR_BY, BASE, 1, 1)                                                      \
  ROW("010000 1000 mmm nnn", PLAIN, TST_REG, BASE, 1, 1)                                                              \
  ROW("010000 1001 nnn ddd", NARROW, RSB_IMM, BASE, 1, 1)                                                             \
  ROW("010000 1010 mmm nnn", PLAIN, CMP_REG, BASE, 1, 1)                                                              \
  ROW("010000 1011 mmm nnn", PLAIN, CMN_REG, BASE, 1, 1)                                                              \
  ROW("010000 1100 mmm ddd", NARROW_TO_SELF, ORR_REG, BASE, 1, 1)                                                     \
  ROW("010000 1101 mmm ddd", NARROW_TO_SELF, MUL, BASE, 1, 1)                                                         \
  ROW("010000 1110 mmm ddd", NARROW_TO_SELF, BIC_REG, BASE, 1, 1)                                                     \
  ROW("010000 1111 mmm ddd", NARROW, MVN_REG, BASE, 1, 1)                                                             \
  /* 16 bits: special data, branch and exchange (A5.2.3) */                                                           \
  ROW("01000100 d mmmm ddd", HIGH, ADD_HIGH, BASE, 1, 1)                                                              \
  ROW("01000101 n mmmm nnn", HIGH, CMP_HIGH, BASE, 1, 1)                                                              \
  ROW("01000110 d mmmm ddd", HIGH, MOV_HIGH, BASE, 1, 1)                                                              \
  ROW("01000111 0 mmmm ---", HIGH, BX, BASE, 1, 1)                                                                    \
  ROW("01000111 1 mmmm ---", HIGH, BLX, BASE, 1, 1)                                                                   \
  /* 16 bits: loads and stores (A5.2.4) */                                                                            \
  ROW("01001 ttt iiiiiiii", LITERAL_NARROW, LDR_LITERAL, BASE, 2, 1)                                                  \
  ROW("0101 000 mmm nnn ttt", PLAIN, STR_INDEX, BASE, 2, 1)                                                           \
  ROW("0101 001 mmm nnn ttt", PLAIN, STRH_INDEX, BASE, 2, 1)                                                          \
  ROW("0101 010 mmm nnn ttt", PLAIN, STRB_INDEX, BASE, 2, 1)                                                          \
  ROW("0101 011 mmm nnn ttt", PLAIN, LDRSB_INDEX, BASE, 2, 1)                                                         \
  ROW("0101 100 mmm nnn ttt", PLAIN, LDR_INDEX, BASE, 2, 1)                                                           \
  ROW("0101 101 mmm nnn ttt", PLAIN, LDRH_INDEX, BASE, 2, 1)                                                          \
  ROW("0101 110 mmm nnn ttt", PLAIN, LDRB_INDEX, BASE, 2, 1)                                                          \
  ROW("0101 111 mmm nnn ttt", PLAIN, LDRSH_INDEX, BASE, 2, 1)                                                         \
  ROW("01100 iiiii nnn ttt", WORDS, STR_OFFSET, BASE, 2, 1)                                                           \
  ROW("01101 iiiii nnn ttt", WORDS, LDR_OFFSET, BASE, 2, 1)                                                           \
  ROW("01110 iiiii nnn ttt", PLAIN, STRB_OFFSET, BASE, 2, 1)                                                          \
  ROW("01111 iiiii nnn ttt", PLAIN, LDRB_OFFSET, BASE, 2, 1)                                                          \
  ROW("10000 iiiii nnn ttt", HALVES, STRH_OFFSET, BASE, 2, 1)                                                         \
  ROW("10001 iiiii nnn ttt", HALVES, LDRH_OFFSET, BASE, 2, 1)                                                         \
  ROW("10010 ttt iiiiiiii", WORDS_AT_SP, STR_OFFSET, BASE, 2, 1)                                                      \
  ROW("10011 ttt iiiiiiii", WORDS_AT_SP, LDR_OFFSET, BASE, 2, 1)                                                      \
  /* 16 bits: addresses, miscellaneous (A5.2.5) */                                                                    \
  ROW("10100 ddd iiiiiiii", ADR_NARROW, MOV_IMM_NF, BASE, 1, 1)                                                       \
  ROW("10101 ddd iiiiiiii", WORDS_AT_SP, ADD_IMM_NF, BASE, 1, 1)                                                      \
  ROW("10110000 0 iiiiiii", SP_PLUS, ADD_IMM_NF, BASE, 1, 1)                                                          \
  ROW("10110000 1 iiiiiii", SP_PLUS, SUB_IMM_NF, BASE, 1, 1)                                                          \
  ROW("1011 00 i 1 iiiii nnn", COMPARE_BRANCH, CBZ, BASE, 1, 1)                                                       \
  ROW("1011 10 i 1 iiiii nnn", COMPARE_BRANCH, CBNZ, BASE, 1, 1)                                                      \
  ROW("1011001000 mmm ddd", PLAIN, SXTH, BASE, 1, 1)                                                                  \
  ROW("1011001001 mmm ddd", PLAIN, SXTB, BASE, 1, 1)                                                                  \
  ROW("1011001010 mmm ddd", PLAIN, UXTH, BASE, 1, 1)                                                                  \
  ROW("1011001011 mmm ddd", PLAIN, UXTB, BASE, 1, 1)                                                                  \
  ROW("1011 010 r rrrrrrrr", PUSH, STM, BASE, EACH, PAIRS)                                                            \
  ROW("10110110 011 i -- ii", PLAIN, CPS, BASE, 2, 2)                                                                 \
  ROW("1011101000 mmm ddd", PLAIN, REV, BASE, 1, 1)                                                                   \
  ROW("1011101001 mmm ddd", PLAIN, REV16, BASE, 1, 1)                                                                 \
  ROW("1011101011 mmm ddd", PLAIN, REVSH, BASE, 1, 1)                                                                 \
  ROW("1011 110 r rrrrrrrr", POP, LDM, BASE, EACH, PAIRS)                                                             \
  ROW("10111110 iiiiiiii", PLAIN, BKPT, BASE, 1, 1)                                                                   \
  ROW("10111111 0001 0000", PLAIN, NOP, BASE, 1, 1)                                                                   \
  ROW("10111111 0010 0000", PLAIN, WFE, BASE, 1, 1)                                                                   \
  ROW("10111111 0011 0000", PLAIN, WFI, BASE, 1, 1)                                                                   \
  ROW("10111111 0100 0000", PLAIN, SEV, BASE, 1, 1)                                                                   \
  ROW("10111111 ---- 0000", PLAIN, NOP, BASE, 1, 1)                                                                   \
  ROW("10111111 iiiiiiii", PLAIN, IT, BASE, 1, 1)                                                                     \
  ROW("11000 nnn rrrrrrrr", MULTIPLE_NARROW, STM, BASE, EACH, PAIRS)                                                  \
  ROW("11001 nnn rrrrrrrr", MULTIPLE_NARROW, LDM, BASE, EACH, PAIRS)                                                  \
  /* 16 bits: branches, calls (A5.2.6) */                                                                             \
  ROW("1101 1110 --------", PLAIN, UNDEFINED, BASE, 1, 1)                                                             \
  ROW("1101 1111 iiiiiiii", PLAIN, SVC, BASE, 1, 1)                                                                   \
  ROW("1101 cccc iiiiiiii", BRANCH_8, BEQ, BASE, 1, 1)                                                                \
  ROW("11100 iiiiiiiiiii", BRANCH_11, B, BASE, 1, 1)                                                                  \
  /* 32 bits: several registers (A5.3.5) */                                                                           \
  ROW("1110100 010 w 0 nnnn 0r0r rrrr rrrr rrrr", MULTIPLE_UP, STM, BASE, EACH, PAIRS)                                \
  ROW("1110100 010 w 1 nnnn rr0r rrrr rrrr rrrr", MULTIPLE_UP, LDM, BASE, EACH, PAIRS)                                \
  ROW("1110100 100 w 0 nnnn 0r0r rrrr rrrr rrrr", MULTIPLE_DOWN, STM, BASE, EACH, PAIRS)                              \
  ROW("1110100 100 w 1 nnnn rr0r rrrr rrrr rrrr", MULTIPLE_DOWN, LDM, BASE, EACH, PAIRS)                              \
  /* 32 bits: pairs, exclusive accesses, tables of branches (A5.3.6) */                                               \
  ROW("1110100 0010 0 nnnn tttt aaaa iiiiiiii", EXCLUSIVE_WORD, STREX, BASE, 2, 1)                                    \
  ROW("1110100 0010 1 nnnn tttt ---- iiiiiiii", EXCLUSIVE_WORD, LDREX, BASE, 2, 1)                                    \
  ROW("1110100 0110 0 nnnn tttt ---- 0100 aaaa", EXCLUSIVE_BYTE, STREX, BASE, 2, 1)                                   \
  ROW("1110100 0110 0 nnnn tttt ---- 0101 aaaa", EXCLUSIVE_HALF, STREX, BASE, 2, 1)                                   \
  ROW("1110100 0110 1 nnnn ---- ---- 0000 mmmm", TABLE, TBB, BASE, 2, 1)                                              \
  ROW("1110100 0110 1 nnnn ---- ---- 0001 mmmm", TABLE, TBH, BASE, 2, 1)                                              \
  ROW("1110100 0110 1 nnnn tttt ---- 0100 ----", EXCLUSIVE_BYTE, LDREX, BASE, 2, 1)                                   \
  ROW("1110100 0110 1 nnnn tttt ---- 0101 ----", EXCLUSIVE_HALF, LDREX, BASE, 2, 1)                                   \
  ROW("1110100 p u 1 w 1 1111 tttt aaaa iiiiiiii", PAIR, LDRD_LITERAL, BASE, 3, 1)                                    \
  ROW("1110100 p u 1 w 1 nnnn tttt aaaa iiiiiiii", PAIR, LDRD, BASE, 3, 1)                                            \
  ROW("1110100 p u 1 w 0 nnnn tttt aaaa iiiiiiii", PAIR, STRD, BASE, 3, 1)                                            \
  /* 32 bits: data processing with a shifted register (A5.3.11) */                                                    \
  ROW("1110101 0000 1 nnnn -iii 1111 iiyy mmmm", SHIFTED, TST_REG, BASE, 1, 1)                                        \
  ROW("1110101 0000 s nnnn -iii dddd iiyy mmmm", SHIFTED, AND_REG, BASE, 1, 1)                                        \
  ROW("1110101 0001 s nnnn -iii dddd iiyy mmmm", SHIFTED, BIC_REG, BASE, 1, 1)                                        \
  ROW("1110101 0010 s 1111 -iii dddd iiyy mmmm", SHIFTED, MOV_REG, BASE, 1, 1)                                        \
  ROW("1110101 0010 s nnnn -iii dddd iiyy mmmm", SHIFTED, ORR_REG, BASE, 1, 1)                                        \
  ROW("1110101 0011 s 1111 -iii dddd iiyy mmmm", SHIFTED, MVN_REG, BASE, 1, 1)                                        \
  ROW("1110101 0011 s nnnn -iii dddd iiyy mmmm", SHIFTED, ORN_REG, BASE, 1, 1)                                        \
  ROW("1110101 0100 1 nnnn -iii 1111 iiyy mmmm", SHIFTED, TEQ_REG, BASE, 1, 1)                                        \
  ROW("1110101 0100 s nnnn -iii dddd iiyy mmmm", SHIFTED, EOR_REG, BASE, 1, 1)                                        \
  ROW("1110101 0110 0 nnnn -iii dddd iiy0 mmmm", PACK, PKH, DSP, 1, 1)                                                \
  ROW("1110101 1000 1 nnnn -iii 1111 iiyy mmmm", SHIFTED, CMN_REG, BASE, 1, 1)                                        \
  ROW("1110101 1000 s nnnn -iii dddd iiyy mmmm", SHIFTED, ADD_REG, BASE, 1, 1)                                        \
  ROW("1110101 1010 s nnnn -iii dddd iiyy mmmm", SHIFTED, ADC_REG, BASE, 1, 1)                                        \
  ROW("1110101 1011 s nnnn -iii dddd iiyy mmmm", SHIFTED, SBC_REG, BASE, 1, 1)                                        \
  ROW("1110101 1101 1 nnnn -iii 1111 iiyy mmmm", SHIFTED, CMP_REG, BASE, 1, 1)                                        \
  ROW("1110101 1101 s nnnn -iii dddd iiyy mmmm", SHIFTED, SUB_REG, BASE, 1, 1)                                        \
  ROW("1110101 1110 s nnnn -iii dddd iiyy mmmm", SHIFTED, RSB_REG, BASE, 1, 1)                                        \
  /* 32 bits: data processing with a modified constant (A5.3.1) */                                                    \
  ROW("11110 i 0 0000 1 nnnn 0 iii 1111 iiiiiiii", CONSTANT, TST_IMM, BASE, 1, 1)                                     \
  ROW("11110 i 0 0000 s nnnn 0 iii dddd iiiiiiii", CONSTANT, AND_IMM, BASE, 1, 1)                                     \
  ROW("11110 i 0 0001 s nnnn 0 iii dddd iiiiiiii", CONSTANT, BIC_IMM, BASE, 1, 1)                                     \
  ROW("11110 i 0 0010 s 1111 0 iii dddd iiiiiiii", CONSTANT, MOV_IMM, BASE, 1, 1)                                     \
  ROW("11110 i 0 0010 s nnnn 0 iii dddd iiiiiiii", CONSTANT, ORR_IMM, BASE, 1, 1)                                     \
  ROW("11110 i 0 0011 s 1111 0 iii dddd iiiiiiii", CONSTANT, MVN_IMM, BASE, 1, 1)                                     \
  ROW("11110 i 0 0011 s nnnn 0 iii dddd iiiiiiii", CONSTANT, ORN_IMM, BASE, 1, 1)                                     \
  ROW("11110 i 0 0100 1 nnnn 0 iii 1111 iiiiiiii", CONSTANT, TEQ_IMM, BASE, 1, 1)                                     \
  ROW("11110 i 0 0100 s nnnn 0 iii dddd iiiiiiii", CONSTANT, EOR_IMM, BASE, 1, 1)                                     \
  ROW("11110 i 0 1000 1 nnnn 0 iii 1111 iiiiiiii", CONSTANT, CMN_IMM, BASE, 1, 1)                                     \
  ROW("11110 i 0 1000 s nnnn 0 iii dddd iiiiiiii", CONSTANT, ADD_IMM, BASE, 1, 1)                                     \
  ROW("11110 i 0 1010 s nnnn 0 iii dddd iiiiiiii", CONSTANT, ADC_IMM, BASE, 1, 1)                                     \
  ROW("11110 i 0 1011 s nnnn 0 iii dddd iiiiiiii", CONSTANT, SBC_IMM, BASE, 1, 1)                                     \
  ROW("11110 i 0 1101 1 nnnn 0 iii 1111 iiiiiiii", CONSTANT, CMP_IMM, BASE, 1, 1)                                     \
  ROW("11110 i 0 1101 s nnnn 0 iii dddd iiiiiiii", CONSTANT, SUB_IMM, BASE, 1, 1)                                     \
  ROW("11110 i 0 1110 s nnnn 0 iii dddd iiiiiiii", CONSTANT, RSB_IMM, BASE, 1, 1)                                     \
  /* 32 bits: data processing with a plain constant (A5.3.3) */                                                       \
  ROW("11110 i 1 0000 0 1111 0 iii dddd iiiiiiii", ADR_UP, MOV_IMM_NF, BASE, 1, 1)                                    \
  ROW("11110 i 1 0000 0 nnnn 0 iii dddd iiiiiiii", WIDE, ADD_IMM_NF, BASE, 1, 1)                                      \
  ROW("11110 i 1 0010 0 iiii 0 iii dddd iiiiiiii", CONSTANT_16, MOV_IMM_NF, BASE, 1, 1)                               \
  ROW("11110 i 1 0101 0 1111 0 iii dddd iiiiiiii", ADR_DOWN, MOV_IMM_NF, BASE, 1, 1)                                  \
  ROW("11110 i 1 0101 0 nnnn 0 iii dddd iiiiiiii", WIDE, SUB_IMM_NF, BASE, 1, 1)                                      \
  ROW("11110 i 1 0110 0 iiii 0 iii dddd iiiiiiii", CONSTANT_16, MOVT, BASE, 1, 1)                                     \
  ROW("11110 0 1 1001 0 nnnn 0000 dddd 00-- iiii", DSP_SSAT16, DSP, DSP, 1, 1)                                        \
  ROW("11110 0 1 100y 0 nnnn 0iii dddd ii- aaaaa", SATURATE, SSAT, BASE, 1, 1)                                        \
  ROW("11110 0 1 1010 0 nnnn 0iii dddd ii- aaaaa", FIELD, SBFX, BASE, 1, 1)                                           \
  ROW("11110 0 1 1011 0 1111 0iii dddd ii- aaaaa", FIELD_TO, BFC, BASE, 1, 1)                                         \
  ROW("11110 0 1 1011 0 nnnn 0iii dddd ii- aaaaa", FIELD_TO, BFI, BASE, 1, 1)                                         \
  ROW("11110 0 1 1101 0 nnnn 0000 dddd 00-- iiii", DSP_USAT16, DSP, DSP, 1, 1)                                        \
  ROW("11110 0 1 110y 0 nnnn 0iii dddd ii- aaaaa", SATURATE, USAT, BASE, 1, 1)                                        \
  ROW("11110 0 1 1110 0 nnnn 0iii dddd ii- aaaaa", FIELD, UBFX, BASE, 1, 1)                                           \
  /* 32 bits: branches, miscellaneous control (A5.3.4) */                                                             \
  ROW("11110 0 1110 0 - nnnn 10-0 ii00 aaaaaaaa", SPECIAL, MSR, BASE, 2, 2)                                           \
  ROW("11110 0 1110 10 ---- 10-0 -000 00000010", PLAIN, WFE, BASE, 1, 1)                                              \
  ROW("11110 0 1110 10 ---- 10-0 -000 00000011", PLAIN, WFI, BASE, 1, 1)                                              \
  ROW("11110 0 1110 10 ---- 10-0 -000 00000100", PLAIN, SEV, BASE, 1, 1)                                              \
  ROW("11110 0 1110 10 ---- 10-0 -000 --------", PLAIN, NOP, BASE, 1, 1)                                              \
  ROW("11110 0 1110 11 ---- 10-0 ---- 0010 ----", PLAIN, CLREX, BASE, 1, 1)                                           \
  ROW("11110 0 1110 11 ---- 10-0 ---- 01-- ----", PLAIN, NOP, BASE, 1, 1)                                             \
  ROW("11110 0 1111 1 - ---- 10-0 dddd aaaaaaaa", SPECIAL, MRS, BASE, 2, 2)                                           \
  ROW("11110 g cc cc ii iiii 10 j 0 j iiiiiiiiiii", BRANCH_20, BEQ, BASE, 1, 1)                                       \
  ROW("11110 g iiiiiiiiii 10 j 1 j iiiiiiiiiii", BRANCH_24, B, BASE, 1, 1)                                            \
  ROW("11110 g iiiiiiiiii 11 j 1 j iiiiiiiiiii", BRANCH_24, BL, BASE, 1, 1)                                           \
  /* 32 bits: loads and stores of one register (A5.3.7 to A5.3.10); a byte or half to PC is a hint */                 \
  ROW("1111100 0 - 00 1 1111 1111 ---- ---- ----", PLAIN, NOP, BASE, 2, 1)                                            \
  ROW("1111100 0 u 00 1 1111 tttt iiiiiiiiiiii", LITERAL, LDRB_LITERAL, BASE, 2, 1)                                   \
  ROW("1111100 0 1 00 1 ---- 1111 ---- ---- ----", PLAIN, NOP, BASE, 2, 1)                                            \
  ROW("1111100 0 0 00 1 ---- 1111 1100 ---- ----", PLAIN, NOP, BASE, 2, 1)                                            \
  ROW("1111100 0 0 00 1 ---- 1111 0000 00-- ----", PLAIN, NOP, BASE, 2, 1)                                            \
  ROW("1111100 0 - 01 1 1111 1111 ---- ---- ----", PLAIN, NOP, BASE, 2, 1)                                            \
  ROW("1111100 0 u 01 1 1111 tttt iiiiiiiiiiii", LITERAL, LDRH_LITERAL, BASE, 2, 1)                                   \
  ROW("1111100 0 1 01 1 ---- 1111 ---- ---- ----", PLAIN, NOP, BASE, 2, 1)                                            \
  ROW("1111100 0 0 01 1 ---- 1111 1100 ---- ----", PLAIN, NOP, BASE, 2, 1)                                            \
  ROW("1111100 0 0 01 1 ---- 1111 0000 00-- ----", PLAIN, NOP, BASE, 2, 1)                                            \
  ROW("1111100 1 - 00 1 1111 1111 ---- ---- ----", PLAIN, NOP, BASE, 2, 1)                                            \
  ROW("1111100 1 u 00 1 1111 tttt iiiiiiiiiiii", LITERAL, LDRSB_LITERAL, BASE, 2, 1)                                  \
  ROW("1111100 1 1 00 1 ---- 1111 ---- ---- ----", PLAIN, NOP, BASE, 2, 1)                                            \
  ROW("1111100 1 0 00 1 ---- 1111 1100 ---- ----", PLAIN, NOP, BASE, 2, 1)                                            \
  ROW("1111100 1 0 00 1 ---- 1111 0000 00-- ----", PLAIN, NOP, BASE, 2, 1)                                            \
  ROW("1111100 1 - 01 1 1111 1111 ---- ---- ----", PLAIN, NOP, BASE, 2, 1)                                            \
  ROW("1111100 1 u 01 1 1111 tttt iiiiiiiiiiii", LITERAL, LDRSH_LITERAL, BASE, 2, 1)                                  \
  ROW("1111100 1 1 01 1 ---- 1111 ---- ---- ----", PLAIN, NOP, BASE, 2, 1)                                            \
  ROW("1111100 1 0 01 1 ---- 1111 1100 ---- ----", PLAIN, NOP, BASE, 2, 1)                                            \
  ROW("1111100 1 0 01 1 ---- 1111 0000 00-- ----", PLAIN, NOP, BASE, 2, 1)                                            \
  ROW("1111100 0 u 10 1 1111 1111 iiiiiiiiiiii", LITERAL, LDR_PC_LITERAL, BASE, 2, 1)                                 \
  ROW("1111100 0 u 10 1 1111 tttt iiiiiiiiiiii", LITERAL, LDR_LITERAL, BASE, 2, 1)                                    \
  ROW("1111100 0 1 00 0 nnnn tttt iiiiiiiiiiii", ADDRESS_12, STRB_OFFSET, BASE, 2, 1)                                 \
  ROW("1111100 0 0 00 0 nnnn tttt 0000 00ii mmmm", ADDRESS_INDEX, STRB_INDEX, BASE, 2, 1)                             \
  ROW("1111100 0 0 00 0 nnnn tttt 1puw iiiiiiii", ADDRESS_8, STRB_OFFSET, BASE, 2, 1)                                 \
  ROW("1111100 0 1 00 1 nnnn tttt iiiiiiiiiiii", ADDRESS_12, LDRB_OFFSET, BASE, 2, 1)                                 \
  ROW("1111100 0 0 00 1 nnnn tttt 0000 00ii mmmm", ADDRESS_INDEX, LDRB_INDEX, BASE, 2, 1)                             \
  ROW("1111100 0 0 00 1 nnnn tttt 1puw iiiiiiii", ADDRESS_8, LDRB_OFFSET, BASE, 2, 1)                                 \
  ROW("1111100 0 1 01 0 nnnn tttt iiiiiiiiiiii", ADDRESS_12, STRH_OFFSET, BASE, 2, 1)                                 \
  ROW("1111100 0 0 01 0 nnnn tttt 0000 00ii mmmm", ADDRESS_INDEX, STRH_INDEX, BASE, 2, 1)                             \
  ROW("1111100 0 0 01 0 nnnn tttt 1puw iiiiiiii", ADDRESS_8, STRH_OFFSET, BASE, 2, 1)                                 \
  ROW("1111100 0 1 01 1 nnnn tttt iiiiiiiiiiii", ADDRESS_12, LDRH_OFFSET, BASE, 2, 1)                                 \
  ROW("1111100 0 0 01 1 nnnn tttt 0000 00ii mmmm", ADDRESS_INDEX, LDRH_INDEX, BASE, 2, 1)                             \
  ROW("1111100 0 0 01 1 nnnn tttt 1puw iiiiiiii", ADDRESS_8, LDRH_OFFSET, BASE, 2, 1)                                 \
  ROW("1111100 0 1 10 0 nnnn tttt iiiiiiiiiiii", ADDRESS_12, STR_OFFSET, BASE, 2, 1)                                  \
  ROW("1111100 0 0 10 0 nnnn tttt 0000 00ii mmmm", ADDRESS_INDEX, STR_INDEX, BASE, 2, 1)                              \
  ROW("1111100 0 0 10 0 nnnn tttt 1puw iiiiiiii", ADDRESS_8, STR_OFFSET, BASE, 2, 1)                                  \
  ROW("1111100 0 1 10 1 nnnn tttt iiiiiiiiiiii", ADDRESS_12, LDR_OFFSET, BASE, 2, 1)                                  \
  ROW("1111100 0 0 10 1 nnnn tttt 0000 00ii mmmm", ADDRESS_INDEX, LDR_INDEX, BASE, 2, 1)                              \
  ROW("1111100 0 0 10 1 nnnn tttt 1puw iiiiiiii", ADDRESS_8, LDR_OFFSET, BASE, 2, 1)                                  \
  ROW("1111100 1 1 00 1 nnnn tttt iiiiiiiiiiii", ADDRESS_12, LDRSB_OFFSET, BASE, 2, 1)                                \
  ROW("1111100 1 0 00 1 nnnn tttt 0000 00ii mmmm", ADDRESS_INDEX, LDRSB_INDEX, BASE, 2, 1)                            \
  ROW("1111100 1 0 00 1 nnnn tttt 1puw iiiiiiii", ADDRESS_8, LDRSB_OFFSET, BASE, 2, 1)                                \
  ROW("1111100 1 1 01 1 nnnn tttt iiiiiiiiiiii", ADDRESS_12, LDRSH_OFFSET, BASE, 2, 1)                                \
  ROW("1111100 1 0 01 1 nnnn tttt 0000 00ii mmmm", ADDRESS_INDEX, LDRSH_INDEX, BASE, 2, 1)                            \
  ROW("1111100 1 0 01 1 nnnn tttt 1puw iiiiiiii", ADDRESS_8, LDRSH_OFFSET, BASE, 2, 1)                                \
  /* 32 bits: data processing of registers (A5.3.12 to A5.3.15) */                                                    \
  ROW("11111010 000 s nnnn 1111 dddd 0000 mmmm", WIDE, LSL_BY, BASE, 1, 1)                                            \
  ROW("11111010 001 s nnnn 1111 dddd 0000 mmmm", WIDE, LSR_BY, BASE, 1, 1)                                            \
  ROW("11111010 010 s nnnn 1111 dddd 0000 mmmm", WIDE, ASR_BY, BASE, 1, 1)                                            \
  ROW("11111010 011 s nnnn 1111 dddd 0000 mmmm", WIDE, ROR_BY, BASE, 1, 1)                                            \
  ROW("11111010 0000 1111 1111 dddd 1-ii mmmm", ROTATED, SXTH, BASE, 1, 1)                                            \
  ROW("11111010 0001 1111 1111 dddd 1-ii mmmm", ROTATED, UXTH, BASE, 1, 1)                                            \
  ROW("11111010 0100 1111 1111 dddd 1-ii mmmm", ROTATED, SXTB, BASE, 1, 1)                                            \
  ROW("11111010 0101 1111 1111 dddd 1-ii mmmm", ROTATED, UXTB, BASE, 1, 1)                                            \
  ROW("11111010 0yyy nnnn 1111 dddd 1-ii mmmm", DSP_EXTEND, DSP, DSP, 1, 1)                                           \
  ROW("11111010 1yyy nnnn 1111 dddd 0aaa mmmm", DSP_PARALLEL, DSP, DSP, 1, 1)                                         \
  ROW("11111010 1000 nnnn 1111 dddd 10yy mmmm", DSP_SATURATE, DSP, DSP, 1, 1)                                         \
  ROW("11111010 1001 ---- 1111 dddd 1000 mmmm", WIDE, REV, BASE, 1, 1)                                                \
  ROW("11111010 1001 ---- 1111 dddd 1001 mmmm", WIDE, REV16, BASE, 1, 1)                                              \
  ROW("11111010 1001 ---- 1111 dddd 1010 mmmm", WIDE, RBIT, BASE, 1, 1)                                               \
  ROW("11111010 1001 ---- 1111 dddd 1011 mmmm", WIDE, REVSH, BASE, 1, 1)                                              \
  ROW("11111010 1010 nnnn 1111 dddd 1000 mmmm", DSP_SELECT, DSP, DSP, 1, 1)                                           \
  ROW("11111010 1011 ---- 1111 dddd 1000 mmmm", WIDE, CLZ, BASE, 1, 1)                                                \
  /* 32 bits: products and divisions (A5.3.16, A5.3.17) */                                                            \
  ROW("11111011 0000 nnnn 1111 dddd 0000 mmmm", WIDE, MUL_NF, BASE, 1, 1)                                             \
  ROW("11111011 0000 nnnn aaaa dddd 0000 mmmm", WIDE, MLA, BASE, 2, 1)                                                \
  ROW("11111011 0000 nnnn aaaa dddd 0001 mmmm", WIDE, MLS, BASE, 2, 1)                                                \
  ROW("11111011 0yyy nnnn aaaa dddd 00ii mmmm", DSP_PRODUCT, SMLAX, DSP, 2, 1)                                        \
  ROW("11111011 1000 nnnn tttt aaaa 0000 mmmm", LONG, SMULL, BASE, 4, 1)                                              \
  ROW("11111011 1001 nnnn ---- dddd 1111 mmmm", WIDE, SDIV, BASE, 7, 7)                                               \
  ROW("11111011 1010 nnnn tttt aaaa 0000 mmmm", LONG, UMULL, BASE, 4, 1)                                              \
  ROW("11111011 1011 nnnn ---- dddd 1111 mmmm", WIDE, UDIV, BASE, 7, 7)                                               \
  ROW("11111011 1100 nnnn tttt aaaa 0000 mmmm", LONG, SMLAL, BASE, 6, 1)                                              \
  ROW("11111011 1100 nnnn tttt aaaa 1iii mmmm", DSP_LONG, SMLALX, DSP, 6, 1)                                          \
  ROW("11111011 1101 nnnn tttt aaaa 110i mmmm", DSP_LONG_DIFFERENCE, SMLALX, DSP, 6, 1)                               \
  ROW("11111011 1110 nnnn tttt aaaa 0000 mmmm", LONG, UMLAL, BASE, 6, 1)                                              \
  ROW("11111011 1110 nnnn tttt aaaa 0110 mmmm", LONG, UMAAL, DSP, 6, 1)                                               \
  /* Floating point: registers to and from memory and core (A6.5 to A6.7); z: double precision */                     \
  ROW("11101100 010 0 aaaa tttt 101z 00 m 1 mmmm", FLOAT_CORE_PAIR, VMOV_PAIR_FROM_CORE, FP, 1, 1)                    \
  ROW("11101100 010 1 aaaa tttt 101z 00 m 1 mmmm", FLOAT_CORE_PAIR, VMOV_PAIR_TO_CORE, FP, 1, 1)                      \
  ROW("1110110 1 u d 0 0 nnnn dddd 101z iiiiiiii", FLOAT_ADDRESS, VSTR, FP, 1, 1)                                     \
  ROW("1110110 1 u d 0 1 1111 dddd 101z iiiiiiii", FLOAT_ADDRESS, VLDR_LITERAL, FP, 1, 1)                             \
  ROW("1110110 1 u d 0 1 nnnn dddd 101z iiiiiiii", FLOAT_ADDRESS, VLDR, FP, 1, 1)                                     \
  ROW("1110110 p u d w 0 nnnn dddd 101z iiiiiiii", FLOAT_MULTIPLE, VSTM, FP, 1, PAIRS)                                \
  ROW("1110110 p u d w 1 nnnn dddd 101z iiiiiiii", FLOAT_MULTIPLE, VLDM, FP, 1, PAIRS)                                \
  ROW("11101110 000 0 nnnn tttt 1010 n -- 1 ----", FLOAT_CORE, VMOV_FROM_CORE, FP, 1, 1)                              \
  ROW("11101110 000 1 nnnn tttt 1010 n -- 1 ----", FLOAT_CORE, VMOV_TO_CORE, FP, 1, 1)                                \
  ROW("11101110 00 i 0 nnnn tttt 1011 n 00 1 ----", FLOAT_CORE_HALF, VMOV_FROM_CORE, FP, 1, 1)                        \
  ROW("11101110 00 i 1 nnnn tttt 1011 n 00 1 ----", FLOAT_CORE_HALF, VMOV_TO_CORE, FP, 1, 1)                          \
  ROW("11101110 1110 0001 tttt 1010 - -- 1 ----", FLOAT_CORE, VMSR, FP, 1, 1)                                         \
  ROW("11101110 1111 0001 tttt 1010 - -- 1 ----", PLAIN, VMRS, FP, 1, 1)                                              \
  /* Floating point: arithmetic (A6.4); the constant says which operation of operations.h */                          \
  FLOAT_ROW("11101110 0 d 00 nnnn dddd 101z n 0 m 0 mmmm", MLA, 1, 3)                                                 \
  FLOAT_ROW("11101110 0 d 00 nnnn dddd 101z n 1 m 0 mmmm", MLS, 1, 3)                                                 \
  FLOAT_ROW("11101110 0 d 01 nnnn dddd 101z n 0 m 0 mmmm", NMLS, 1, 3)                                                \
  FLOAT_ROW("11101110 0 d 01 nnnn dddd 101z n 1 m 0 mmmm", NMLA, 1, 3)                                                \
  FLOAT_ROW("11101110 0 d 10 nnnn dddd 101z n 0 m 0 mmmm", MUL, 1, 3)                                                 \
  FLOAT_ROW("11101110 0 d 10 nnnn dddd 101z n 1 m 0 mmmm", NMUL, 1, 3)                                                \
  FLOAT_ROW("11101110 0 d 11 nnnn dddd 101z n 0 m 0 mmmm", ADD, 1, 1)                                                 \
  FLOAT_ROW("11101110 0 d 11 nnnn dddd 101z n 1 m 0 mmmm", SUB, 1, 1)                                                 \
  FLOAT_ROW("11101110 1 d 00 nnnn dddd 101z n 0 m 0 mmmm", DIV, 14, 28)                                               \
  FLOAT_ROW("11101110 1 d 01 nnnn dddd 101z n 0 m 0 mmmm", FNMS, 1, 3)                                                \
  FLOAT_ROW("11101110 1 d 01 nnnn dddd 101z n 1 m 0 mmmm", FNMA, 1, 3)                                                \
  FLOAT_ROW("11101110 1 d 10 nnnn dddd 101z n 0 m 0 mmmm", FMA, 1, 3)                                                 \
  FLOAT_ROW("11101110 1 d 10 nnnn dddd 101z n 1 m 0 mmmm", FMS, 1, 3)                                                 \
  FLOAT_ROW("11101110 1 d 11 iiii dddd 101z - 0 - 0 iiii", CONSTANT, 1, 1)                                            \
  FLOAT_ROW("11101110 1 d 11 0000 dddd 101z 0 1 m 0 mmmm", MOV, 1, 1)                                                 \
  FLOAT_ROW("11101110 1 d 11 0000 dddd 101z 1 1 m 0 mmmm", ABS, 1, 1)                                                 \
  FLOAT_ROW("11101110 1 d 11 0001 dddd 101z 0 1 m 0 mmmm", NEG, 1, 1)                                                 \
  FLOAT_ROW("11101110 1 d 11 0001 dddd 101z 1 1 m 0 mmmm", SQRT, 14, 28)                                              \
  FLOAT_ROW("11101110 1 d 11 0010 dddd 101z i 1 m 0 mmmm", FROM_HALF, 1, 1)                                           \
  FLOAT_ROW("11101110 1 d 11 0011 dddd 101z i 1 m 0 mmmm", TO_HALF, 1, 1)                                             \
  FLOAT_ROW("11101110 1 d 11 0100 dddd 101z i 1 m 0 mmmm", CMP, 1, 1)                                                 \
  FLOAT_ROW("11101110 1 d 11 0101 dddd 101z i 1 - 0 ----", CMP_ZERO, 1, 1)                                            \
  FLOAT_ROW("11101110 1 d 11 0110 dddd 101z 0 1 m 0 mmmm", RINT_R, 1, 1)                                              \
  FLOAT_ROW("11101110 1 d 11 0110 dddd 101z 1 1 m 0 mmmm", RINT_Z, 1, 1)                                              \
  FLOAT_ROW("11101110 1 d 11 0111 dddd 101z 0 1 m 0 mmmm", RINT_X, 1, 1)                                              \
  FLOAT_ROW("11101110 1 d 11 0111 dddd 101z 1 1 m 0 mmmm", PRECISION, 1, 1)                                           \
  FLOAT_ROW("11101110 1 d 11 1000 dddd 101z i 1 m 0 mmmm", FROM_INT, 1, 1)                                            \
  FLOAT_ROW("11101110 1 d 11 101i dddd 101z i 1 i 0 iiii", FROM_FIXED, 1, 1)                                          \
  FLOAT_ROW("11101110 1 d 11 110i dddd 101z i 1 m 0 mmmm", TO_INT, 1, 1)                                              \
  FLOAT_ROW("11101110 1 d 11 111i dddd 101z i 1 i 0 iiii", TO_FIXED, 1, 1)                                            \
  FLOAT_ROW("11111110 0 d ii nnnn dddd 101z n 0 m 0 mmmm", SEL, 1, 1)                                                 \
  FLOAT_ROW("11111110 1 d 00 nnnn dddd 101z n 0 m 0 mmmm", MAXNM, 1, 1)                                               \
  FLOAT_ROW("11111110 1 d 00 nnnn dddd 101z n 1 m 0 mmmm", MINNM, 1, 1)                                               \
  FLOAT_ROW("11111110 1 d 11 10ii dddd 101z 0 1 m 0 mmmm", RINT_TO, 1, 1)                                             \
  FLOAT_ROW("11111110 1 d 11 11ii dddd 101z i 1 m 0 mmmm", TO_INT_BY, 1, 1)                                           \

#endif
