"""The user I/O connector: eight outputs, eight inputs, five analog ports."""

from __future__ import annotations

from targets.robots.pioneer.settings import PORTS, RobotSettings

DEFAULT_PORT = 5
"""Analog port shown in the SIP at power-on (Pioneer 2 Operations Manual, ADSEL)."""


class UserIo:
    """State of the connector. `digital_in` and `analog` are inputs: the bench or a test may change them."""

    def __init__(self, settings: RobotSettings) -> None:
        self.digital_in = settings.digital_in
        self.digital_out = settings.digital_out
        self.analog = list(settings.analog)
        self.selected_port = DEFAULT_PORT

    def reset(self) -> None:
        """Back to the port of power-on (a session begins). The outputs are latches and stay as they are."""
        self.selected_port = DEFAULT_PORT

    def write(self, value: int) -> None:
        """DIGOUT: high byte says which outputs change, low byte to what. Signed or not, 16 bits count."""
        mask, bits = (value >> 8) & 0xFF, value & 0xFF
        self.digital_out = (self.digital_out & ~mask) | (bits & mask)

    def select(self, port: int) -> bool:
        """ADSEL: show analog port 1 to 5 in the SIP; False for any other number, which changes nothing."""
        if not 1 <= port <= PORTS:
            return False
        self.selected_port = port
        return True

    @property
    def selected_analog(self) -> int:
        """The selected port's voltage as the SIP shows it: 0 to 255 for 0 to 5 V."""
        return self.analog[self.selected_port - 1] >> 2
