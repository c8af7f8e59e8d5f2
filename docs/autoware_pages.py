"""The pages of docs/autoware that are made from the code, for `generate.py`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from protocols.autoware import (
    AGENT_TABLE,
    BOARD_TABLE,
    MESSAGE_IDS,
    MESSAGES,
    AckermannControlCommand,
    AgentOnline,
    AgentOptions,
    AgentPing,
    BoardOptions,
    Clock,
    ControlModeReport,
    ControlModeRequest,
    ControlModeResponse,
    DropReason,
    FieldSpec,
    FramingOptions,
    HazardLightsCommand,
    MessageSpec,
    SteeringReport,
    Time,
    TurnIndicatorsCommand,
    VelocityReport,
    WireType,
    encode_frame,
    encode_message,
    longest_frame,
    payload_size,
)

Table = Callable[[Sequence[str], Iterable[Sequence[str]]], str]

SIZES = {WireType.TIME: 8, WireType.FLOAT32: 4, WireType.UINT8: 1, WireType.BOOL: 1}
NOON = Time(12, 500_000_000)
EXAMPLES = (
    AgentOnline(),
    AgentPing(),
    Clock(clock=NOON),
    AckermannControlCommand(
        stamp=NOON,
        steering_tire_angle=0.5,
        steering_tire_rotation_rate=0.1,
        speed=5.0,
        acceleration=1.0,
        jerk=0.2,
    ),
    ControlModeRequest(sequence=7, mode=1),
    ControlModeResponse(sequence=7, success=True),
    ControlModeReport(mode=4),
    ControlModeReport(stamp=Time(0x7E, 0x7D), mode=0),
    VelocityReport(longitudinal_velocity=8.3333, lateral_velocity=-0.05, heading_rate=0.1),
    SteeringReport(steering_tire_angle=-0.2),
    TurnIndicatorsCommand(command=2),
    HazardLightsCommand(command=2),
)


def messages_page(table: Table) -> str:
    """Every message: fields, units, rate, original type."""
    text = (
        "# The messages of the driving stack\n\n"
        "Defined once in `protocols.autoware`, with the names, fields and enumerations of the original's types "
        "(autoware_auto_control_msgs, autoware_auto_vehicle_msgs, builtin_interfaces, rosgraph_msgs), as the board of "
        "LMA-FEM-UNICAMP/microAutoware subscribes to and publishes them (src/microAutoware/microAutoware.c). They "
        "travel in the [stand-in link](stand-in-link.md); id and offsets are those of its payload, little-endian, and "
        "our choice. A micro-ROS agent will replace the link, not the messages.\n\n"
        "Left out are the stamps inside `lateral` and `longitudinal`, which repeat the command's, and the velocity "
        "report's frame id, always `base_link`. Reports carry the latest Clock as their stamp, 0 before the first.\n\n"
    )
    text += table(
        ("Id", "Message", "Bytes", "Sender", "Topic or service", "Rate", "Choice"),
        [_row(spec) for spec in MESSAGES.values()],
    )
    for spec in MESSAGES.values():
        if spec.fields:
            text += f"\n## {spec.kind.__name__}\n\n`{spec.original}`, id `{MESSAGE_IDS[spec.kind]:02X}`\n\n"
            text += table(("Offset", "Field", "In the original", "Type", "Unit or values"), _fields(spec))
    return text


def _row(spec: MessageSpec) -> tuple[str, ...]:
    kind = spec.kind
    return (
        f"`{MESSAGE_IDS[kind]:02X}`",
        kind.__name__,
        str(payload_size(kind)),
        spec.sender.value,
        f"`{spec.topic}`" if spec.topic else "",
        spec.rate,
        spec.choice,
    )


def _fields(spec: MessageSpec) -> Iterable[tuple[str, ...]]:
    offset = 1
    for field in spec.fields:
        yield (str(offset), f"`{field.name}`", _original(field), field.type.value, field.unit)
        offset += SIZES[field.type]


def _original(field: FieldSpec) -> str:
    return f"`{field.original}`" if field.original else "none: choice"


def stand_in_page(table: Table, machine: Callable[[str, Mapping[object, object]], str]) -> str:
    """The frame, byte by byte, with worked examples, and both ends' state machines."""
    board, agent, frames = BoardOptions(), AgentOptions(), FramingOptions()
    layout = [
        ("0", "1", "flag `7E`", "never escaped, and nowhere else in a frame"),
        ("1", "1", f"source address, {frames.local_address}", "of the sender"),
        ("2", "1", f"remote address, {frames.remote_address}", "of the receiver, who drops frames for others"),
        ("3", "2", "length of the payload, low byte first", f"1 to {frames.max_payload} (choice); before escaping"),
        ("5", "n", "payload", "message id, then its fields (choice)"),
        ("5+n", "2", "CRC-16/ARC of the payload, low byte first", "of the payload before escaping, nothing else"),
    ]
    examples = [(f"`{one}`", f"`{encode_frame(encode_message(one)).hex(' ').upper()}`") for one in EXAMPLES]
    return (
        "# The stand-in link\n\n"
        "The original's board speaks micro-ROS on its second UART (USART3, 921600 baud, 8N1): XRCE-DDS in the serial "
        "stream of Micro XRCE-DDS, to an agent on the computer. Here a stand-in takes that place: the frames of that "
        "stream (eProsima/Micro-XRCE-DDS-Client, src/c/profile/transport/stream_framing/stream_framing_protocol.c) "
        "around a payload of our own, one byte id and little-endian fields without gaps ([messages.md](messages.md)). "
        "The bench `vehicle-micro-ros` has an agent in its place, with the same messages.\n\n"
        "## The frame\n\nOffsets are those before escaping.\n\n"
        + table(("Offset", "Bytes", "What", "Remark"), layout)
        + "\nIn everything behind the flag (addresses, length, payload, CRC) each `7E` is sent as `7D 5E` and each "
        "`7D` as `7D 5D`. A receiver undoes `7D x` as `x xor 20`, whatever x is. "
        f"So the longest frame has {longest_frame()} bytes on the wire, and the longest message's, when nothing is "
        f"escaped, {7 + max(payload_size(kind) for kind in MESSAGES)}.\n\n"
        "CRC-16/ARC: polynomial `8005`, reflected: start with `0000`; for each byte `crc ^= byte`, then eight times "
        "`crc = crc & 1 ? crc >> 1 ^ A001 : crc >> 1`; no final xor. `123456789` gives `BB3D`.\n\n"
        "## What a receiver does\n\n"
        "- A flag always begins a frame, also in the middle of one and behind a `7D`: what was begun is dropped.\n"
        "- Two flags in a row are one.\n"
        "- A frame for another address, or one that is too long, is passed over up to the next flag.\n"
        "- A frame with a wrong CRC is dropped; so is a payload whose size is not that of its message. An unknown id "
        "is passed on and counted.\n"
        "- There is no acknowledgement, no repetition and no sequence number: the newest message counts, as with the "
        "original's QoS (keep last, depth 1). Nothing on the link is timed but the ping.\n\n"
        + table(("Dropped as", "Because"), [(f"`{one.name}`", one.value) for one in DropReason])
        + "\n## Is an agent there? (choice)\n\n"
        f"After a reset the board sends AgentPing every {board.ping_s:g} s, at most {board.pings} times, the first at "
        "once, until an AgentOnline comes; the agent answers each ping, and says AgentOnline by itself when it opens "
        f"the line. Without an answer the board gives up {board.pings * board.ping_s:g} s after it began "
        "(the original: `rmw_uros_ping_agent(1000, 20)`). An AgentOnline that comes later is taken, too, unless the "
        f"option `reconnects` is off, as in the original. The agent takes a board for lost that sent no sound frame "
        f"for {agent.silence_s:g} s.\n\n"
        "## Frames worked out\n\n"
        + table(("Message", "Frame"), examples)
        + "\n## States\n\n"
        + machine("The board's end", BOARD_TABLE).replace("## The", "### The", 1)
        + "\n"
        + machine("The agent's end", AGENT_TABLE).replace("## The", "### The", 1)
    )
