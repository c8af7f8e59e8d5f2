// SPDX-License-Identifier: GPL-2.0-or-later
//
// The boot loader's bytes, for an image that holds both it and the application.

__asm(".section .boot_loader, \"a\"\n"
      ".incbin \"boot-loader.bin\"\n"
      ".balign 0x2000, 0xFF\n");
