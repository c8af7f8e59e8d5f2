"""What the libraries and programs that these formats are for make of our files."""

from __future__ import annotations

import io
import json
import shutil
import subprocess
from collections import Counter

import pytest

from hilbench.recordings.mcap_file import write_mcap
from hilbench.recordings.pcapng import write_pcapng
from hilbench.recordings.vcd_file import write_vcd
from hilbench.systems.pioneer.protocol import P2OS


class TestMcap:
    def test_counts_by_the_library_are_those_of_the_journal(self, two_cases):
        from mcap.reader import make_reader

        file = io.BytesIO()
        assert write_mcap(two_cases, file, P2OS).events == len(two_cases.events)
        reader = make_reader(io.BytesIO(file.getvalue()))
        counts = Counter()
        events = []
        for schema, channel, message in reader.iter_messages():
            counts[channel.topic] += 1
            if schema.name.startswith("hilbench.event."):
                events.append(json.loads(message.data))
        by_source = Counter(f"/{event['source'].replace('.', '/')}/{event['kind']}" for event in two_cases.events)
        assert {topic: count for topic, count in counts.items() if topic in by_source} == dict(by_source)
        assert sorted(map(str, events)) == sorted(map(str, two_cases.events))
        assert counts["/log"] == 4
        assert counts["/checker/rx/frames"] == 2
        summary = reader.get_summary()
        assert summary.statistics.message_count == sum(counts.values())

    def test_the_whole_file_passes_the_check_sums_of_the_library(self, two_cases):
        from mcap.stream_reader import StreamReader

        file = io.BytesIO()
        write_mcap(two_cases, file)
        assert list(StreamReader(io.BytesIO(file.getvalue()), validate_crcs=True).records)

    def test_messages_have_the_fields_of_their_schemas(self, recording_of):
        from mcap.reader import make_reader

        pose = {"ns": 10, "kind": "pose", "source": "world", "x_m": 1_000_000, "y_m": 0, "z_m": 0, "yaw_rad": 1_570_796}
        file = io.BytesIO()
        write_mcap(recording_of([pose]), file)
        said = {}
        for schema, channel, message in make_reader(io.BytesIO(file.getvalue())).iter_messages():
            said[channel.topic] = json.loads(message.data)
            assert schema.encoding == "jsonschema"
            assert said[channel.topic].keys() <= json.loads(schema.data)["properties"].keys()
        assert said["/pose"]["pose"]["position"] == {"x": 1.0, "y": 0.0, "z": 0.0}
        turned = said["/pose"]["pose"]["orientation"]
        assert turned["z"] == pytest.approx(turned["w"], abs=1e-6)


@pytest.mark.skipif(shutil.which("tshark") is None, reason="tshark is not installed")
def test_wireshark_reads_times_directions_and_bytes(tmp_path, two_cases):
    path = tmp_path / "it.pcapng"
    with path.open("wb") as file:
        assert write_pcapng(two_cases, file) == len(two_cases.events)
    columns = ("frame.interface_name", "rtacser.eventtype", "data.data", "frame.time_epoch", "frame.comment")
    words = [word for column in columns for word in ("-e", column)]
    ran = subprocess.run(
        ["tshark", "-r", str(path), "-T", "fields", "-E", "separator=|", *words],
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    rows = [line.split("|", 4) for line in ran.stdout.splitlines()]
    assert len(rows) == len(two_cases.events)
    assert rows[1][:4] == ["checker", "0x01", "fafb03000000", "0.001000000"]
    assert rows[2][:4] == ["checker", "0x02", "fafb03000000", "0.003000000"]
    assert rows[8][:4] == ["brain.usart1", "0x01", "666f72", "0.017000000"]
    assert json.loads(rows[5][4])["cause"] == 'a "quoted", cause'


def test_pyvcd_reads_the_edges(tmp_path, recording_of):
    from vcd.reader import TokenKind, tokenize

    edges = [("brain.PB7", 5, True), ("brain.PB7", 9, None), ("brain.PA1", 9, False), ("other.PB7", 12, True)]
    events = [{"ns": ns, "kind": "pin", "source": source, "level": level} for source, ns, level in edges]
    path = tmp_path / "it.vcd"
    assert write_vcd(recording_of([*events, {"ns": 20, "kind": "host-end", "source": "journal"}]), path) == 4
    names, scopes, found, ns = {}, [], [], 0
    with path.open("rb") as file:
        for token in tokenize(file):
            if token.kind is TokenKind.SCOPE:
                scopes.append(token.scope.ident)
            elif token.kind is TokenKind.UPSCOPE:
                scopes.pop()
            elif token.kind is TokenKind.VAR:
                names[token.var.id_code] = ".".join([*scopes, token.var.reference])
            elif token.kind is TokenKind.CHANGE_TIME:
                ns = token.time_change
            elif token.kind is TokenKind.CHANGE_SCALAR and ns:
                found.append((names[token.scalar_change.id_code], ns, token.scalar_change.value))
    level = {True: "1", False: "0", None: "z"}
    expected = [(source.replace(".P", ".pins.P"), at_ns, level[value]) for source, at_ns, value in edges]
    assert sorted(found) == sorted(expected)
    assert ns == 20
