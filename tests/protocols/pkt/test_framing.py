"""The decoder: against the firmware's rules written down once more, whole and in pieces, each way to resynchronise."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocols.pkt import (
    LEN_TABLE,
    NOISE_RUN,
    SYNC,
    TERM_TABLE,
    Dropped,
    DropReason,
    Frame,
    FrameAction,
    FrameReader,
    FrameState,
    FrameTimer,
    FrameTransition,
    FrameTrigger,
    Framing,
    FramingOptions,
    LocalProtocolError,
    Resync,
    crc16,
    encode_frame,
    frame_table,
    hides_newline,
    longest_frame,
)
from tests.each import each
from tests.share import examples

SECOND = 1_000_000_000
LEN = FramingOptions()
TERM = FramingOptions(framing=Framing.TERM)
LED_ON = encode_frame(b"\x01")
REASONS = {
    DropReason.BAD_SYNC: 1,
    DropReason.BAD_LENGTH: 2,
    DropReason.BAD_CRC: 3,
    DropReason.BAD_TERMINATOR: 4,
}


def firmware_len(stream):
    """What the firmware's decoder makes of a stream: payloads and error numbers, one byte after the other."""
    made, state, payload, length, crc = [], "idle", b"", 0, 0
    for byte in stream:
        if state == "idle":
            state = "K" if byte == ord("P") else "idle"
        elif state in ("K", "T", "!"):
            following = {"K": "T", "T": "!", "!": "length"}[state]
            made += [] if byte == ord(state) else [1]
            state = following if byte == ord(state) else "idle"
        elif state == "length":
            made += [] if 1 <= byte <= 96 else [2]
            state, length, payload = ("payload" if 1 <= byte <= 96 else "idle"), byte, b""
        elif state == "payload":
            payload += bytes((byte,))
            state = "crc1" if len(payload) == length else "payload"
        elif state == "crc1":
            state, crc = "crc2", byte << 8
        elif state == "crc2":
            right = crc | byte == crc16(payload)
            made += [] if right else [3]
            state = "terminator" if right else "idle"
        else:
            made.append(payload if byte == 0x0A else 4)
            state = "idle"
    return made


def diagram_term(stream, raw_limit):
    """What the document's diagram makes of a stream."""
    made, state, raw = [], "idle", b""
    for byte in stream:
        if state == "idle":
            state = "K" if byte == ord("P") else "idle"
        elif state in ("K", "T", "!"):
            following = {"K": "T", "T": "!", "!": "body"}[state]
            made += [] if byte == ord(state) else [1]
            state, raw = (following if byte == ord(state) else "idle"), b""
        elif byte == 0x0A:
            right = len(raw) > 2 and crc16(raw[:-2]) == raw[-2] << 8 | raw[-1]
            made.append(raw[:-2] if right else 3)
            state = "idle"
        elif len(raw) == raw_limit:
            made.append(2)
            state = "idle"
        else:
            raw += bytes((byte,))
    return made


def made_by(reader, stream):
    found = reader.receive(stream, 0)
    return [
        item.payload if isinstance(item, Frame) else REASONS[item.reason]
        for item in found
        if isinstance(item, Frame) or item.reason in REASONS
    ]


@st.composite
def streams(draw, options=LEN):
    """Sound frames, damaged frames, pieces of sync words and noise."""
    frames = st.binary(min_size=1, max_size=options.payload_limit).map(lambda payload: encode_frame(payload, options))
    pieces = st.sampled_from([b"P", b"PK", b"PKT", SYNC, SYNC + b"\0", SYNC + b"a", SYNC + b"\n", b"\n", b"K", b"!"])
    bits = st.one_of(frames, pieces, st.binary(max_size=12))
    stream = bytearray(b"".join(draw(st.lists(bits, max_size=12))))
    for at in draw(st.lists(st.integers(0, 2000), max_size=3)):
        if stream:
            stream[at % len(stream)] ^= 1 << draw(st.integers(0, 7))
    return bytes(stream)


OPTIONS = [
    LEN,
    FramingOptions(resync=Resync.SYNC),
    FramingOptions(resync=Resync.SCAN),
    FramingOptions(resync=Resync.SCAN, max_payload=255),
    TERM,
    FramingOptions(framing=Framing.TERM, strict_diagram=True),
    FramingOptions(framing=Framing.TERM, resync=Resync.SYNC),
    FramingOptions(framing=Framing.TERM, resync=Resync.SCAN),
    FramingOptions(framing=Framing.TERM, resync=Resync.SCAN, tolerant_newline=True),
    FramingOptions(framing=Framing.TERM, tolerant_newline=True),
]
every_option = pytest.mark.parametrize(
    "options", OPTIONS, ids=lambda o: f"{o.framing.name}-{o.resync.name}{'-strict' * o.strict_diagram}"
)


@settings(max_examples=examples(150))
@given(streams())
def test_the_firmwares_decoder(stream):
    assert made_by(FrameReader(LEN), stream) == firmware_len(stream)


@each(("strict", "raw_limit"), [(True, 64), (False, 66)])
def test_the_documents_diagram(strict, raw_limit):
    options = FramingOptions(framing=Framing.TERM, strict_diagram=strict)

    @settings(max_examples=examples(80))
    @given(streams(TERM))
    def check(stream):
        assert made_by(FrameReader(options), stream) == diagram_term(stream, raw_limit)

    check()


@every_option
def test_every_byte_is_reported_once_and_cutting_changes_nothing(options):
    @settings(max_examples=examples(40))
    @given(st.lists(st.tuples(streams(options), st.integers(0, SECOND)), max_size=4), st.integers(1, 40))
    def check(bursts, size):
        whole, pieces = FrameReader(options, keep_buffer=True), FrameReader(options, keep_buffer=True)
        now_ns, seen = 0, []
        for stream, gap_ns in bursts:
            now_ns += gap_ns
            found = whole.receive(stream, now_ns)
            cut = pieces.expire(now_ns)
            for at in range(0, len(stream), size):
                cut += pieces.receive(stream[at : at + size], now_ns)
                assert pieces.held <= max(longest_frame(options), NOISE_RUN)
            assert cut == found
            assert pieces.next_deadline_ns() == whole.next_deadline_ns()
            assert pieces.visits == whole.visits
            seen += found
        seen += whole.reset()
        reported = b"".join(item.raw if isinstance(item, Frame) else item.data for item in seen)
        assert reported == b"".join(stream for stream, _ in bursts)
        assert whole.held == 0
        assert all(item.data for item in seen if isinstance(item, Dropped))

    check()


@every_option
def test_a_sound_frame_alone_is_found(options):
    @settings(max_examples=examples(40))
    @given(st.binary(min_size=1, max_size=62))
    def check(payload):
        if options.framing is Framing.LEN or options.tolerant_newline or not hides_newline(payload):
            found = FrameReader(options).receive(encode_frame(payload, options), 0)
            assert [item.payload for item in found] == [payload]

    check()


@given(st.lists(st.one_of(st.binary(max_size=30), st.just(LED_ON)), max_size=12), st.binary(max_size=90))
def test_with_scan_a_frame_behind_any_noise_is_found_once_the_line_rests(noise, tail):
    """Whatever stands in front, the last frame comes out at the latest when what swallowed it is given up."""
    reader = FrameReader(FramingOptions(resync=Resync.SCAN))
    mark = encode_frame(b"mark" + tail)
    found = reader.receive(b"".join(noise) + mark, 0) + reader.reset()
    assert mark in [item.raw for item in found if isinstance(item, Frame)]


def test_what_each_rule_makes_of_a_p_too_many():
    stream = b"P" + LED_ON
    assert made_by(FrameReader(LEN), stream) == [1]
    assert made_by(FrameReader(FramingOptions(resync=Resync.SYNC)), stream) == [1, b"\x01"]
    assert made_by(FrameReader(FramingOptions(resync=Resync.SCAN)), stream) == [1, b"\x01"]


def test_a_p_in_place_of_the_newline():
    stream = LED_ON[:-1] + LED_ON
    assert made_by(FrameReader(LEN), stream) == [4]
    assert made_by(FrameReader(FramingOptions(resync=Resync.SYNC)), stream) == [4, b"\x01"]


def test_scan_finds_the_frame_that_a_cut_frame_swallowed():
    cut = encode_frame(b"\x03" + bytes(9))[:8]
    assert made_by(FrameReader(LEN), cut + LED_ON) == [3]
    assert made_by(FrameReader(FramingOptions(resync=Resync.SCAN)), cut + LED_ON) == [3, b"\x01"]


@every_option
def test_a_hostile_stream_costs_little(options):
    for hostile in (SYNC + b"\x60", SYNC, b"P", SYNC + b"\x00", LED_ON[:-1], b"\n", b"PK"):
        reader = FrameReader(options)
        for _ in range(4):
            reader.receive(hostile * (1_000 // len(hostile)), 0)
        assert reader.held <= max(longest_frame(options), NOISE_RUN), hostile


# ---- time


def times(timer):
    return FramingOptions(timer=timer, timeout_s=1.0)


def test_a_half_frame_waits_for_ever_without_a_timer():
    """P23: cut after 6 bytes, the rest 30 s later."""
    reader = FrameReader(times(FrameTimer.OFF))
    reader.receive(LED_ON[:6], 0)
    assert reader.next_deadline_ns() is None
    (frame,) = reader.receive(LED_ON[6:], 30 * SECOND)
    assert frame.raw == LED_ON


@each(
    ("timer", "came_s", "deadline_s"),
    [
        (FrameTimer.SINCE_FIRST_BYTE, (2.3, 2.9), 3.3),
        (FrameTimer.SINCE_LAST_BYTE, (2.3, 2.9), 3.9),
        (FrameTimer.SINCE_RESET, (2.3, 2.9), 3.0),
    ],
)
def test_when_a_half_frame_is_given_up(timer, came_s, deadline_s):
    reader = FrameReader(times(timer))
    for at, second in enumerate(came_s):
        reader.receive(LED_ON[at : at + 1], round(second * SECOND))
    deadline_ns = round(deadline_s * SECOND)
    assert reader.next_deadline_ns() == deadline_ns
    assert reader.expire(deadline_ns - 1) == []
    assert reader.expire(deadline_ns) == [Dropped(reason=DropReason.TIMED_OUT, data=LED_ON[:2])]
    assert reader.state is FrameState.IDLE
    assert reader.next_deadline_ns() is None


def test_the_arduinos_timer_cuts_a_young_frame():
    """It counts from the decoder's latest reset, so a frame in flight 1 s after that is lost, however young it is."""
    reader = FrameReader(times(FrameTimer.SINCE_RESET))
    reader.receive(LED_ON, SECOND // 4)  # a reset
    assert reader.receive(LED_ON[:6], SECOND * 6 // 5) == []
    dropped, tail = reader.receive(LED_ON[6:] + b"P", SECOND * 13 // 10)
    assert dropped == Dropped(reason=DropReason.TIMED_OUT, data=LED_ON[:6])
    assert tail == Dropped(reason=DropReason.NOISE, data=LED_ON[6:])


def test_noise_comes_out_when_its_time_is_up():
    reader = FrameReader(times(FrameTimer.SINCE_LAST_BYTE))
    assert reader.receive(b"abc", 0) == []
    assert reader.expire(SECOND) == [Dropped(reason=DropReason.NOISE, data=b"abc")]


def test_time_that_runs_backwards_counts_as_standing():
    reader = FrameReader(times(FrameTimer.SINCE_LAST_BYTE))
    reader.receive(b"P", 5 * SECOND)
    reader.receive(b"K", 3 * SECOND)
    assert reader.next_deadline_ns() == 6 * SECOND


# ---- the buffer behind the payload


@each("size", [1, 1000])
def test_what_earlier_frames_leave_in_the_buffer(size):
    """A C array: payload bytes stay where they are, one zero is written behind each payload."""
    reader = FrameReader(LEN, keep_buffer=True)
    stream = encode_frame(b"abcdefgh") + encode_frame(b"XY") + encode_frame(b"0123")[:8]
    found = [frame for at in range(0, len(stream), size) for frame in reader.receive(stream[at : at + size], 0)]
    assert [frame.behind[:8] for frame in found] == [bytes(8), b"\0defgh\0\0"]
    assert len(found[0].payload + found[0].behind) == 97


# ---- misuse and tables


@each("payload", [b"", bytes(97)])
def test_a_payload_that_fits_no_frame(payload):
    with pytest.raises(LocalProtocolError, match=f"{len(payload)} bytes is not 1..96"):
        encode_frame(payload)


@each(
    "wrong",
    [
        {"max_payload": 0},
        {"max_payload": 256},
        {"timeout_s": 0.0},
        {"strict_diagram": True},
        {"tolerant_newline": True},
    ],
)
def test_senseless_options(wrong):
    with pytest.raises(LocalProtocolError, match=next(iter(wrong))):
        FramingOptions(**wrong)


@each("options", OPTIONS)
def test_every_state_of_a_table_can_be_reached_and_left(options):
    table = frame_table(options)
    reached = {edge.next_state for edge in table.values()}
    assert reached == {state for state, _ in table}
    assert FrameState.IDLE in reached


def test_the_tables_differ_where_the_length_is():
    def states(table):
        return {state for state, _ in table}

    both = {FrameState.IDLE, FrameState.SYNC1, FrameState.SYNC2, FrameState.SYNC3}
    assert states(LEN_TABLE) & states(TERM_TABLE) == both
    assert states(TERM_TABLE) - both == {FrameState.BODY}


def test_another_table_is_another_decoder():
    """One that delivers frames whose CRC is wrong, and one that never delivers."""
    broken = encode_frame(b"\x01")[:-3] + b"\0\0\n"
    trusting = {**LEN_TABLE, (FrameState.CRC2, FrameTrigger.BAD_CRC): FrameTransition(FrameState.TERMINATOR)}
    assert made_by(FrameReader(LEN, table=trusting), broken) == [b"\x01"]
    deaf = {**LEN_TABLE, (FrameState.TERMINATOR, FrameTrigger.EXPECTED): FrameTransition(FrameState.IDLE)}
    assert made_by(FrameReader(LEN, table=deaf), LED_ON) == []
    assert FrameAction.DISPATCH not in {action for edge in deaf.values() for action in edge.actions}
    without_k = {cell: edge for cell, edge in LEN_TABLE.items() if cell != (FrameState.SYNC1, FrameTrigger.EXPECTED)}
    assert made_by(FrameReader(LEN, table=without_k), LED_ON) == [1]


def test_a_decoder_that_never_gives_up_is_not_stuck():
    table = {cell: edge for cell, edge in LEN_TABLE.items() if cell[1] is not FrameTrigger.TIME_UP}
    reader = FrameReader(LEN, table=table)
    reader.receive(LED_ON[:6], 0)
    assert reader.expire(10 * SECOND) == []
    assert [item.raw for item in reader.receive(LED_ON[6:], 10 * SECOND)] == [LED_ON]


@every_option
def test_every_edge_is_taken(options):
    """Every way in which a frame can be cut, damaged or wrong, and the time that runs out at each of its bytes."""
    frame = encode_frame(b"\x01", options)
    with_newline = encode_frame(b"\x03\0\x3b\0\x3b\x03", options)  # in its CRC
    reader = FrameReader(options)
    for whole in (frame, with_newline):
        for at in range(len(whole)):
            for wrong in (0x50, 0xFF, 0x0A):
                reader.receive(whole[:at] + bytes((wrong,)), 0)
                reader.reset()
            reader.receive(whole[:at], 0)
            reader.reset()
        for byte in whole:
            reader.receive(bytes((byte,)), 0)
        reader.reset()
    reader.receive(SYNC + b"x" * 80, 0)
    reader.reset()
    reader.receive(SYNC + b"\n" + b"x" * 80, 0)
    reader.reset()
    reader.receive(SYNC + b"\0" + frame, 0)
    reader.reset()
    assert {cell for cell, count in reader.visits.items() if count} == set(frame_table(options))


def test_the_longest_frame_is_the_longest_that_is_read():
    """Sync, length byte of the one framing, payload, CRC, terminator."""
    assert longest_frame() == 4 + 1 + 96 + 2 + 1
    assert longest_frame(FramingOptions(framing=Framing.TERM)) == 4 + 64 + 2 + 1
