"""Each format: what was written comes back, and a file that was cut at any byte is read up to there."""

from __future__ import annotations

import contextlib
import io
import random
import struct
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hilbench.diff.vcd_file import read_vcd
from hilbench.errors import UnavailableError
from hilbench.journal import Recording
from hilbench.recordings.layout import laid_out
from hilbench.recordings.mcap_file import write_mcap
from hilbench.recordings.pcapng import LEFT_OUT
from hilbench.recordings.reading import parse_recording
from hilbench.recordings.vcd_file import write_vcd
from tests.each import each
from tests.share import examples

EVERY_BYTE = pytest.mark.exhaustive("the gate cuts at every seventh byte")
_texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
_values = st.none() | st.booleans() | st.integers(-(2**53), 2**53) | _texts | st.lists(st.integers(0, 9), max_size=3)
_fields = st.dictionaries(_texts.filter(lambda name: name not in {"ns", "kind", "source", "data"}), _values, max_size=3)
_about_bytes = st.builds(
    lambda kind, source, data, fields: {"kind": kind, "source": source, "data": data.hex(), **fields},
    st.sampled_from(["tx", "rx", "dropped"]),
    st.sampled_from(["checker", "robot", "brain.usart1"]),
    st.binary(max_size=40),
    _fields,
)
_about_others = st.builds(
    lambda kind, source, fields: {"kind": kind, "source": source, **fields},
    st.sampled_from(["event", "verdict", "fault", "console", "reset", "pin", "pose"]),
    st.sampled_from(["world", "brain", "brain.PB7", "two\nlines\r\n"]),
    _fields,
)


@st.composite
def recordings(draw):
    """Events of one or several cases, each with a bench time of its own."""
    events = []
    for case in range(draw(st.integers(0, 3))):
        ns = draw(st.integers(0, 10**9))
        events.append({"ns": ns, "kind": "case", "source": "journal", "case": f"case {case}"})
        for event in draw(st.lists(_about_bytes | _about_others, max_size=6)):
            ns += draw(st.integers(0, 10**12))
            events.append({"ns": ns, **event})
    header = {"kind": "journal", "part": 0, "format": 1, "hilbench": "0", "note": draw(_texts)}
    return Recording(header=header, events=tuple(events), problem=None, ended=False)


class TestRoundTrip:
    @settings(max_examples=examples(40))
    @given(recording=recordings())
    def test_everything_comes_back(self, form, recording):
        write, read = form
        data = write(recording)
        found = read(data)
        expected = recording.events
        if data.startswith(b"\x0a"):
            expected = tuple(event for event in expected if event["kind"] not in LEFT_OUT)
        assert found.header == recording.header
        assert found.events == expected
        assert found.problem is None

    def test_times_and_end(self, form, two_cases):
        write, read = form
        found = read(write(two_cases))
        assert found == two_cases

    def test_a_format_is_told_by_its_beginning(self, form, two_cases):
        write, read = form
        data = write(two_cases)
        assert parse_recording(data, "it") == read(data)


class TestLayout:
    def test_each_case_begins_where_the_one_before_ended(self, two_cases):
        times = [ns // 1_000_000 for ns, _ in laid_out(two_cases.events)]
        assert times == [0, 1, 3, 3, 4, 5, 5, 5, 17, 17, 17]

    @settings(max_examples=examples(40))
    @given(recording=recordings())
    def test_times_never_fall_and_spans_within_a_case_stay(self, recording):
        laid = list(laid_out(recording.events))
        assert [ns for ns, _ in laid] == sorted(ns for ns, _ in laid)
        for (before_ns, before), (ns, event) in pairwise(laid):
            if event["kind"] != "case":
                assert ns - before_ns == event["ns"] - before["ns"]


def _marked(count=10, seed=5):
    """Events that each have a text nothing else has."""
    draw = random.Random(seed)
    events = []
    for number in range(count):
        kind = draw.choice(["tx", "rx", "event", "verdict"])
        event = {"ns": number * 1000, "kind": kind, "source": draw.choice(["checker", "robot"])}
        if kind in {"tx", "rx"}:
            event["data"] = draw.randbytes(draw.randrange(30)).hex()
        events.append(event | {"mark": f"<{number:04}>"})
    return [*events, {"ns": count * 1000, "kind": "host-end", "source": "journal", "mark": "<last>"}]


class TestCut:
    """Of a file that ends anywhere there is every event that is wholly in it, and nothing that is not."""

    @pytest.mark.parametrize("step", [7, pytest.param(1, marks=EVERY_BYTE)])
    def test_at_any_byte(self, form, recording_of, step):
        write, _ = form
        whole = recording_of(_marked())
        data = write(whole)
        ends = [data.index(event["mark"].encode()) for event in whole.events]
        lost = 0
        for cut in range(1, len(data), step):
            found = parse_recording(data[:cut], "it")
            assert found.events == whole.events[: len(found.events)]
            # What stands before the mark of the next event is whole, whatever the format puts behind each.
            sure = sum(end + 6 <= cut for end in ends) - 1
            assert len(found.events) >= sure
            lost += len(found.events) < len(whole.events)
            assert found.header in ({}, whole.header)
            assert found.ended == (len(found.events) == len(whole.events))
        assert lost

    @settings(max_examples=examples(40))
    @given(data=st.data(), recording=recordings())
    def test_of_any_recording(self, form, data, recording):
        write, read = form
        written = write(recording)
        whole = read(written).events
        cut = data.draw(st.integers(0, len(written)))
        found = parse_recording(written[:cut], "it")
        assert found.events == whole[: len(found.events)]

    @settings(max_examples=examples(40))
    @given(noise=st.binary(max_size=60), at=st.integers(0, 400))
    def test_bytes_that_are_wrong_end_the_reading_and_no_more(self, form, noise, at, two_cases):
        write, _ = form
        data = bytearray(write(two_cases))
        at = min(at + 20, len(data))
        data[at : at + len(noise)] = noise
        with contextlib.suppress(UnavailableError):
            parse_recording(bytes(data), "it")

    @pytest.mark.parametrize("step", [7, pytest.param(1, marks=EVERY_BYTE)])
    def test_waveforms_at_any_byte(self, tmp_path, recording_of, step):
        levels = random.Random(3)
        edges = [
            {"ns": at * 1000, "kind": "pin", "source": f"brain.P{levels.choice('AB')}1", "level": levels.random() < 0.5}
            for at in range(1, 40)
        ]
        path = tmp_path / "pins.vcd"
        write_vcd(recording_of(edges), path)
        data, whole = path.read_bytes(), read_vcd(path).tracks
        for cut in range(data.index(b"$dumpvars") + 12, len(data), step):
            path.write_bytes(data[:cut])
            found = read_vcd(path)
            for name, track in found.tracks.items():
                assert list(track.times_ns) == list(whole[name].times_ns)[: len(track)]
                assert list(track.values) == list(whole[name].values)[: len(track)]
            complete = data[:cut].rpartition(b"\n")[0].split(b"\n")
            assert found.end_ns == max((int(line[1:]) for line in complete if line.startswith(b"#")), default=0)


class TestDamagedMcap:
    """A chunk that is all there, and not what was written, ends the reading: nothing behind a hole is told."""

    @pytest.fixture
    def chunks(self, recording_of):
        """A recording of several chunks, as MCAP, and where its chunks begin."""
        events = [
            {"ns": number, "kind": "tx", "source": "checker", "data": "55" * 20_000, "mark": f"<{number:04}>"}
            for number in range(20)
        ]
        file = io.BytesIO()
        write_mcap(recording_of(events), file)
        data, at, begins = file.getvalue(), 8, []
        while at + 9 <= len(data):
            code, length = struct.unpack_from("<BQ", data, at)
            begins += [at] * (code == 6)
            at += 9 + length
        assert len(begins) > 2
        return data, begins, tuple(events)

    def test_bytes_that_are_others_than_were_written(self, chunks):
        data, begins, events = chunks
        for begin in begins:
            damaged = bytearray(data)
            damaged[begin + 5000] ^= 1
            found = parse_recording(bytes(damaged), "it")
            assert list(found.events) == [event for event in events if data.index(event["mark"].encode()) < begin]
            assert found.problem == f"the chunk at byte {begin} is damaged: its CRC is wrong"

    @pytest.mark.parametrize("length", [2**40, 2**64 - 1, 3])
    def test_a_record_that_does_not_fit_into_a_chunk_without_a_checksum(self, chunks, length):
        data, begins, events = chunks
        damaged = bytearray(data)
        struct.pack_into("<I", damaged, begins[1] + 9 + 24, 0)
        head = data.rindex(b'{"ns":9,', 0, data.index(b"<0009>")) - 31
        assert struct.unpack_from("<BQ", data, head) == (5, data.index(b"<0009>") - head + 8 - 9)
        struct.pack_into("<Q", damaged, head + 1, length)
        found = parse_recording(bytes(damaged), "it")
        assert found.events == events[:9]
        assert found.problem is not None
        assert f"at byte {begins[1]} " in found.problem


class TestForeignCaptures:
    """Captures that other programs have made of a serial line."""

    @each("order", ["<", ">"])
    @each("resolution", [None, 6, 9, 0x80 | 10])
    def test_of_any_byte_order_and_resolution(self, order, resolution):
        def block(kind, body):
            return struct.pack(f"{order}II", kind, len(body) + 12) + body + struct.pack(f"{order}I", len(body) + 12)

        def option(code, value):
            return struct.pack(f"{order}HH", code, len(value)) + value + b"\0" * (-len(value) % 4)

        end = struct.pack(f"{order}HH", 0, 0)
        about = b"" if resolution is None else option(9, bytes([resolution])) + end
        ticks = {None: 10**6, 6: 10**6, 9: 10**9, 0x80 | 10: 2**10}[resolution]
        user = block(1, struct.pack(f"{order}HHI", 147, 0, 0) + about)
        ethernet = block(1, struct.pack(f"{order}HHI", 1, 0, 0))
        named = block(1, struct.pack(f"{order}HHI", 250, 0, 0) + option(2, b"COM3") + about + end)
        section = block(0x0A0D0D0A, struct.pack(f"{order}IHHq", 0x1A2B3C4D, 1, 0, -1))

        def packet(interface, data, flags):
            head = struct.pack(f"{order}IIIII", interface, 0, 2 * ticks & 0xFFFFFFFF, len(data), len(data))
            return block(6, head + data + b"\0" * (-len(data) % 4) + option(2, struct.pack(f"{order}I", flags)) + end)

        rtac = struct.pack(">IIBBH", 0, 0, 4, 0, 0)
        packets = packet(0, b"abc", 2) + packet(0, b"de", 1) + packet(1, b"ethernet", 0) + packet(2, rtac + b"x", 0)
        unknown = block(0xBAD, b"1234")
        found = parse_recording(section + user + ethernet + unknown + named + packets, "it")
        bytes_of = [(event["kind"], event["source"], bytes.fromhex(event["data"])) for event in found.events]
        assert bytes_of == [("tx", "interface0", b"abc"), ("rx", "interface0", b"de"), ("rx", "COM3", b"x")]
        if ticks < 2**31:
            assert {event["ns"] for event in found.events} == {2_000_000_000}
        assert found.problem is None

    @each(
        ("kind", "expected"),
        [
            (0, {"kind": "note", "text": "status change"}),
            (3, {"kind": "tx", "data": "61"}),
            (5, {"kind": "note", "text": "bytes lost"}),
            (7, {"kind": "note", "text": "framing error"}),
            (9, {"kind": "note", "text": "break"}),
        ],
    )
    def test_what_else_happened_on_a_line_is_a_note(self, kind, expected):
        """Event types of LINKTYPE_RTAC_SERIAL (tcpdump.org/linktypes)."""

        def block(code, body):
            return struct.pack("<II", code, len(body) + 12) + body + struct.pack("<I", len(body) + 12)

        packet = struct.pack(">IIBBH", 0, 0, kind, 0, 0) + b"a" + bytes(3)
        data = block(0x0A0D0D0A, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1)) + block(1, struct.pack("<HHI", 250, 0, 0))
        (event,) = parse_recording(data + block(6, struct.pack("<IIIII", 0, 0, 5, 13, 13) + packet), "it").events
        assert event == {"ns": 5000, "source": "interface0", **expected}

    def test_neither(self, capfd, tmp_path):
        from hilbench.cli import main

        path = tmp_path / "no"
        path.write_bytes(b"\x7fELF")
        assert main(["export", str(path), "--csv", str(tmp_path / "c.csv")]) == 3
        assert "is no recording" in capfd.readouterr().err


@pytest.mark.parametrize("words", [["export", "--csv", "c.csv"], ["decode", "p2os"], ["diff", "--events", "old.pcap"]])
def test_an_older_pcap_is_refused_and_not_taken_for_bytes_of_a_line(capfd, tmp_path, monkeypatch, words):
    from hilbench.cli import main

    monkeypatch.chdir(tmp_path)
    (tmp_path / "old.pcap").write_bytes(b"\xd4\xc3\xb2\xa1\x02\x00\x04\x00" + bytes(8) + b"\0\0\4\0\x93\0\0\0")
    assert main([*words, "old.pcap"]) == 3
    assert "it is an older pcap" in capfd.readouterr().err


@each("compression", ["LZ4", "ZSTD"])
def test_compressed_chunks_of_other_programs(compression, two_cases):
    """What `mcap compress` makes of our files; of a chunk that is damaged or cut nothing is read."""
    from mcap.records import Channel, Message, Metadata, Schema
    from mcap.stream_reader import StreamReader
    from mcap.writer import CompressionType, Writer

    plain = io.BytesIO()
    write_mcap(two_cases, plain)
    packed = io.BytesIO()
    writer = Writer(packed, compression=CompressionType[compression])
    writer.start()
    channels, schemas = {}, {}
    for record in StreamReader(io.BytesIO(plain.getvalue())).records:
        if isinstance(record, Metadata):
            writer.add_metadata(record.name, record.metadata)
        elif isinstance(record, Schema) and record.id not in schemas:
            schemas[record.id] = writer.register_schema(record.name, record.encoding, record.data)
        elif isinstance(record, Channel) and record.id not in channels:
            channels[record.id] = writer.register_channel(record.topic, "json", schemas[record.schema_id])
        elif isinstance(record, Message):
            channel = channels[record.channel_id]
            writer.add_message(channel, record.log_time, record.data, record.publish_time, record.sequence)
    writer.finish()
    data = packed.getvalue()
    assert parse_recording(data, "it") == two_cases
    for cut in range(9, len(data), 41):
        assert parse_recording(data[:cut], "it").events in ((), two_cases.events)
    middle = data.index(b"zstd" if compression == "ZSTD" else b"lz4") + 30
    broken = data[:middle] + bytes(20) + data[middle + 20 :]
    assert parse_recording(broken, "it").problem is not None


def test_a_chunk_of_any_size_comes_back(form, recording_of):
    write, _ = form
    big = recording_of([{"ns": 1, "kind": "tx", "source": "checker", "data": bytes(200_000).hex()}])
    found = parse_recording(write(big), "it")
    assert (found.events, found.problem) == (big.events, None)


def test_bytes_that_are_none_come_back_beside_what_only_speaks_of_data(form, recording_of):
    write, _ = form
    event = {"ns": 1, "kind": "dropped", "source": "checker", "data": "", "reason": "no data"}
    assert parse_recording(write(recording_of([event])), "it").events == (event,)
