"""Cyclone DDS by its C interface (dds.h, ddsi_serdata.h of 11.0), for samples of types that nobody here knows.

Its Python binding makes an object of every sample, for which it has to know the type, and announces that type. Here a
sample is bytes, and an endpoint announces its type by name alone: then nothing but the name is compared
(DDS-XTypes 1.3, 7.6.3.7), as with nodes of ROS 2.
"""

from __future__ import annotations

import ctypes
import os
import re
import threading
from collections.abc import Iterator, Mapping
from ctypes import (
    POINTER,
    Structure,
    byref,
    c_bool,
    c_char_p,
    c_int,
    c_int16,
    c_int32,
    c_int64,
    c_size_t,
    c_ssize_t,
    c_uint32,
    c_uint64,
    c_void_p,
)
from types import MappingProxyType
from typing import Any

from hilbench.errors import UnavailableError

__all__ = ["DdsError", "Endpoint", "Participant", "Watch"]

_POLICIES: Mapping[int, str] = MappingProxyType(
    {
        2: "durability",
        3: "presentation",
        4: "deadline",
        5: "latency budget",
        6: "ownership",
        8: "liveliness",
        11: "reliability",
        12: "destination order",
        25: "data representation",
    }
)
"""Which quality of service is meant by its number (ddsc/dds_public_qosdefs.h); the others have to suit nothing."""

_NAME = re.compile(r"[!%&()+,\-./0-9:;<=>@A-Z\\^_`a-z{|}~]{1,256}")
"""What Cyclone DDS takes as a topic, and OMG DDSI-RTPS 2.3 (table 9.12) as its length; 64 KiB would end the process."""

_DESCRIBES_NOTHING = (c_uint32 * 2)(0x04 << 24, 0)
"""A structure without members (dds_opcodes.h: DLC, RTS): no sample is looked into; in XCDR1 it has no header."""
_XCDR1, _IGNORE_PARTICIPANT, _KEEP_LAST, _SDK_DATA = 0, 1, 0, 2
_UNLIMITED = -1
_LIBRARY = 0x7FFF_0100
"""The entity that everything belongs to (dds.h: DDS_CYCLONEDDS_HANDLE)."""
_FOR_EVER = 0x7FFF_FFFF_FFFF_FFFF
_INCOMPATIBLE_OFFERED, _INCOMPATIBLE_REQUESTED, _DATA = 1 << 3, 1 << 4, 1 << 8
_HEADER_BYTES, _PADDING = 4, 3
"""Before a sample: two bytes for the encoding, and two whose last bits say how many behind it are none of it
(DDS-XTypes 1.3, 7.6.3.1.2). What is not padded here is by Cyclone DDS, with whatever stood in its memory."""
_AT_ONCE = 64


class DdsError(Exception):
    """Cyclone DDS has refused something; the message says what it answered."""


class _Meta(Structure):
    _fields_ = (("data", c_void_p), ("size", c_uint32))


class _Descriptor(Structure):
    """dds_topic_descriptor."""

    _fields_ = (
        ("size", c_uint32),
        ("align", c_uint32),
        ("flags", c_uint32),
        ("key_count", c_uint32),
        ("type_name", c_char_p),
        ("keys", c_void_p),
        ("op_count", c_uint32),
        ("ops", c_void_p),
        ("meta", c_char_p),
        ("type_information", _Meta),
        ("type_mapping", _Meta),
        ("representations", c_uint32),
    )


class _Vector(Structure):
    """ddsrt_iovec_t."""

    _fields_ = (("base", c_char_p), ("length", c_size_t))


class _SampleInfo(Structure):
    """dds_sample_info_t."""

    _fields_ = (
        ("states", c_int * 3),
        ("valid_data", c_bool),
        ("source_timestamp", c_int64),
        ("handles", c_uint64 * 2),
        ("counts", c_uint32 * 5),
    )


class _Incompatible(Structure):
    """dds_requested_incompatible_qos_status_t, and that of what is offered."""

    _fields_ = (("total", c_uint32), ("change", c_int32), ("last_policy", c_uint32))


_FUNCTIONS: Mapping[str, tuple[Any, tuple[Any, ...]]] = {
    "dds_create_participant": (c_int32, (c_uint32, c_void_p, c_void_p)),
    "dds_create_topic": (c_int32, (c_int32, c_void_p, c_char_p, c_void_p, c_void_p)),
    "dds_create_reader": (c_int32, (c_int32, c_int32, c_void_p, c_void_p)),
    "dds_create_writer": (c_int32, (c_int32, c_int32, c_void_p, c_void_p)),
    "dds_delete": (c_int32, (c_int32,)),
    "dds_strretcode": (c_char_p, (c_int32,)),
    "dds_create_qos": (c_void_p, ()),
    "dds_delete_qos": (None, (c_void_p,)),
    "dds_qset_reliability": (None, (c_void_p, c_int, c_int64)),
    "dds_qset_durability": (None, (c_void_p, c_int)),
    "dds_qset_history": (None, (c_void_p, c_int, c_int32)),
    "dds_qset_durability_service": (None, (c_void_p, c_int64, c_int, c_int32, c_int32, c_int32, c_int32)),
    "dds_qset_ignorelocal": (None, (c_void_p, c_int)),
    "dds_qset_data_representation": (None, (c_void_p, c_uint32, c_void_p)),
    "dds_get_entity_sertype": (c_int32, (c_int32, c_void_p)),
    "ddsi_serdata_from_ser_iov": (c_void_p, (c_void_p, c_int, c_size_t, POINTER(_Vector), c_size_t)),
    "ddsi_serdata_size": (c_uint32, (c_void_p,)),
    "ddsi_serdata_to_ser": (None, (c_void_p, c_size_t, c_size_t, c_void_p)),
    "ddsi_serdata_unref": (None, (c_void_p,)),
    "dds_writecdr": (c_int32, (c_int32, c_void_p)),
    "dds_takecdr": (c_int32, (c_int32, c_void_p, c_uint32, c_void_p, c_uint32)),
    "dds_set_status_mask": (c_int32, (c_int32, c_uint32)),
    "dds_get_requested_incompatible_qos_status": (c_int32, (c_int32, c_void_p)),
    "dds_get_offered_incompatible_qos_status": (c_int32, (c_int32, c_void_p)),
    "dds_create_waitset": (c_int32, (c_int32,)),
    "dds_waitset_attach": (c_int32, (c_int32, c_int32, c_ssize_t)),
    "dds_waitset_wait": (c_int32, (c_int32, c_void_p, c_size_t, c_int64)),
    "dds_waitset_set_trigger": (c_int32, (c_int32, c_bool)),
}


def _library() -> ctypes.CDLL:
    """Return the library of the package `cyclonedds`, its functions with their types.

    Raises:
        UnavailableError: it is not installed, or is another one than is known here.
    """
    hint = "pip install 'hilbench[ros2]'"
    try:
        from cyclonedds.__library__ import library_path
    except ImportError:
        raise UnavailableError("DDS needs Cyclone DDS, which is not installed", hint=hint) from None
    try:
        library = ctypes.CDLL(str(library_path))
        for name, (result, arguments) in _FUNCTIONS.items():
            function = getattr(library, name)
            function.restype, function.argtypes = result, arguments
    except (OSError, AttributeError) as error:
        raise UnavailableError(f"this Cyclone DDS cannot be used: {error}", hint=hint) from None
    return library


class Watch:
    """Tells by a descriptor that an endpoint has something: a thread waits for that, and then until it was looked at.

    Raises:
        UnavailableError: see `_library`; or Cyclone DDS does not start.
    """

    def __init__(self) -> None:
        self.library = _library()
        try:
            self.handle = self.checked(self.library.dds_create_waitset(_LIBRARY))
            self.checked(self.library.dds_waitset_attach(self.handle, self.handle, 0))  # to be woken up by `close`
        except DdsError as error:
            raise UnavailableError(f"Cyclone DDS does not start: {error}") from None
        self._read, self._write = os.pipe()
        self._looked = threading.Semaphore(0)
        self._ending = False
        self._thread = threading.Thread(target=self._wait, name="dds", daemon=True)
        self._thread.start()

    def checked(self, result: int) -> int:
        """Return what a function of Cyclone DDS has returned.

        Raises:
            DdsError: it is an error.
        """
        if result < 0:
            raise DdsError(self.library.dds_strretcode(result).decode())
        return result

    def fileno(self) -> int:
        """Return the descriptor, readable until `take`."""
        return self._read

    def take(self) -> None:
        """Take note; whatever comes from now on is told of after `looked`."""
        os.read(self._read, 1)

    def looked(self) -> None:
        """Go on waiting: all endpoints have been looked at."""
        self._looked.release()

    def close(self) -> None:
        """End the thread."""
        self._ending = True
        self.library.dds_waitset_set_trigger(self.handle, True)
        self._looked.release()
        self._thread.join()
        self.library.dds_delete(self.handle)
        os.close(self._read)
        os.close(self._write)

    def _wait(self) -> None:
        while self.library.dds_waitset_wait(self.handle, None, 0, _FOR_EVER) >= 0 and not self._ending:
            os.write(self._write, b"!")
            self._looked.acquire()


class Participant:
    """A participant of a domain; who writes by it does not hear itself.

    Args:
        watch: tells of its endpoints.
        domain_id: 0..232.

    Raises:
        DdsError: there is no such domain, or no network.
    """

    def __init__(self, watch: Watch, domain_id: int) -> None:
        self.watch = watch
        self.handle = watch.checked(watch.library.dds_create_participant(domain_id, None, None))

    def close(self) -> None:
        """Leave, with all endpoints."""
        self.watch.library.dds_delete(self.handle)


def _name(said: str) -> bytes:
    """Return a name for C.

    Raises:
        DdsError: it is none.
    """
    if not _NAME.fullmatch(said):
        raise DdsError(f"{said!a:.40} is no name in DDS")
    return said.encode()


class Endpoint:
    """A writer or a reader.

    Args:
        participant: whose it is.
        topic: its name.
        type_name: of what is written there.
        writes: it is a writer.
        reliable: no sample may be lost.
        durability: 0 volatile, 1 transient local: samples are kept for readers that come later, or wanted.
        depth: how many samples are kept.

    Raises:
        DdsError: a name is none, or Cyclone DDS does not make it.
    """

    def __init__(
        self,
        participant: Participant,
        topic: str,
        type_name: str,
        *,
        writes: bool,
        reliable: bool,
        durability: int,
        depth: int,
    ) -> None:
        watch = participant.watch
        self._library, self._checked = watch.library, watch.checked
        self._writes = writes
        self._handle, self._sertype = 0, c_void_p()
        ops, kind = ctypes.cast(_DESCRIBES_NOTHING, c_void_p), _name(type_name)
        described = _Descriptor(size=1, align=1, type_name=kind, op_count=2, ops=ops, meta=b"")
        self._topic = self._checked(
            self._library.dds_create_topic(participant.handle, byref(described), _name(topic), None, None)
        )
        qos = self._library.dds_create_qos()
        try:
            self._library.dds_qset_reliability(qos, int(reliable), 0)  # a writer never waits for a slow reader
            self._library.dds_qset_durability(qos, durability)
            self._library.dds_qset_history(qos, _KEEP_LAST, depth)
            self._library.dds_qset_durability_service(qos, 0, _KEEP_LAST, depth, *[_UNLIMITED] * 3)
            self._library.dds_qset_ignorelocal(qos, _IGNORE_PARTICIPANT)
            self._library.dds_qset_data_representation(qos, 1, byref(c_int16(_XCDR1)))
            make = self._library.dds_create_writer if writes else self._library.dds_create_reader
            self._handle = self._checked(make(participant.handle, self._topic, qos, None))
            self._checked(self._library.dds_get_entity_sertype(self._handle, byref(self._sertype)))
            told = _INCOMPATIBLE_OFFERED if writes else _INCOMPATIBLE_REQUESTED | _DATA
            self._checked(self._library.dds_set_status_mask(self._handle, told))
            self._checked(self._library.dds_waitset_attach(watch.handle, self._handle, 0))
        except DdsError:
            self.close()
            raise
        finally:
            self._library.dds_delete_qos(qos)

    def write(self, sample: bytes) -> None:
        """Write a sample: CDR without a header, little-endian.

        Raises:
            DdsError: it cannot be taken, because reliable readers are too slow, say.
        """
        padding = -len(sample) & _PADDING
        data = bytes((0, 1, 0, padding)) + sample + bytes(padding)
        vector = _Vector(data, len(data))
        made = self._library.ddsi_serdata_from_ser_iov(self._sertype, _SDK_DATA, 1, byref(vector), len(data))
        if made is None:
            raise DdsError("no sample can be made of it")
        self._checked(self._library.dds_writecdr(self._handle, made))

    def take(self) -> Iterator[bytes]:
        """Take all samples that have come: CDR without a header.

        Raises:
            DdsError: they cannot be taken.
        """
        samples, about = (c_void_p * _AT_ONCE)(), (_SampleInfo * _AT_ONCE)()
        count = _AT_ONCE
        while count == _AT_ONCE:  # fewer are all; what comes meanwhile is told of again
            count = self._checked(self._library.dds_takecdr(self._handle, samples, _AT_ONCE, about, 0))
            for sample, info in zip(samples[:count], about, strict=False):
                size = self._library.ddsi_serdata_size(sample)
                data = ctypes.create_string_buffer(size)
                self._library.ddsi_serdata_to_ser(sample, 0, size, data)
                self._library.ddsi_serdata_unref(sample)
                if info.valid_data and size >= _HEADER_BYTES:
                    yield data.raw[_HEADER_BYTES : size - (ord(data[3]) & _PADDING)]

    def mismatch(self) -> str:
        """Return which quality of service of another end has not suited since the last call; empty for none."""
        status = _Incompatible()
        asked = "offered" if self._writes else "requested"
        self._checked(getattr(self._library, f"dds_get_{asked}_incompatible_qos_status")(self._handle, byref(status)))
        return _POLICIES.get(status.last_policy, f"policy {status.last_policy}") if status.change else ""

    def close(self) -> None:
        """Leave the topic."""
        self._library.dds_delete(self._handle)
        self._library.dds_delete(self._topic)
