"""The MPU-9250, an inertial sensor with a magnetometer. Start at `mpu9250.py`.

Sources: RM-MPU-9250A-00 rev. 1.4 (register map), PS-MPU-9250A-01 rev. 1.0 (data sheet), MS1356-E-02 (AK8963).
"""

from __future__ import annotations

from targets.parts.mpu9250.mpu9250 import Mpu9250
from targets.parts.mpu9250.notes import SensorNote
from targets.parts.mpu9250.settings import Mpu9250Settings

__all__ = ["Mpu9250", "Mpu9250Settings", "SensorNote"]
