// SPDX-License-Identifier: GPL-2.0-or-later
//
// The four functions GCC may call even in freestanding code (GCC manual, "Standards").

#pragma once

#include <stddef.h>

void *memcpy(void *restrict to, const void *restrict from, size_t count);
void *memmove(void *to, const void *from, size_t count);
void *memset(void *to, int value, size_t count);
int memcmp(const void *a, const void *b, size_t count);
