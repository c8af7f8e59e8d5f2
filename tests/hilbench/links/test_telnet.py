"""Telnet and its Com Port Control Option, without I/O: round trips, every cut, noise."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hilbench.links.com_port import COM_PORT, BreakSet, Bytes, ComPortServer, HeldBack, LinesSet, Purged, RateSet
from hilbench.links.telnet import (
    LONGEST_SUBNEGOTIATION,
    Data,
    Negotiation,
    Subnegotiation,
    TelnetDecoder,
    Verb,
    escape,
    negotiation,
    subnegotiation,
)
from tests.each import each

option = st.integers(0, 255)
event = st.one_of(
    st.builds(Data, st.binary(min_size=1, max_size=20)),
    st.builds(Negotiation, st.sampled_from(Verb), option),
    st.builds(Subnegotiation, option, st.binary(max_size=20)),
)


def encoded(one):
    match one:
        case Data(data=data):
            return escape(data)
        case Negotiation(verb=verb, option=number):
            return negotiation(verb, number)
        case Subnegotiation(option=number, payload=payload):
            return encoded_inside(number, payload)


def encoded_inside(number, payload):
    # An option of 255 has to be doubled, too; no such option is assigned, and ours never is.
    return subnegotiation(number, payload) if number != 255 else b"\xff\xfa\xff\xff" + escape(payload) + b"\xff\xf0"


def merged(events):
    """Join neighbouring data: how it was cut says nothing."""
    out = []
    for one in events:
        if isinstance(one, Data) and out and isinstance(out[-1], Data):
            out[-1] = Data(out[-1].data + one.data)
        else:
            out.append(one)
    return out


@given(st.lists(event, max_size=12), st.lists(st.integers(0, 400), max_size=8))
def test_what_is_encoded_is_decoded_however_it_is_cut(events, cuts):
    stream = b"".join(map(encoded, events))
    decoder, out, at = TelnetDecoder(), [], 0
    for cut in [*sorted(cut for cut in cuts if cut < len(stream)), len(stream)]:
        out += decoder.feed(stream[at:cut])
        at = cut
    assert merged(out) == merged(events)
    assert decoder.dropped == 0


@given(
    st.lists(
        st.one_of(st.binary(max_size=40), st.lists(st.sampled_from([255, 250, 240, 44, 1]), max_size=40).map(bytes))
    )
)
def test_noise_raises_nothing_and_is_kept_within_bounds(chunks):
    decoder, server = TelnetDecoder(), ComPortServer(9600)
    for chunk in chunks:
        decoder.feed(chunk)
        server.receive(chunk)
    assert len(decoder._inside) <= LONGEST_SUBNEGOTIATION + 2
    whole = TelnetDecoder().feed(b"".join(chunks))
    single = TelnetDecoder()
    assert merged(whole) == merged([got for byte in b"".join(chunks) for got in single.feed(bytes((byte,)))])


@each(
    ("stream", "said"),
    [
        (b"a\xff\xf1b", [Data(b"ab")]),  # NOP
        (b"\xff\xfa\xff\xf0", []),  # a subnegotiation of nothing
        (b"\xff\xfa\x2c\x01\xff\xfb\x00z", [Negotiation(Verb.WILL, 0), Data(b"z")]),  # its end was lost
        (b"\xff\xfa\x2c" + bytes(LONGEST_SUBNEGOTIATION + 1) + b"\xff\xf0z", [Data(b"z")]),  # too long
    ],
)
def test_what_is_no_subnegotiation_is_dropped(stream, said):
    decoder = TelnetDecoder()
    assert merged(decoder.feed(stream)) == said
    assert decoder.dropped == (0 if stream.startswith(b"a") else 1)


class Client:
    """The client's side, as far as a test says."""

    def __init__(self):
        self.server = ComPortServer(9600)
        self.answers()

    def answers(self):
        answers = TelnetDecoder().feed(bytes(self.server.answers))
        self.server.answers.clear()
        return answers

    def ask(self, *payload):
        wanted = self.server.receive(subnegotiation(COM_PORT, bytes(payload)))
        return wanted, [answer.payload for answer in self.answers()]


def test_the_server_offers_binary_transmission():
    assert TelnetDecoder().feed(bytes(ComPortServer(9600).answers)) == [
        Negotiation(Verb.WILL, 0),
        Negotiation(Verb.DO, 0),
        Negotiation(Verb.WILL, 3),
    ]


def test_what_is_agreed_is_not_answered_again():
    client = Client()
    client.server.receive(negotiation(Verb.WILL, COM_PORT))
    assert client.server.agreed
    assert client.answers() == [Negotiation(Verb.DO, COM_PORT), Subnegotiation(COM_PORT, b"\x6b\xb0")]
    client.server.receive(negotiation(Verb.WILL, COM_PORT) + negotiation(Verb.DO, 0) + negotiation(Verb.DONT, 1))
    assert client.answers() == []
    client.server.receive(negotiation(Verb.DO, 1) + negotiation(Verb.DONT, 3))  # the latter answers our offer
    assert client.answers() == [Negotiation(Verb.WONT, 1)]
    client.server.receive(negotiation(Verb.DONT, 0))
    assert client.answers() == [Negotiation(Verb.WONT, 0)]


@given(st.lists(st.builds(Negotiation, st.sampled_from(Verb), option), max_size=30))
def test_two_servers_that_hear_each_other_fall_silent(talk):
    one, other = ComPortServer(9600), ComPortServer(9600)
    one.receive(b"".join(map(encoded, talk)))
    for _ in range(6):
        said, one_answers = bytes(one.answers), bytes(other.answers)
        one.answers.clear()
        other.answers.clear()
        other.receive(said)
        one.receive(one_answers)
    assert not any(isinstance(event, Negotiation) for event in TelnetDecoder().feed(bytes(one.answers + other.answers)))


# RFC 2217, section 3: each command, what is answered, what it means for the line.
@each(
    ("asked", "wanted", "answered"),
    [
        ((0,), [], [b"\x64hilbench"]),
        ((0, 65), [], []),  # the client's own signature
        ((1, 0, 0, 0xE1, 0), [RateSet(57_600)], [b"\x65\x00\x00\xe1\x00"]),
        ((1, 0, 0, 0, 0), [], [b"\x65\x00\x00\x25\x80"]),
        ((1, 0, 0), [], []),
        ((2, 7), [], [b"\x66\x08"]),
        ((3, 3), [], [b"\x67\x01"]),
        ((4, 2), [], [b"\x68\x01"]),
        ((5, 3), [], [b"\x69\x01"]),
        ((5, 16), [], [b"\x69\x0e"]),
        ((5, 4), [], [b"\x69\x06"]),
        ((5, 5), [BreakSet(on=True)], [b"\x69\x05"]),
        ((5, 6), [], [b"\x69\x06"]),
        ((5, 7), [], [b"\x69\x08"]),
        ((5, 8), [LinesSet(dtr=True)], [b"\x69\x08"]),
        ((5, 9), [LinesSet(dtr=False)], [b"\x69\x09"]),
        ((5, 10), [], [b"\x69\x0b"]),
        ((5, 11), [LinesSet(rts=True)], [b"\x69\x0b"]),
        ((5, 12), [LinesSet(rts=False)], [b"\x69\x0c"]),
        ((5, 99), [], []),
        ((8,), [HeldBack(on=True)], []),
        ((9,), [HeldBack(on=False)], []),
        ((10, 16), [], [b"\x6e\x10"]),
        ((11, 0), [], [b"\x6f\x00"]),
        ((12, 1), [], [b"\x70\x01"]),
        ((12, 2), [Purged()], [b"\x70\x02"]),
        ((12, 3), [Purged()], [b"\x70\x03"]),
        ((77, 1), [], []),
    ],
)
def test_commands(asked, wanted, answered):
    assert Client().ask(*asked) == (wanted, answered)


def test_what_was_set_is_what_is_told():
    client = Client()
    client.ask(1, 0, 1, 0xC2, 0)
    assert client.ask(1, 0, 0, 0, 0) == ([], [b"\x65\x00\x01\xc2\x00"])
    client.ask(5, 5)
    assert client.ask(5, 6) == ([BreakSet(on=False)], [b"\x69\x06"])
    client.ask(5, 12)
    assert client.ask(5, 10) == ([], [b"\x69\x0c"])


def test_a_break_is_told_to_whoever_wants_to_know():
    client = Client()
    client.server.tell_break()
    assert client.answers() == []
    client.ask(10, 0x10)
    client.server.tell_break()
    assert client.answers() == [Subnegotiation(COM_PORT, b"\x6a\x10")]


def test_data_stands_in_order_with_what_is_asked():
    stream = b"a" + subnegotiation(COM_PORT, b"\x01\x00\x00\xe1\x00") + b"b\xff\xff"
    assert Client().server.receive(stream) == [Bytes(b"a"), RateSet(57_600), Bytes(b"b\xff")]
