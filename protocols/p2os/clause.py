"""Where the rules are written, and what they need.

``needs`` of a clause: names of what a bench must be able to do for it to be checked: `server` or `client` under test,
`hangup` (cut the line), `reopen` (close the port and open it again), `baud` (change its rate), `uart` (that rate is the
one of the robot's own port), `flash` (write its FLASH, and switch it on again), `user-io` (drive its inputs),
`aux-loopback`, `truth` (the robot's true pose), `scene` (put it before walls), `rays`, `contacts`, `bumpers`,
`gravity`, `client.commands` (make the client send), `client.report` (ask what it understood), `client.disconnect`
(make it leave).
"""

from __future__ import annotations

from protocols.common.clause import Clause

__all__ = ["Clause"]

MANUAL = "Pioneer 2 Operations Manual"
H8 = "Pioneer 2/3 H8 Operations Manual"
ARIA = "AriaCoda ArRobot.cpp"
CONFIG_READER = "AriaCoda ArRobotConfigPacketReader.h"
PLAYER = "Player p2os driver"
AMRISIM = "AMRISim EmulatePioneer.cc"
ROS = "allenh1/p2os p2os_driver"
ARDUINO = "qemu-gazebo-sim/p2os-arduino"
THESIS = "Seixas and Santos, Embedded systems simulator for robotics applications (USP, 2025)"
CHOICE = "choice: no source says"
SERIAL = "the nature of a serial line, which keeps no packet boundaries"
FRAMING = "the packet format: Pioneer 2 Operations Manual, client-server chapter"
MECHANICS = "rigid-body kinematics"
GEOMETRY = "the exact geometry of the scene"
