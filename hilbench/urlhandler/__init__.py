"""A bench in the same process behind a URL of pyserial: ``serial.serial_for_url("hilbench://BOARD?image=fw.elf")``.

Importing this package is enough: it adds itself to the packages that pyserial looks for URLs in.
"""

from __future__ import annotations

import serial

if __name__ not in serial.protocol_handler_packages:
    serial.protocol_handler_packages.append(__name__)
