// SPDX-License-Identifier: GPL-2.0-or-later
//
// Registers of the MPU-9250 (RM-MPU-9250A-00) and of the AK8963 in it (MS1356-E).

#pragma once

#define MPU 0x68u // AD0 low
#define MPU_SMPLRT_DIV 0x19u
#define MPU_CONFIG 0x1Au
#define MPU_GYRO_CONFIG 0x1Bu
#define MPU_ACCEL_CONFIG 0x1Cu
#define MPU_ACCEL_CONFIG2 0x1Du
#define MPU_INT_PIN_CFG 0x37u
#define MPU_INT_ENABLE 0x38u
#define MPU_INT_STATUS 0x3Au // followed by ACCEL_XOUT_H .. GYRO_ZOUT_L, 14 bytes
#define MPU_PWR_MGMT_1 0x6Bu
#define MPU_WHO_AM_I 0x75u

#define MPU_ID 0x71u
#define MPU_RESET 0x80u
#define MPU_CLOCK_PLL 0x01u
#define MPU_DLPF_41HZ 0x03u // of the gyroscope; the accelerometer's 3 is 44.8 Hz
#define MPU_RATE_200HZ 0x04u
#define MPU_250DPS 0x00u
#define MPU_2G 0x00u
#define MPU_INT_LATCH_ANYRD_BYPASS 0x32u // INT stays until any register is read; the AK8963 is on the bus itself
#define MPU_RAW_RDY 0x01u

#define AK 0x0Cu
#define AK_WIA 0x00u
#define AK_ST1 0x02u // followed by HXL .. HZH and ST2, 7 bytes
#define AK_CNTL1 0x0Au
#define AK_ASAX 0x10u

#define AK_ID 0x48u
#define AK_DRDY 0x01u
#define AK_HOFL 0x08u // of ST2: the field was too strong
#define AK_POWER_DOWN 0x00u
#define AK_FUSE_ROM 0x0Fu
#define AK_16BIT_100HZ 0x16u
