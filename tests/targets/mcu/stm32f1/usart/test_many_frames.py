"""Frames by the block: those that are expected against the same put on the line one by one, words kept against told."""

from __future__ import annotations

from fractions import Fraction

from hypothesis import given, settings
from hypothesis import strategies as st

from targets.mcu.serial_line import SerialFormat, Words
from targets.mcu.services import Watch
from targets.mcu.timebase import NS_PER_S
from tests.each import each
from tests.share import examples

UE, M, PCE, TE, RE, SBK = 0x2000, 0x1000, 0x400, 8, 4, 1
LINEN = 1 << 14
OUTSIDE = 1
FRAMINGS = (UE | TE, UE | TE | M, UE | TE | PCE)
BIT_S = Fraction(16, 72_000_000)


def frame_at(ns, value, like, rate):
    return SerialFormat.parse(like).frame(value, Fraction(ns, NS_PER_S), BIT_S * rate)


@st.composite
def batches(draw):
    """Return groups of frames that are alike, each frame after the one before."""
    ns, groups = draw(st.integers(1000, 20_000)), []
    for _ in range(draw(st.integers(1, 4))):
        like = draw(st.sampled_from(["8N1", "8N1", "8E1", "8N2"]))
        rate = draw(st.sampled_from([Fraction(1), Fraction(1), Fraction(101, 100), Fraction(3, 2)]))
        frames = []
        for _ in range(draw(st.integers(1, 6))):
            frames.append(frame_at(ns, draw(st.integers(0, 255)), like, rate))
            gap = draw(st.sampled_from([0, 0, 0, 1, 7, 400, 5000]))
            ns = frames[-1].end_ns + gap
        groups.append(frames)
    return groups


def words_of(frames):
    first = frames[0]
    starts_ns, bits = [frame.start_ns for frame in frames], [frame.bits for frame in frames]
    return Words(starts_ns, bits, first.bit_s, first.bit_count, first.stop_half_bits)


def change_clock(port, factor):
    port.chip.change_clock(hclk_hz=72_000_000 // factor)


def drive(port, level):
    port.rx.drive(level)


def gate(port, clocked):
    port.usart.clocked = clocked


def connect(port, connected):
    port.rx.connected = connected


ACTIONS = st.one_of(
    st.tuples(st.just(change_clock), st.sampled_from([1, 2, 3])),
    st.tuples(st.just(drive), st.booleans()),
    st.tuples(st.just(gate), st.booleans()),
    st.tuples(st.just(connect), st.booleans()),
    *(
        st.tuples(st.just(lambda port, both: port.poke(*both)), st.tuples(st.just(register), st.sampled_from(values)))
        for register, values in (
            ("BRR", (16, 17, 32)),
            ("CR1", (UE | TE | RE, UE | TE, 0, UE | RE | M | PCE)),
            ("CR2", (0, LINEN, 2 << 12, 3 << 12, 3 << 12)),
        )
    ),
    st.tuples(st.just(lambda port, register: port.peek(register)), st.sampled_from(["SR", "DR"])),
)


def heard(make_port, groups, actions, put):
    """Return what a USART has heard, and all it shows at the end."""
    port = make_port().open()
    log = []
    port.usart.on_word = lambda word, errors: log.append((port.now, word, errors))
    put(port, groups)
    for at_ns, (act, what) in actions:
        port.chip.advance_to(max(port.now, port.chip.time.cycle_at_ns(at_ns)))
        act(port, what)
        log.append((port.now, port.flags))
    port.chip.advance_to(port.chip.time.cycle_at_ns(1_000_000))
    return log, [port.usart[offset] for offset in range(0, 0x1C, 4)], port.chip.notes.all


def one_by_one(port, groups):
    for frame in (frame for group in groups for frame in group):
        port.chip.time.at_ns(frame.start_ns, lambda frame=frame: port.usart.receive(frame), order=OUTSIDE)


def by_the_block(port, groups):
    for group in groups:
        port.usart.expect(words_of(group))


TIMED = st.lists(st.tuples(st.integers(1000, 150_000), ACTIONS), max_size=6).map(lambda those: sorted(those, key=first))


def first(pair):
    return pair[0]


@settings(max_examples=examples(300))
@given(groups=batches(), actions=TIMED)
def test_expected_frames_are_heard_as_if_they_came_one_by_one(make_port, groups, actions):
    assert heard(make_port, groups, actions, by_the_block) == heard(make_port, groups, actions, one_by_one)


@each(
    "actions",
    [
        [(drive, True), (drive, False), (drive, True)],
        [(connect, False), (connect, True)],
        [(gate, False), (gate, True)],
        [(change_clock, 2), (change_clock, 1)],
    ],
)
def test_what_happens_in_the_middle_of_many_frames(make_port, actions):
    frames = [frame_at(10_000 + 2500 * n, n, "8N1", Fraction(1)) for n in range(60)]
    timed = [(40_000 + 31_700 * n, action) for n, action in enumerate(actions)]
    assert heard(make_port, [frames], timed, by_the_block) == heard(make_port, [frames], timed, one_by_one)


def test_a_frame_that_begins_before_the_one_before_is_read(make_port):
    """With 1.5 stop bits a word is complete after the frame of a sender with one, which others follow at once."""
    frames, ns = [], 10_000
    for value, gap_ns in ((0x11, 5000), (0x22, 5000), (0x33, 0), (0x44, 5000), (0x55, 0)):
        frames.append(frame_at(ns, value, "8N1", Fraction(1)))
        ns = frames[-1].end_ns + gap_ns
    actions = [(5000, (lambda port, cr2: port.poke("CR2", cr2), 3 << 12))]
    by_block, alone = (heard(make_port, [frames], actions, put) for put in (by_the_block, one_by_one))
    assert by_block == alone
    assert len(alone[0]) == 6


def test_python_is_asked_once_about_frames_that_are_alike(open_port):
    port = open_port
    looked = []
    port.usart._expected._receive = lambda frame: looked.append(frame) or port.usart._receive(frame)
    words = words_of([frame_at(10_000 + 5000 * n, n, "8N1", Fraction(1)) for n in range(50)])
    port.usart.expect(words)
    port.chip.advance_to(port.chip.time.cycle_at_ns(100_000))
    port.usart.expect(words._replace(starts_ns=[ns + 250_000 for ns in words.starts_ns]))
    port.chip.advance_to(port.chip.time.cycle_at_ns(600_000))
    assert len(looked) == 1
    assert port.usart.expected == 0


def test_what_has_not_begun_can_be_taken_back(open_port):
    port, heard = open_port, []
    port.usart.on_word = lambda word, _errors: heard.append(word)
    port.usart.expect(words_of([frame_at(10_000 + 5000 * n, n, "8N1", Fraction(1)) for n in range(10)]))
    port.chip.advance_to(port.chip.time.cycle_at_ns(20_500))
    assert port.usart.expected == 7
    port.usart.expect_only(8)
    port.usart.expect_only(2)
    assert port.usart.expected == 2
    port.usart.expect(words_of([frame_at(90_000, 99, "8N1", Fraction(1))]))
    port.chip.advance_to(port.chip.time.cycle_at_ns(200_000))
    assert heard == [0, 1, 2, 3, 4, 99]


SENDING = st.one_of(
    st.tuples(st.just(lambda port, value: port.poke("DR", value)), st.integers(0, 0x1FF)),
    st.tuples(st.just(lambda port, _: port.set("CR1", SBK)), st.none()),
    st.tuples(
        st.just(lambda port, cr1: port.poke("CR1", cr1)), st.sampled_from([UE | TE, UE | TE | M, UE | TE | PCE, 0])
    ),
    st.tuples(st.just(lambda port, brr: port.poke("BRR", brr)), st.sampled_from([16, 17, 40])),
    st.tuples(st.just(change_clock), st.sampled_from([1, 2])),
)


def sent(make_port, actions, *, keeps):
    port = make_port().open()
    port.tx.set_watch(Watch.NOBODY)
    frames = []

    def take():
        for words in port.usart.take_words():
            for start_ns, bits in zip(words.starts_ns, words.bits, strict=True):
                frames.append((start_ns, bits, words.bit_s, words.bit_count, words.stop_half_bits, False))

    def told(frame):
        take()
        frames.append((frame.start_ns, frame.bits, frame.bit_s, frame.bit_count, frame.stop_half_bits, frame.is_break))

    port.usart.on_frame = told
    port.usart.keeps_words = keeps
    for number, (bits, (act, what)) in enumerate(actions):
        port.bits(bits)
        act(port, what)
        if number % 3 == 0:
            take()
    port.bits(100)
    take()
    return frames


@settings(max_examples=examples(200))
@given(actions=st.lists(st.tuples(st.integers(0, 30), SENDING), max_size=12))
def test_words_that_are_kept_are_those_that_are_told(make_port, actions):
    assert sent(make_port, actions, keeps=True) == sent(make_port, actions, keeps=False)
