# SPDX-License-Identifier: GPL-2.0-or-later
#
# Images for an STM32F103 of high density, the xE: what the smaller ones have not; and for an STM32F100RB, of the value line.
# Included by the Makefile one folder up.

# $(call f103e,NAME,SOURCES without .c[,linker script])
define f103e
all: $(IMAGES)/$(1).elf
$(IMAGES)/$(1).elf: $(patsubst %,$(BUILD)/%.o,f103e/startup $(2)) $(COMMON) common/sections.ld f103e/$(or $(3),f103e).ld
	@mkdir -p $$(@D)
	$(CC) $(LDFLAGS) -T f103e/$(or $(3),f103e).ld $$(filter %.o,$$^) $(COMMON) -lgcc -o $$@
endef

$(eval $(call f103e,selftest-dac,selftest/dac))
$(eval $(call f103e,selftest-high-density,selftest/high-density))
$(eval $(call f103e,style-dac-dma,$(addprefix style/hal/,dac-dma hal_tick hal_rcc hal_gpio hal_uart)))
$(eval $(call f103e,style-value-line,style/value-line,f100))
