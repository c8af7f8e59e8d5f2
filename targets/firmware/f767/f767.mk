# SPDX-License-Identifier: GPL-2.0-or-later
#
# Images for the STM32F767ZI on a Nucleo-144. Included by the Makefile one folder up; they share nothing with the rover.

F767_CPU     := -mcpu=cortex-m7 -mfpu=fpv5-d16 -mfloat-abi=hard -mthumb
F767_CFLAGS  := $(F767_CPU) $(filter-out -mcpu=% -mthumb,$(CFLAGS)) -ffp-contract=off -fno-math-errno -g1
F767_LDFLAGS := $(F767_CPU) $(filter-out -mcpu=% -mthumb,$(LDFLAGS)) -Lf767

$(BUILD)/f767/%.o: CFLAGS = $(F767_CFLAGS)
$(BUILD)/f767/%.o: %.c Makefile f767/f767.mk
	$(compile)

# $(call f767,NAME,SOURCES without .c)
define f767
all: $(IMAGES)/f767-$(1).elf
$(IMAGES)/f767-$(1).elf: $(patsubst %,$(BUILD)/f767/%.o,f767/startup common/memory $(2)) common/sections.ld f767/f767.ld
	@mkdir -p $$(@D)
	$(CC) $(F767_LDFLAGS) -T f767/f767.ld $$(filter %.o,$$^) -lgcc -o $$@
endef

$(BUILD)/f767/common/console.o: CPPFLAGS += -DSEMIHOSTING=$(SEMIHOSTING)

F767_CHECK := common/check common/console common/text
$(eval $(call f767,demo,f767/demo f767/number f767/clock))
$(eval $(call f767,sleep,f767/sleep f767/clock))
$(eval $(call f767,ticker,f767/ticker f767/lp_ticker f767/clock))
$(eval $(call f767,flash,f767/flash f767/clock common/text))
$(eval $(call f767,chip,f767/chip f767/clock $(F767_CHECK)))
$(eval $(call f767,lptim,f767/lptim common/lptim_block $(F767_CHECK)))
$(foreach name,adc dma i2c pins serial spi timers,$(eval $(call f767,$(name),f767/$(name) f767/clock $(F767_CHECK))))
