"""A recording that begins or ends anywhere, in the middle of a frame or of a session, accuses nobody of that."""

from __future__ import annotations

import pytest

from protocols import carla, p2os, pkt

MS = 1_000_000


def in_bytes(*frames):
    """Return what passes the line byte by byte, one each millisecond, of frames (ms, way, data)."""
    return sorted(
        ((at_ms + number) * MS, way, bytes((byte,))) for at_ms, way, data in frames for number, byte in enumerate(data)
    )


SYNCS = [p2os.encode_command(p2os.Command(number=number)) for number in range(3)]
IDENTIFICATION = p2os.encode_frame(p2os.Identification(name="desk", subclass="p2dx").encode())
SIP = p2os.encode_frame(p2os.Sip().encode())
SESSION = in_bytes(
    *((0, "tx", SYNCS[0]), (20, "rx", SYNCS[0]), (50, "tx", SYNCS[1]), (70, "rx", SYNCS[1])),
    *((100, "tx", SYNCS[2]), (120, "rx", IDENTIFICATION), (160, "tx", p2os.encode_command(p2os.Command(number=1)))),
    *((100 * number, "rx", SIP) for number in range(2, 13)),
    *((500 * number + 40, "tx", SYNCS[0]) for number in range(1, 3)),
    (1250, "tx", SYNCS[2]),
)

REQUEST = pkt.encode_frame(pkt.encode_command(pkt.RequestTelemetry()))
REPORT = pkt.encode_frame(pkt.encode_report(pkt.GeneralReport(), pkt.Schema.V2))
DRIVE = in_bytes(
    *((600 * number, "tx", REQUEST) for number in range(4)), *((600 * number + 20, "rx", REPORT) for number in range(4))
)

STATUS, COMMAND = carla.VECTORS["F5"].data, carla.VECTORS["F1"].data
RIDE = in_bytes(
    *((100 * number, "tx", STATUS) for number in range(4)), *((100 * number + 50, "rx", COMMAND) for number in range(4))
)

TALKS = pytest.mark.parametrize(
    ("protocol", "said"), [("p2os", SESSION), ("pkt", DRIVE), ("carla", RIDE)], ids=["p2os", "pkt", "carla"]
)


@TALKS
def test_one_that_ends_anywhere(wrong, protocol, said):
    for end in (*range(1, len(said), 7), len(said)):
        assert wrong(protocol, said[:end]) == [], end


@TALKS
def test_one_that_begins_anywhere(wrong, protocol, said):
    for begin in range(0, len(said) - 1, 7):
        assert wrong(protocol, said[begin:], end_ns=said[-1][0] + 800 * MS) == [], begin


@TALKS
def test_a_case_that_ends_anywhere(wrong, protocol, said):
    """A case begins with its first byte, and ends when it has seen enough."""
    for end in range(1, len(said), 25):
        assert wrong(protocol, said[:end], case="p2os-server/one") == [], end


def test_what_a_robot_brakes_with_may_have_been_set_before(wrong):
    """It drives at 400 mm/s, hears nothing from 0.5 s on, and brakes with 100 mm/s2 from 2.5 s on."""
    speeds = [400] * 24 + [400 - 10 * number for number in range(41)] + [0] * 5
    sips = [p2os.encode_frame(p2os.Sip(moving=speed > 0, left_raw=speed, right_raw=speed).encode()) for speed in speeds]
    driven = in_bytes(
        *((0, "tx", SYNCS[0]), (20, "rx", SYNCS[0]), (30, "tx", SYNCS[1]), (40, "rx", SYNCS[1]), (50, "tx", SYNCS[2])),
        *((60, "rx", IDENTIFICATION), (100, "tx", p2os.encode_command(p2os.Command(number=1)))),
        (400, "tx", p2os.encode_command(p2os.Command(number=p2os.CommandNumber.SETA, argument=-100))),
        (500, "tx", SYNCS[0]),
        *((150 + 100 * number, "rx", sip) for number, sip in enumerate(sips)),
    )
    behind = [one for one in driven if one[0] > 450 * MS]
    for said in (driven, behind):
        assert [one for one in wrong("p2os", said) if "silence of the client" not in one] == []


# --- what no beginning and no end excuses


def later(said, ms):
    return [(ns + ms * MS, way, data) for ns, way, data in said]


def test_noise_at_the_beginning_of_a_case(wrong):
    said = [(0, "rx", b"\x55"), *later(SESSION, 10)]
    assert wrong("p2os", said, case="p2os-server/one") == ["nobody has asked (p2os-server/one at 0.0350 s)"]
    assert wrong("p2os", said) == []
    said = [(0, "rx", b"\x55"), *((ns, {"tx": "rx", "rx": "tx"}[way], data) for ns, way, data in later(DRIVE, 10))]
    assert wrong("pkt", said, case="pkt-host/one[documented]", source="rover")
    assert wrong("pkt", said, source="rover") == []


def test_more_noise_than_a_frame_has(wrong):
    assert wrong("pkt", [(0, "tx", b"\x55" * 105), *later(DRIVE, 10)])
    assert not wrong("pkt", [(0, "tx", b"\x55" * 104), *later(DRIVE, 10)])


def test_more_noise_of_a_server_than_a_packet_has(wrong):
    assert wrong("p2os", [(0, "rx", b"\x55" * 600), *later(SESSION, 10)]) == [
        "nobody has asked (the recording at 0.0000 s)"
    ]
    assert wrong("p2os", [(0, "rx", b"\x55" * 250), *later(SESSION, 10)]) == []


def test_noise_that_comes_later_than_the_beginning(wrong):
    assert wrong("pkt", [(0, "rx", REPORT), (600 * MS, "tx", b"\x55"), *later(DRIVE, 610)])


def test_noise_at_the_end(wrong):
    assert wrong("pkt", [*DRIVE, (DRIVE[-1][0] + MS, "tx", b"\x55\x50\x4b")])


def test_a_frame_that_was_given_up_before_the_end(wrong):
    said = [*DRIVE, (DRIVE[-1][0] + MS, "tx", REQUEST[:5])]
    assert wrong("pkt", said, end_ns=said[-1][0] + 600 * MS)
    assert not wrong("pkt", said, end_ns=said[-1][0] + 400 * MS)


def test_a_sound_frame_in_the_rest_of_one_that_claims_too_much(wrong):
    """The count of the first says that more was to come than all that follows."""
    said = [*SESSION[:-6], (SESSION[-6][0], "rx", b"\xfa\xfb\xc8" + SIP)]
    assert wrong("p2os", said)


def test_a_server_that_speaks_unasked_behind_an_unknown_beginning(wrong):
    said = in_bytes((0, "tx", SYNCS[0]), (20, "rx", SYNCS[0]), (900, "rx", SYNCS[0]))
    assert wrong("p2os", said, end_ns=3000 * MS) == ["nobody has asked (the recording at 0.9050 s)"]
