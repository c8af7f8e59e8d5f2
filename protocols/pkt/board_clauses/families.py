"""Families of stimuli: every bit of a CRC, every size, every byte at every place, each moment; reserved bytes."""

from __future__ import annotations

from protocols.pkt.board_clauses._common import ALL, DOCUMENTED, LEN, SUITE
from protocols.pkt.clause import CHOICE, DECODER, DOCUMENT, G0, G2, G2_CONFIG, G2_MOTORS, MANUAL, SERIAL, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="P67",
        suite=SUITE,
        level="must",
        title="Each bit of a CRC counts",
        text=(
            "LED_ON with one bit of its opcode or CRC turned, each of the 24, with another value in one byte of the "
            "CRC, or with a CRC by another rule: each time one more is rejected, ERR 3, nothing accepted, the LED not "
            "changed, no 0x81."
        ),
        sources=(DOCUMENT, f"{DECODER} handle_pkt_state_expecting_crc2: both bytes are compared"),
        profiles=ALL,
        needs=("server",),
    ),
    Clause(
        id="P68",
        suite=SUITE,
        level="must",
        title="A frame with a wrong CRC has no answer",
        text=(
            "REQUEST_TMY with one bit of its opcode or CRC turned, or with another value in one byte of the CRC: no "
            "0x80 follows, each is rejected, ERR 3."
        ),
        sources=(
            f"{DOCUMENT}: only a packet with a right CRC is dispatched",
            f"{DECODER} handle_pkt_state_expecting_crc2",
        ),
        profiles=ALL,
        needs=("server",),
    ),
    Clause(
        id="P69",
        suite=SUITE,
        level="must",
        title="Each size too small is an error",
        text=(
            "0x03, 0x04 and 0x05 with each number of parameter bytes below theirs, 9, 9 and 12: one more is accepted, "
            "OP is theirs, ERR not 0, and 0x83 shows throttles and setpoints unchanged."
        ),
        sources=(f"{DOCUMENT}, 0x80: LAST_ERROR is the error of the last command", CHOICE + " which error; ours is 2"),
        profiles=DOCUMENTED,
        needs=("server",),
    ),
    Clause(
        id="P70",
        suite=SUITE,
        level="must",
        title="Each size too large is taken",
        text=(
            "Each command with bytes behind its parameters, from one up to the longest payload: it is taken as without "
            "them, with the parameters behind the opcode. Not asked of g2, which loses a look of eleven bytes (P25): a "
            "long frame may be cut into one."
        ),
        sources=(f"{G2} handle_packet: no command looks at the length", f"{G0} handle_packet, likewise"),
        profiles=("documented", "term-doc", "g0"),
        needs=("server",),
    ),
    Clause(
        id="P71",
        suite=SUITE,
        level="must",
        title="No byte is special inside a frame",
        text=(
            "LED_ON with XON or XOFF (11, 13), with a byte of the sync word, the whole of it, a whole LED_OFF or a "
            "newline, with a control character of terminals, at each place of a longer payload, as a byte of its CRC "
            "or as its length: 1/0/1/0. Without a length byte a newline ends the frame and is not asked for; of g2, "
            "which loses a look of eleven bytes (P25), payloads of two bytes are."
        ),
        sources=(
            f"{DOCUMENT}: a packet is bytes, none is escaped; no flow control is named",
            f"{DECODER} handle_pkt_state_expecting_payload",
        ),
        profiles=ALL,
        needs=("server",),
    ),
    Clause(
        id="P72",
        suite=SUITE,
        level="must",
        title="Reserved bytes of reports are zero",
        text="Bytes 2 and 3 of 0x82 and 0x84 and bytes 1 to 3 of 0x83 are 00 in each report of 2 s.",
        sources=(
            f"{MANUAL}, 0x82 to 0x84: reserved",
            f"{G2} send_imu_report, send_motion_control_report, send_gps_report: zeros",
            f"{G0} send_imu_report",
        ),
        profiles=LEN,
        needs=("server",),
    ),
    Clause(
        id="P73",
        suite=SUITE,
        level="must",
        title="Reserved flags mean nothing",
        text=(
            "0x03 and 0x04 with any of bits 2 to 7 of the flags set besides: bits 0 and 1 alone say for which pair the "
            "command is, as 0x83 shows."
        ),
        sources=(f"{DOCUMENT}, 0x03", f"{MANUAL}, 0x03", f"{G2_MOTORS} set_motor_throttles: tests bits 0 and 1"),
        profiles=DOCUMENTED,
        needs=("server",),
    ),
    Clause(
        id="P74",
        suite=SUITE,
        level="must",
        title="No unknown opcode is taken for another",
        text="Each opcode that the schema does not have, alone in its payload: one more is accepted, OP is it, ERR 5.",
        sources=(f"{G2} handle_packet", f"{G0} handle_packet"),
        profiles=LEN,
        needs=("server",),
    ),
    Clause(
        id="P75",
        suite=SUITE,
        level="must",
        title="Reports do not double when the port is opened again",
        text=(
            "The port is closed for half a second and opened again, twice: in 2 s after it at most one and a half "
            "times as many reports come as before."
        ),
        sources=(
            f"{MANUAL}, table of tasks: each report has its period",
            f"{G0} execute_periodic_tasks",
            CHOICE + " how many are too many",
        ),
        profiles=LEN,
        needs=("server", "reopen"),
    ),
    Clause(
        id="P81",
        suite=SUITE,
        level="must",
        title="Two commands at once are taken in their order",
        text=(
            "Two of REQUEST_TMY, LED_ON, LED_OFF, 0x03, 0x04 and 0x05 without a gap, in each order, and each twice: "
            "both are accepted and followed by their 0x81 in this order, a request is answered, and the later command "
            "of the motors is what 0x83 shows."
        ),
        sources=(SERIAL, f"{G2} handle_packet: each packet when it is complete"),
        profiles=DOCUMENTED,
        needs=("server",),
    ),
    Clause(
        id="P82",
        suite=SUITE,
        level="must",
        title="Each command is taken late, and none of which the end is late",
        text=(
            "1.2 s behind the last frame, when link and motors have been stopped, REQUEST_TMY, LED_ON, LED_OFF, 0x03, "
            "0x04 or 0x05 is taken as ever, and but by 0x03 and 0x04 no motor runs again. Cut behind any of its bytes "
            "and ended 1.2 s later it is not; whole behind that it is."
        ),
        sources=(
            f"{G2} handle_connection_lost, its comment: on a lost connection switch the vehicle off at once",
            f"{G2_CONFIG} HEARTBEAT_TIMEOUT_IN_MS, PACKET_TIMEOUT_IN_MS",
        ),
        profiles=DOCUMENTED,
        needs=("server",),
    ),
)
