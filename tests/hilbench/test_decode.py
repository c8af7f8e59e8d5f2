"""`hilbench decode`: no byte is lost or told twice, whatever it comes from and however it is cut."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.cli import main
from hilbench.decode.sources import read_chunks
from hilbench.journal import Journal
from hilbench.plugins.discovery import PLUGINS
from hilbench.recordings.chunks import speaker_of
from hilbench.recordings.frames import framed, spoken
from protocols import autoware, carla, p2os, pkt, xrce
from protocols.common.decoding import NoOptions
from protocols.common.item_words import said
from protocols.p2os.decoding import decoder as p2os_decoder
from protocols.p2os.framing import encode_frame as encode_p2os_frame
from tests.each import each
from tests.hilbench.forked import PATIENCE_S

REQUEST = bytes.fromhex("504B54210100E1F00A")
THROTTLES = bytes.fromhex("504B54210A030000003F000080BE038C420A")
MOTION = pkt.encode_frame(pkt.encode_report(pkt.MotionReport(rpm=(1.5, 2.0, 0.0, 0.0), throttles=(0.5, float("nan")))))
DAMAGED = b"P" + REQUEST + THROTTLES[:-3] + b"\0\0\n" + MOTION
CARLA = [*(vector.data for vector in carla.VECTORS.values()), b"#S", b"#A", b"\0"]
PIECES = [REQUEST, THROTTLES, MOTION, b"PKT!", b"PK", *CARLA]
COMMAND = [sys.executable, "-m", "hilbench", "decode"]

pieces = st.lists(
    st.one_of(st.binary(max_size=12), st.sampled_from(PIECES)),
    max_size=12,
)


@pytest.mark.parametrize("protocol", [*PLUGINS.all()], ids=lambda protocol: protocol.name)
@given(pieces=pieces)
def test_every_byte_is_told_once_in_order(protocol, pieces):
    whole, cut = (protocol.decoder(protocol.options(), "target") for _ in range(2))
    data = b"".join(pieces)
    in_one = [*whole.feed(data), *whole.finish()]
    in_bytes = [item for at in range(len(data)) for item in cut.feed(data[at : at + 1])] + [*cut.finish()]
    assert b"".join(item.raw for item in in_one) == data
    assert [repr(item) for item in in_one] == [repr(item) for item in in_bytes]


def test_the_stand_in_link_of_a_driving_stack(tmp_path, capsys):
    command = autoware.AckermannControlCommand(stamp=autoware.Time(12, 5), speed=5.0, jerk=float("inf"))
    frames = [
        autoware.encode_frame(autoware.encode_message(command)),
        autoware.encode_frame(autoware.encode_message(autoware.ControlModeResponse(sequence=7, success=True))),
        autoware.encode_frame(b"\x7f\x01"),
        autoware.encode_frame(b"\x83"),
        b"\x7e\x00\x00",
    ]
    capture = tmp_path / "capture.bin"
    capture.write_bytes(b"".join(frames))
    assert main(["decode", "autoware", "--input", "raw", str(capture)]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert "AckermannControlCommand stamp=12.000000005" in lines[0]
    assert "speed=5" in lines[0]
    assert "ControlModeResponse sequence=7 success=True" in lines[1]
    assert "message 7F body=01" in lines[2]
    assert "!! a payload of ControlModeReport has 10 bytes, not 1" in lines[3]
    assert "!! a flag within the frame: 7E 00 00" in lines[4]
    assert main(["decode", "autoware", "--input", "raw", "--json", str(capture)]) == 1
    first = json.loads(capsys.readouterr().out.splitlines()[0])
    assert first["fields"]["stamp"] == "12.000000005"
    assert first["fields"]["jerk"] == "inf"


@pytest.mark.parametrize("framing", [xrce.Framing.SERIAL, xrce.Framing.LENGTH])
def test_a_line_of_micro_ros(tmp_path, capsys, framing):
    def frame(*said, **header):
        body = xrce.pack_submessages(map(xrce.encode_submessage, said))
        message = xrce.encode_message(xrce.Header(**header), body)
        return xrce.encode_frame(message, xrce.FramingOptions(framing=framing))

    client = xrce.Client(client_key=b"\xaa\xbb\xcc\x7e", session_id=0x01, mtu=512)
    topic = xrce.Topic(representation=xrce.TopicBinary(topic_name="rt/speed", type_name="F_"), participant_id=0x11)
    key = {"session_id": 0x01, "client_key": client.client_key}
    frames = [
        frame(xrce.CreateClient(client=client), session_id=0, client_key=client.client_key),
        frame(xrce.Create(request_id=10, object_id=0x12, object=topic), **key, stream_id=0x80),
        frame(
            xrce.WriteData(request_id=11, object_id=0x15, data=b"\1\2"),
            xrce.Heartbeat(first_unacked=1, last_unacked=2, stream_id=0x80),
            **key,
            stream_id=0x80,
            sequence=1,
        ),
        frame(xrce.RawSubmessage(id=99, flags=1, payload=b""), **key),
    ]
    capture = tmp_path / "capture.bin"
    capture.write_bytes(b"".join(frames))
    assert main(["decode", "xrce", "--input", "raw", str(capture)]) == 1
    lines = [line[10:] for line in capsys.readouterr().out.splitlines()]
    assert (
        "CreateClient session=0 stream=0 sequence=0 client_key=AA BB CC 7E client=Client(client_key=aabbcc7e"
        in lines[0]
    )
    assert "object=Topic(representation=TopicBinary(topic_name=rt/speed, type_name=F_), participant_id=17)" in lines[1]
    assert "WriteData+Heartbeat session=1 stream=128 sequence=1" in lines[2]
    assert "data_1=01 02 first_unacked_2=1" in lines[2]
    assert "!! 99 is no submessage" in lines[3]
    plugin = PLUGINS.get("xrce", "here")
    names = [one.name for one in plugin.regions(frames[2], plugin.options(), sent=True)]
    assert b"".join(one.data for one in plugin.regions(frames[2], plugin.options(), sent=True)) == frames[2]
    assert {"session", "stream", "sequence", "client_key", "data_1", "last_unacked_2"} <= {*names}


def test_the_line_of_a_simulator(tmp_path, capsys):
    command, manual, status = (carla.VECTORS[name].data for name in ("F1", "F2", "F5"))
    unknown, quiet = command[:27] + b"\x07$\0", status[:2] + b"\1\0\xa0\x7f" + status[6:]  # a signalling NaN
    capture = tmp_path / "capture.bin"
    capture.write_bytes(command + status + manual[:29] + b"##" + command + unknown + quiet + b"\0" + manual)
    assert main(["decode", "carla", "--input", "raw", str(capture)]) == 1
    captured = capsys.readouterr()
    told = [line[10:] for line in captured.out.splitlines()]
    assert told[0].startswith("AUTOWARE steering_rad=0.6 steering_rate_rad_s=0.12 speed_m_s=5")
    assert told[1] == "Status lon_speed_m_s=8.3333 lat_speed_m_s=-0.05 heading_rate_rad_s=0.1 steering_rad=-0.2"
    assert told[2] == told[9] == "MANUAL steer=-0.5 throttle=0.75 brake=0"
    assert told[3] == told[4] == "!! another byte where a letter should stand: 23"
    assert told[5] == told[0]
    assert told[6].startswith("!! mode 7, which nobody knows: 23 53")
    assert told[7].startswith("Status lon_speed_m_s=nan")
    assert told[8] == "!! no frame begins here: 00"


# --- forms of input


def xxd(data):
    for at in range(0, len(data), 16):
        row = data[at : at + 16]
        pairs = " ".join(row[i : i + 2].hex() for i in range(0, len(row), 2))
        yield f"{at:08x}: {pairs:<39}  {letters(row)}"


def hexdump(data):
    for at in range(0, len(data), 16):
        row = data[at : at + 16]
        halves = f"{row[:8].hex(' '):<23}  {row[8:].hex(' '):<23}"
        yield f"{at:08x}  {halves}  |{letters(row)}|"
    yield f"{len(data):08x}"


def od(data):
    for at in range(0, len(data), 16):
        yield f"{at:07o} {data[at : at + 16].hex(' ')}"
    yield f"{len(data):07o}"


def by_hand(data):
    yield "# a comment"
    for at in range(0, len(data), 7):
        yield data[at : at + 7].hex(" ").upper() + "   # and another"


def unbroken(data):
    yield data.hex()


def letters(row):
    return "".join(chr(byte) if 32 < byte < 127 else "." for byte in row)


@pytest.mark.parametrize("form", [xxd, hexdump, od, by_hand, unbroken])
@given(data=st.one_of(st.binary(min_size=1, max_size=70), st.just(DAMAGED), st.just(b"abcd #12|34>56  9" * 3)))
def test_hex_dumps(form, data):
    reader, writer = os.pipe()
    os.write(writer, "\n".join(form(data)).encode())
    os.close(writer)
    try:
        assert b"".join(chunk.data for chunk in read_chunks(reader, "dump", "hex", print)) == data
    finally:
        os.close(reader)


@pytest.mark.parametrize("form", [xxd, hexdump, od, by_hand, unbroken])
def test_a_hex_dump_is_known_as_one(form, tmp_path, capsys):
    (tmp_path / "dump").write_text("\n".join(form(DAMAGED)) + "\n")
    (tmp_path / "raw").write_bytes(DAMAGED)
    assert [main(["decode", "pkt", str(tmp_path / name), "--json"]) for name in ("dump", "raw")] == [1, 1]
    lines = capsys.readouterr().out.splitlines()
    half = len(lines) // 2
    assert [json.loads(line) for line in lines[:half]] == [json.loads(line) for line in lines[half:]]


@pytest.mark.parametrize("frame", CARLA[:-3])
def test_frames_that_begin_like_a_comment_are_no_hex_dump(frame, tmp_path, capsys):
    (tmp_path / "raw").write_bytes(frame * 3)
    assert main(["decode", "carla", str(tmp_path / "raw"), "--json"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 3


def test_a_hex_dump_may_begin_with_comments(tmp_path, capsys):
    (tmp_path / "dump").write_text("# from the bench\n\n#\n" + REQUEST.hex(" ") + "  # asks\n")
    assert main(["decode", "pkt", str(tmp_path / "dump"), "--json"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 1


def test_printable_bytes_behind_a_comment_sign_are_bytes(tmp_path, capsys):
    status = b"#A" + b"aaaaB" + b"bbbbC" + b"ccccD" + b"dddd$"
    (tmp_path / "raw").write_bytes(status * 2)
    main(["decode", "carla", str(tmp_path / "raw"), "--json"])
    assert len(capsys.readouterr().out.splitlines()) == 2


def test_a_journal(tmp_path, capsys):
    journal = tmp_path / "run.jsonl"
    assert main(["check", "rover-model", "-k", "P26 and documented", "--journal", str(journal)]) == 0
    capsys.readouterr()
    assert main(["decode", "pkt", str(journal), "--stream", "rover tx", "--json"]) == 0
    events = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert {event["stream"] for event in events} == {"rover tx"}
    assert [event["ns"] for event in events] == sorted(event["ns"] for event in events)
    motions = [event["fields"] for event in events if event["name"] == "MotionReport"]
    assert motions[-1]["throttles"][0] == pytest.approx(0.3008, abs=0.001)
    assert main(["decode", "pkt", str(journal)]) == 0
    out = capsys.readouterr().out
    assert "checker tx    UPDATE_MOTOR_SPEED_SETPOINTS a_rpm=30 b_rpm=30 flags=3" in out


def test_a_journal_of_one_source_with_several_lines(tmp_path, capsys):
    """An agent's lines: at one a board with serial framing, at the other a program with lengths, byte after byte."""
    ping = xrce.GetInfo(request_id=10, object_id=xrce.OBJECT_AGENT, info_mask=xrce.InfoMask.ACTIVITY)
    message = xrce.encode_message(xrce.Header(session_id=0x80), xrce.encode_submessage(ping))
    framings = {"line1": xrce.Framing.SERIAL, "line2": xrce.Framing.LENGTH}
    frames = {
        line: xrce.encode_frame(message, xrce.FramingOptions(framing=framing)) for line, framing in framings.items()
    }
    events = [
        {"ns": at, "kind": kind, "source": "agent", "line": line, "data": frames[line][at : at + 1].hex()}
        for at in range(max(map(len, frames.values())))
        for line in frames
        for kind in ("rx", "tx")
        if at < len(frames[line])
    ]
    lines = [json.dumps(event) for event in ({"kind": "journal"}, *events)]
    (tmp_path / "run.jsonl").write_text("\n".join(lines))
    assert main(["decode", "xrce", str(tmp_path / "run.jsonl"), "--json"]) == 0
    out = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    streams = {f"agent.{line} {kind}" for line in frames for kind in ("rx", "tx")}
    assert sorted(one["stream"] for one in out) == sorted(streams)
    assert {bytes.fromhex(one["raw"]) for one in out} == {*frames.values()}
    timed = [(event["ns"], event) for event in events]
    found = [*framed(timed, PLUGINS.get("xrce", "here"))]
    assert sorted((one.line, one.kind, one.item.raw) for one in found) == sorted(
        (line, kind, data) for line, data in frames.items() for kind in ("rx", "tx")
    )
    assert spoken(timed).name == "xrce"
    assert speaker_of("agent") == "target"


def test_a_stream_that_is_not_there_is_refused(tmp_path, capsys):
    events = [{"ns": 5, "kind": "tx", "source": source, "data": REQUEST.hex()} for source in ("rover", "checker")]
    lines = [json.dumps(event) for event in ({"kind": "journal"}, *events)]
    (tmp_path / "run.jsonl").write_text("\n".join(lines))
    words = ["decode", "pkt", str(tmp_path / "run.jsonl"), "--stream", "rover tx"]
    assert main(words) == 0
    capsys.readouterr()
    assert main([*words, "--stream", "nosuch"]) == 2
    out, said = capsys.readouterr()
    assert out.count("REQUEST_TMY") == 1
    assert said == "hilbench: --stream: no stream 'nosuch'; there are: rover tx, checker tx\n"
    (tmp_path / "raw").write_bytes(REQUEST)
    assert main(["decode", "pkt", str(tmp_path / "raw"), "--stream", "rover tx"]) == 2


@pytest.mark.parametrize(
    "words",
    [["pkt", "--json", "FILE"], ["--json", "pkt", "FILE"], ["pkt", "FILE", "--json"], ["--json", "--", "pkt", "FILE"]],
)
def test_options_may_stand_anywhere(tmp_path, capsys, words):
    (tmp_path / "capture").write_bytes(REQUEST)
    assert main(["decode", *(str(tmp_path / "capture") if word == "FILE" else word for word in words)]) == 0
    assert json.loads(capsys.readouterr().out)["name"] == "REQUEST_TMY"


def test_the_file_may_be_standard_input_behind_an_option():
    done = subprocess.run(
        [*COMMAND, "pkt", "--schema", "v2", "-"], input=REQUEST, capture_output=True, timeout=60, check=True
    )
    assert b"REQUEST_TMY" in done.stdout


# --- what is said


def run(tmp_path, capsys, data, *options):
    (tmp_path / "capture").write_bytes(data)
    code = main(["decode", options[0], str(tmp_path / "capture"), *options[1:]])
    return code, *capsys.readouterr()


def test_lines_for_people(tmp_path, capsys):
    code, out, said = run(tmp_path, capsys, DAMAGED, "pkt")
    lines = out.splitlines()
    assert code == 1
    assert lines[:2] == ["       0  !! broken sync word: 50", "       1  REQUEST_TMY"]
    assert lines[2].startswith("      10  !! wrong CRC: 50 4B 54 21 0A 03 00 00")
    assert lines[-1].startswith("      28  MotionReport rpm=[1.5 2 0 0]")
    assert "throttles=[0.5 nan]" in lines[-1]
    assert said == "2 frames, 19 bytes in no frame, 2 resynchronisations\n"


def test_a_clean_capture_is_0(tmp_path, capsys):
    code, out, said = run(tmp_path, capsys, THROTTLES, "pkt", "--json")
    assert (code, said) == (0, "1 frame\n")
    assert json.loads(out) == {
        "offset": 0,
        "kind": "frame",
        "name": "UPDATE_MOTOR_THROTTLES",
        "fields": {"a": 0.5, "b": -0.25, "flags": 3},
        "raw": THROTTLES.hex(),
    }


def test_json_knows_no_nan(tmp_path, capsys):
    _, out, _ = run(tmp_path, capsys, MOTION, "pkt", "--json")
    assert json.loads(out, parse_constant=pytest.fail)["fields"]["throttles"] == [0.5, "nan"]


def test_frames_that_end_at_a_newline(tmp_path, capsys):
    data = bytes.fromhex("504B542103000A000A0377F30A")
    code, out, _ = run(tmp_path, capsys, data, "pkt", "--framing", "term", "--schema", "v1")
    assert (code, out) == (0, "       0  UPDATE_MOTOR_SPEEDS a=10 b=10 flags=3\n")


def test_a_sound_frame_without_sense(tmp_path, capsys):
    code, out, said = run(tmp_path, capsys, pkt.encode_frame(b"\x03"), "pkt")
    assert code == 1
    assert "!! UPDATE_MOTOR_THROTTLES has 0 bytes of parameters, not 9" in out
    assert said == "0 frames, 1 sound frame without sense\n"


def test_p2os_from_both_ends(tmp_path, capsys):
    drive = p2os.encode_command(p2os.Command(number=p2os.CommandNumber.VEL, argument=-200))
    code, out, _ = run(tmp_path, capsys, drive, "p2os", "--from", "host")
    assert (code, out) == (0, "       0  VEL argument=-200\n")
    code, out, _ = run(tmp_path, capsys, p2os.encode_packet(p2os.Sip(x_raw=7)), "p2os")
    assert code == 0
    assert out.startswith("       0  Sip ")
    assert "x_raw=7" in out


HANDSHAKE = [(b"\x00", "SYNC0"), (b"\x01", "SYNC1"), (b"\x02", "SYNC2"), (b"\x01", "OPEN")]
AGAIN = [(b"\x00", "SYNC0"), (b"\x00", "SYNC0"), (b"\x01", "SYNC1"), (b"\x01", "SYNC1"), *HANDSHAKE[2:]]
SESSION = [(b"\x00", "PULSE"), (b"\x0b\x3b\x64\x00", "VEL argument=100"), (b"\x00", "PULSE"), (b"\x02", "CLOSE")]
WITH_ARGUMENTS = [*HANDSHAKE[:3], (b"\x01\x3b\x01\x00", "OPEN argument=1"), (b"\x02\x3b\x01\x00", "CLOSE argument=1")]
BEGUN_ANEW = [*HANDSHAKE, (b"\x00", "PULSE"), (b"\x00", "PULSE"), *HANDSHAKE[1:]]


@each("frames", [HANDSHAKE + SESSION + HANDSHAKE, AGAIN, WITH_ARGUMENTS + HANDSHAKE, BEGUN_ANEW])
@each("cut", [1, 7, 1000])
def test_a_sync_of_p2os_has_its_name_where_it_is_one(frames, cut):
    data = b"".join(encode_p2os_frame(body) for body, _ in frames)
    decoder = p2os_decoder(NoOptions(), "host")
    items = [item for at in range(0, len(data), cut) for item in decoder.feed(data[at : at + cut])]
    assert [said(item) for item in [*items, *decoder.finish()]] == [name for _, name in frames]


def test_what_looks_at_few_frames_of_p2os_tells_a_sync_from_a_pulse():
    decoder = p2os_decoder(NoOptions(), "host")
    found = decoder.find(b"".join(encode_p2os_frame(body) for body, _ in HANDSHAKE + SESSION))
    assert decoder.sort(found[0]) != decoder.sort(found[4]) == decoder.sort(found[6])
    assert decoder.read(found[6]).name == "PULSE"


# --- what cannot be read


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("dump", b"50 4B 54 21\n50 XY\n", "dump:2: '50 XY' is no line of a hex dump"),
        ("odd", b"50 4B 54 21\n5\n", "odd:2: '5' is no line"),
        ("journal", b'{"kind":"journal"}\nnothing\n', "journal:2: is no event of a journal"),
        ("deep", b'{"kind":"journal"}\n{"kind":"x","v":' + b"[" * 100_000 + b"\n", "deep:2: is no event of a journal"),
        *(
            (
                "ns",
                b'{"kind":"tx","source":"rover","data":"55","ns":' + ns + b"}\n",
                "ns:1: is no event of a journal",
            )
            for ns in (b"1e400", b"1" * 400, b"-1", b"NaN", b'"5"', b"null")
        ),
    ],
)
def test_damaged_input(tmp_path, capsys, name, text, message):
    (tmp_path / name).write_bytes(text)
    assert main(["decode", "pkt", str(tmp_path / name)]) == 3
    assert message in capsys.readouterr().err


def test_no_such_file(tmp_path, capsys):
    assert main(["decode", "pkt", str(tmp_path / "none")]) == 3
    assert main(["decode", "pkt", str(tmp_path)]) == 3
    assert main(["decode", "modbus", str(tmp_path)]) == 2
    assert capsys.readouterr().err.count("\n") == 3


def test_the_end_of_a_journal_may_be_missing(tmp_path, capsys):
    event = json.dumps({"ns": 5, "kind": "tx", "source": "rover", "data": REQUEST.hex()})
    (tmp_path / "cut").write_text(f'{{"kind":"journal"}}\n{event}\n{event[:20]}')
    assert main(["decode", "pkt", str(tmp_path / "cut")]) == 0
    said = capsys.readouterr()
    assert said.out == "       0      0.000000 s  rover tx      REQUEST_TMY\n"
    assert said.err == f"{tmp_path / 'cut'}: cut in line 3: decoded up to there\n1 frame\n"


@pytest.mark.parametrize("form", ["journal", "mcap", "pcapng", "csv"])
def test_a_later_part_of_a_journal_says_where_its_beginning_is(tmp_path, capsys, form):
    path, capture = tmp_path / "part.jsonl", tmp_path / "capture"
    event = json.dumps({"ns": 5, "kind": "tx", "source": "rover", "data": REQUEST.hex()})
    header = json.dumps({"kind": "journal", "part": 2}, separators=(",", ":"))
    path.write_text(f"{header}\n{event}\n")
    if form != "journal":
        assert main(["export", str(path), f"--{form}", str(capture)]) == 0
        assert capsys.readouterr().err == f"{path}: its beginning is in an older file\n"
    source = path if form == "journal" else capture
    assert main(["decode", "pkt", str(source)]) == 0
    assert capsys.readouterr().err == f"{source}: its beginning is in an older file\n1 frame\n"


def test_parts_that_follow_each_other_have_their_beginning(tmp_path, capsys):
    event = json.dumps({"ns": 5, "kind": "tx", "source": "rover", "data": REQUEST.hex()})
    (tmp_path / "both").write_text("".join(f'{{"kind":"journal","part":{part}}}\n{event}\n' for part in range(2)))
    assert main(["decode", "pkt", str(tmp_path / "both")]) == 0
    assert capsys.readouterr().err == "2 frames\n"


# --- input that never ends


def test_what_comes_is_shown_at_once_and_a_signal_ends_it():
    with subprocess.Popen(
        [*COMMAND, "pkt"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as ran:
        ran.stdin.write(REQUEST)
        ran.stdin.flush()
        assert ran.stdout.readline() == b"       0  REQUEST_TMY\n"
        ran.send_signal(signal.SIGINT)
        assert ran.wait(PATIENCE_S) == 130
        assert ran.stderr.read() == b"hilbench: interrupted\n"
        ran.stdin.close()


def test_a_reader_that_goes_ends_it():
    """`hilbench decode pkt < /dev/zero | head -1`, with a source that never ends."""
    with (
        open("/dev/zero", "rb") as zeros,
        subprocess.Popen(
            [*COMMAND, "pkt", "--input", "raw"], stdin=zeros, stdout=subprocess.PIPE, stderr=subprocess.PIPE
        ) as ran,
    ):
        assert ran.stdout.readline().startswith(b"       0  !! no sync word: 00 00")
        ran.stdout.close()
        assert ran.wait(PATIENCE_S) == 1
        assert ran.stderr.read().startswith(b"0 frames, ")


def test_output_that_cannot_be_written():
    with open("/dev/full", "wb") as full:
        done = subprocess.run([*COMMAND, "pkt"], input=REQUEST, stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 3
    assert done.stderr.decode().startswith("hilbench: the standard output: cannot be written")


@pytest.mark.parametrize("form", ["mcap", "pcapng", "csv"])
def test_a_capture_says_what_its_journal_says(tmp_path, capsys, form):
    journal, capture = tmp_path / "run.jsonl", tmp_path / "capture"
    log = Journal(journal)
    for number in range(3):
        log.record("tx", "rover", number * 1000, data=MOTION + DAMAGED)
        log.record("rx", "rover", number * 1000 + 1, data=REQUEST)
    log.close()
    assert main(["export", str(journal), f"--{form}", str(capture)]) == 0
    capsys.readouterr()
    said = {}
    for path in (journal, capture):
        assert main(["decode", "pkt", str(path), "--json"]) == 1
        said[path] = capsys.readouterr().out
    assert said[capture] == said[journal]
    assert said[journal].count('"stream": "rover rx"') == 3


def test_a_capture_that_was_cut_is_shown_up_to_there(tmp_path, capsys):
    journal, capture = tmp_path / "run.jsonl", tmp_path / "capture"
    log = Journal(journal)
    log.record("rx", "rover", 0, data=REQUEST)
    log.record("rx", "rover", 1, data=REQUEST)
    log.close()
    main(["export", str(journal), "--pcapng", str(capture)])
    capsys.readouterr()
    capture.write_bytes(capture.read_bytes()[:-140])
    assert main(["decode", "pkt", str(capture)]) == 0
    said = capsys.readouterr()
    assert said.out.count("REQUEST_TMY") == 1
    assert said.err == f"{capture}: cut in block 5: decoded up to there\n1 frame\n"
