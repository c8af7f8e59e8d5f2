# SPDX-License-Identifier: GPL-2.0-or-later
#
# Images for the STM32H753ZI on a Nucleo-144. Included by the Makefile one folder up; they share nothing with the vehicle.

H753_CPU     := -mcpu=cortex-m7 -mfpu=fpv5-d16 -mfloat-abi=hard -mthumb
H753_CFLAGS  := $(H753_CPU) $(filter-out -mcpu=% -mthumb,$(CFLAGS)) -ffp-contract=off -fno-math-errno -g1
H753_LDFLAGS := $(H753_CPU) $(filter-out -mcpu=% -mthumb,$(LDFLAGS)) -Lh753

$(BUILD)/h753/%.o: CFLAGS = $(H753_CFLAGS)
$(BUILD)/h753/%.o: %.c Makefile h753/h753.mk
	$(compile)

# $(call h753,NAME,SOURCES without .c)
define h753
all: $(IMAGES)/h753-$(1).elf
$(IMAGES)/h753-$(1).elf: $(patsubst %,$(BUILD)/h753/%.o,h753/startup common/memory $(2)) common/sections.ld h753/h753.ld
	@mkdir -p $$(@D)
	$(CC) $(H753_LDFLAGS) -T h753/h753.ld $$(filter %.o,$$^) -lgcc -o $$@
endef

$(BUILD)/h753/common/console.o: CPPFLAGS += -DSEMIHOSTING=$(SEMIHOSTING)

H753_CHECK := common/check common/console common/text
$(eval $(call h753,demo,h753/demo f767/number h753/clock))
$(eval $(call h753,chip,h753/chip h753/clock $(H753_CHECK)))
$(eval $(call h753,sleep,h753/sleep h753/clock))
$(eval $(call h753,one-shot,h753/one_shot h753/clock))
$(eval $(call h753,usart-fifo,h753/usart_fifo h753/clock $(H753_CHECK)))
$(eval $(call h753,dmamux,h753/dmamux h753/clock $(H753_CHECK)))
$(eval $(call h753,adc16,h753/adc16 h753/clock $(H753_CHECK)))
$(eval $(call h753,lptim,h753/lptim common/lptim_block $(H753_CHECK)))
$(eval $(call h753,flash,h753/flash h753/clock common/text))
$(eval $(call h753,spi,h753/spi h753/clock $(H753_CHECK)))
