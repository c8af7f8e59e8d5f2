"""What a client has asked for by READ_DATA: how many samples, until when, how fast."""

from __future__ import annotations

from protocols.xrce.submessages import DeliveryControl, ReadData

__all__ = ["UNLIMITED", "Reading"]

UNLIMITED = 0xFFFF
"""As the most samples of a `DeliveryControl`."""

_NS_PER_S = 1_000_000_000
_NS_PER_MS = 1_000_000
_ONCE = DeliveryControl(max_samples=1)


class Reading:
    """A request that is served (OMG DDS-XRCE 1.0, 7.7.3 and 8.3.5.9).

    Args:
        said: the request; without a delivery control it is for one sample.
        now_ns: when it came, in ns.

    Attributes:
        request_id: of the request.
        stream_id: on which its data go.
        next_ns: the earliest time of the next sample, in ns.
    """

    def __init__(self, said: ReadData, now_ns: int) -> None:
        control = said.specification.delivery or _ONCE
        self.request_id = said.request_id
        self.stream_id = said.specification.stream_id
        self.next_ns = now_ns
        self._left = None if control.max_samples == UNLIMITED else control.max_samples
        self._until_ns = now_ns + control.max_elapsed_s * _NS_PER_S if control.max_elapsed_s else None
        self._pace_ns = control.min_pace_ms * _NS_PER_MS
        self._bytes_per_s = control.max_bytes_per_s

    def is_over(self, now_ns: int) -> bool:
        """Nothing more may be delivered."""
        return self._left == 0 or (self._until_ns is not None and now_ns >= self._until_ns)

    def delivered(self, size: int, now_ns: int) -> None:
        """One more sample of so many bytes has been handed over."""
        if self._left is not None:
            self._left -= 1
        by_rate_ns = size * _NS_PER_S // self._bytes_per_s if self._bytes_per_s else 0
        self.next_ns = now_ns + max(self._pace_ns, by_rate_ns)
