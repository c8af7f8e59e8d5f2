# SPDX-License-Identifier: GPL-2.0-or-later
#
# The rover's images, for the STM32F767ZI. Included by the Makefile one folder up.

ROVER_CPU    := -mcpu=cortex-m7 -mfpu=fpv5-d16 -mfloat-abi=hard -mthumb
# A product and a sum are rounded one after the other, as the formulas say; square roots are the instruction. There are many
# images, so their debug information ends with functions and lines.
ROVER_CFLAGS := $(ROVER_CPU) $(filter-out -mcpu=% -mthumb,$(CFLAGS)) -g1 -ffp-contract=off -fno-math-errno
ROVER_LDFLAGS := $(ROVER_CPU) $(filter-out -mcpu=% -mthumb,$(LDFLAGS)) -Lrover

# What is the same in all images, and what asks for an option and so is compiled for each: options.h sees to it.
ROVER_SAME := startup board/clock board/time board/gps_line board/wheels board/leds board/watchdog board/i2c \
              protocol/crc sensors/imu sensors/readings sensors/nmea sensors/gps sensors/angles
ROVER_EACH := main rover board/link board/motors protocol/decoder protocol/encoder protocol/commands protocol/reports \
              control/pid control/drive control/tachometer sensors/attitude

$(BUILD)/rover/%.o: CFLAGS = $(ROVER_CFLAGS)
$(BUILD)/rover/memory.o: common/memory.c Makefile rover/rover.mk
	$(compile)

comma := ,
# $(call rover,NAME,FLAGS[,FRAMING[,SOURCE, without .c, of what comes before main]])
define rover
all: $(IMAGES)/$(1).elf
$(BUILD)/rover/$(1)/%.o: CFLAGS = $(ROVER_CFLAGS) -DROVER_IMAGE $(2)
$(BUILD)/rover/$(1)/%.o: rover/%.c Makefile rover/rover.mk
	$$(compile)
$(IMAGES)/$(1).elf: $(patsubst %,$(BUILD)/rover/$(1)/%.o,$(ROVER_EACH) $(4)) $(ROVER_SAME:%=$(BUILD)/rover/%.o) \
                    $(BUILD)/rover/protocol/body_$(or $(3),len).o $(BUILD)/rover/memory.o common/sections.ld rover/rover.ld
	@mkdir -p $$(@D)
	$(CC) $(ROVER_LDFLAGS) $(if $(4),-Wl$(comma)--wrap=main) -T rover/rover.ld $$(filter %.o,$$^) -lgcc -o $$@
endef

$(eval $(call rover,rover,))

# One image for each defect: rover-no-resync has DEFECT_NO_RESYNC.
ROVER_DEFECTS := NO_RESYNC NO_FRAME_TIMEOUT TIMER_SINCE_RESET POLLED EAGAIN_11 NO_0X81 0X81_LEDS_ONLY NO_LEN_CHECK \
                 THROTTLE_UNCHECKED PID_OFFSETS LED_SHARED NO_LINK_TIMEOUT LINK_STOPS_REPORT_ONLY STATUS_ZERO ACCEL_G \
                 QUAT_WXYZ NAN_QUATERNION GPS_ORDER NO_GPS STALE_BYTE_84 KD_KI_GETTERS SLOW_START FIRST_RPM_1 RPM_150 \
                 RPM_HELD SLOTS_32 PID_NO_RESET PID_WINDUP
dashed = $(shell echo $(1) | tr 'A-Z_' 'a-z-')
# Only 0x85 shows the gains.
ROVER_WITH_KD_KI_GETTERS := -DPID_REPORT_TICKS=100
$(foreach name,$(ROVER_DEFECTS),\
  $(eval $(call rover,rover-$(call dashed,$(name)),-DDEFECT_$(name)=1 $(ROVER_WITH_$(name)))))

# All that G2 has; those of other generations, and what hardware never showed, are left out.
ROVER_G2 := $(filter-out TIMER_SINCE_RESET 0X81_LEDS_ONLY LINK_STOPS_REPORT_ONLY NAN_QUATERNION SLOTS_32,$(ROVER_DEFECTS))
$(eval $(call rover,rover-g2,$(ROVER_G2:%=-DDEFECT_%=1)))

ROVER_G0 := NO_RESYNC TIMER_SINCE_RESET NO_0X81 NO_LEN_CHECK THROTTLE_UNCHECKED ACCEL_G
$(eval $(call rover,rover-g0,$(ROVER_G0:%=-DDEFECT_%=1) -DSCHEMA=SCHEMA_V1 -DRATES=RATES_G0))

ROVER_TERM := NO_RESYNC NO_FRAME_TIMEOUT NO_LINK_TIMEOUT
$(eval $(call rover,rover-term,$(ROVER_TERM:%=-DDEFECT_%=1) \
  -DFRAMING_TERM=1 -DSCHEMA=SCHEMA_V1 -DGENERAL_STATUS=0 -DRATES=RATES_NONE,term))

# The documented rover with other options.
$(eval $(call rover,rover-no-periodic-reports,-DRATES=RATES_NONE))
$(eval $(call rover,rover-g0-rates,-DRATES=RATES_G0))
$(eval $(call rover,rover-v1b,-DSCHEMA=SCHEMA_V1B))
$(eval $(call rover,rover-9600,-DBAUD=9600u))
$(eval $(call rover,rover-dma,-DRECEIVE_BY_DMA=1))
$(eval $(call rover,rover-pwm-1khz,-DPWM_HZ=1000u))
$(eval $(call rover,rover-pid-report,-DPID_REPORT_TICKS=100))

# It asks a serial flash first, at an interface that the emulated chip lacks: one waits for the answer for ever, one goes on
# after a while, and has a defect that has nothing to do with it.
ROVER_LOG := board/log_memory
$(eval $(call rover,rover-log-waits,-DLOG_MEMORY_TRIES=0,,$(ROVER_LOG)))
$(eval $(call rover,rover-log-no-0x81,-DLOG_MEMORY_TRIES=1000 -DDEFECT_NO_0X81=1,,$(ROVER_LOG)))

# The start of Mbed OS 6 before the program: main.c finds it under the name of the one that it calls.
$(eval $(call rover,rover-mbed-start,-Dclock_start=clock_and_tickers_start))
$(IMAGES)/rover-mbed-start.elf: $(BUILD)/rover/board/tickers.o $(BUILD)/f767/f767/lp_ticker.o
# Both, and the defect.
$(eval $(call rover,rover-mbed-log-no-0x81,-Dclock_start=clock_and_tickers_start -DLOG_MEMORY_TRIES=1000 \
  -DDEFECT_NO_0X81=1,,$(ROVER_LOG)))
$(IMAGES)/rover-mbed-log-no-0x81.elf: $(BUILD)/rover/board/tickers.o $(BUILD)/f767/f767/lp_ticker.o
