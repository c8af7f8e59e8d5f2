# SPDX-License-Identifier: GPL-2.0-or-later
#
# The vehicle interface's images, for the STM32H753ZI. Included by the Makefile one folder up.

VEHICLE_CPU     := -mcpu=cortex-m7 -mfpu=fpv5-d16 -mfloat-abi=hard -mthumb
# As for the rover: a product and a sum are rounded one after the other; debug information ends with functions and lines.
VEHICLE_CFLAGS  := $(VEHICLE_CPU) $(filter-out -mcpu=% -mthumb,$(CFLAGS)) -g1 -ffp-contract=off -fno-math-errno
VEHICLE_LDFLAGS := $(VEHICLE_CPU) $(filter-out -mcpu=% -mthumb,$(LDFLAGS)) -Lvehicle_interface

# What is the same in all images, and what asks for an option and so is compiled for each: options.h sees to it.
VEHICLE_SAME := startup exchange board/clock board/lights kernel/kernel simulator/command simulator/status stack/crc \
                stack/frames stack/messages stack/lamps
VEHICLE_EACH := main board/joystick board/simulator_line board/stack_line board/watchdog control/control control/inputs \
                control/stick stack/driving_stack

$(BUILD)/vehicle_interface/%.o: CFLAGS = $(VEHICLE_CFLAGS)
$(BUILD)/vehicle_interface/memory.o: common/memory.c Makefile vehicle_interface/vehicle_interface.mk
	$(compile)

$(BUILD)/vehicle_interface/xrce/%.o: xrce/%.c Makefile vehicle_interface/vehicle_interface.mk
	$(compile)

# $(call vehicle,NAME,FLAGS[,more OBJECTS])
define vehicle
all: $(IMAGES)/$(1).elf
$(BUILD)/vehicle_interface/$(1)/%.o: CFLAGS = $(VEHICLE_CFLAGS) -DVEHICLE_IMAGE $(2)
$(BUILD)/vehicle_interface/$(1)/%.o: vehicle_interface/%.c Makefile vehicle_interface/vehicle_interface.mk
	$$(compile)
$(IMAGES)/$(1).elf: $(VEHICLE_EACH:%=$(BUILD)/vehicle_interface/$(1)/%.o) $(VEHICLE_SAME:%=$(BUILD)/vehicle_interface/%.o) $(3) \
                    $(BUILD)/vehicle_interface/memory.o common/sections.ld vehicle_interface/vehicle.ld
	@mkdir -p $$(@D)
	$(CC) $(VEHICLE_LDFLAGS) -T vehicle_interface/vehicle.ld $$(filter %.o,$$^) -lgcc -o $$@
endef

$(eval $(call vehicle,vehicle,))

# One image for each defect: vehicle-h2 has DEFECT_H2.
VEHICLE_DEFECTS := H1 H2 DIES_ON_ERROR H6 H7 H8 H9 ONE_MISS NO_PADDING NO_FACTOR FLAG_CLASH UNWATCHED EMERGENCY_REQUESTS \
                   BOTH_AUTOWARE STALE_STATUS EMERGENCY_MANUAL EMERGENCY_KEPT NO_CLAMP AXES_SWAPPED NO_LAMPS NO_WATCHDOG
$(foreach name,$(VEHICLE_DEFECTS),$(eval $(call vehicle,vehicle-$(call dashed,$(name)),-DDEFECT_$(name)=1)))

# All that a published firmware has.
VEHICLE_V0 := $(filter-out ONE_MISS NO_PADDING NO_FACTOR FLAG_CLASH EMERGENCY_MANUAL AXES_SWAPPED,$(VEHICLE_DEFECTS))
$(eval $(call vehicle,vehicle-v0,$(VEHICLE_V0:%=-DDEFECT_%=1)))

VEHICLE_V1 := $(filter-out EMERGENCY_KEPT,$(VEHICLE_V0)) FLAG_CLASH EMERGENCY_MANUAL
$(eval $(call vehicle,vehicle-v1,$(VEHICLE_V1:%=-DDEFECT_%=1)))

# The same with DDS-XRCE in the place of the stand-in link.
VEHICLE_XRCE := $(addprefix $(BUILD)/vehicle_interface/xrce/,client streams objects cdr frames)
define vehicle_micro_ros
$(BUILD)/vehicle_interface/$(1)/stack/driving_stack.o: CFLAGS += -include vehicle_interface/stack/micro_ros.h
$(call vehicle,$(1),$(2),$(BUILD)/vehicle_interface/$(1)/stack/micro_ros.o $(VEHICLE_XRCE:%=%.o))
endef

$(eval $(call vehicle_micro_ros,vehicle-micro-ros,))
$(eval $(call vehicle_micro_ros,vehicle-micro-ros-v0,$(VEHICLE_V0:%=-DDEFECT_%=1)))
$(eval $(call vehicle_micro_ros,vehicle-micro-ros-v1,$(VEHICLE_V1:%=-DDEFECT_%=1)))
