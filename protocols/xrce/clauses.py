"""What an agent must do, as rules that can be checked from the far end of a line.

The specification is OMG DDS-XRCE 1.0 (formal/2020-02-01). Where eProsima's client and agent differ from it, the rule is
what a client in use needs, and says so.
"""

from __future__ import annotations

from protocols.common.clause import Clause

__all__ = ["AGENT_CLAUSES", "AGENT_SUITE", "CLAUSES"]

AGENT_SUITE = "xrce-agent"

_SPEC = "OMG DDS-XRCE 1.0, "
_AGENT = "eProsima/Micro-XRCE-DDS-Agent, "


def _rule(number: str, title: str, text: str, *sources: str, level: str = "must") -> Clause:
    return Clause(
        id=f"XA{number}",
        suite=AGENT_SUITE,
        level="must" if level == "must" else "should",
        title=title,
        text=text,
        sources=sources,
    )


AGENT_CLAUSES = (
    _rule(
        "01",
        "A session begins",
        "CREATE_CLIENT is answered within 0.2 s by STATUS_AGENT with OK, cookie and version 1.0, on no stream and in "
        "the session that is asked for: with the client key in the header where its id is below 80 hex, else without.",
        _SPEC + "7.8.2.1 and 8.3.2.1",
        _AGENT + "Processor.cpp, process_create_client_submessage",
    ),
    _rule(
        "02",
        "Who is no client is refused",
        "CREATE_CLIENT with another cookie, a later major version or a client key of zeros is answered with an error.",
        _SPEC + "7.8.2.1",
        _AGENT + "Root.cpp, create_client",
    ),
    _rule(
        "03",
        "A ping is answered",
        "GET_INFO about the agent is answered with INFO, availability above 0 and the request's id, in the session of "
        "the question, before there is a session and in it.",
        _SPEC + "8.4.3",
        _AGENT + "Processor.cpp, process_get_info_packet",
    ),
    _rule(
        "04",
        "Objects are created",
        "CREATE of a participant, and of topic, publisher, subscriber, data writer and data reader in it, each in "
        "binary, is answered with STATUS OK, the request's id and the object's.",
        _SPEC + "7.8.3.1 and 8.3.5.2",
    ),
    _rule(
        "05",
        "Objects are created from XML",
        "The same in the XML of Fast DDS's profiles, as micro-ROS sends it, is answered with OK.",
        _SPEC + "7.7.3",
        "micro-ROS/rmw_microxrcedds, rmw_microros_internal",
    ),
    _rule(
        "06",
        "An object without its parent is refused",
        "CREATE of an object whose participant, publisher or subscriber is not there is answered with an error.",
        _SPEC + "7.8.3.1",
    ),
    _rule(
        "07",
        "An object that is there already",
        "CREATE again of the same object is ALREADY_EXISTS; with reuse OK_MATCHED; with replace OK.",
        _SPEC + "7.8.3.2, table of creation modes",
    ),
    _rule(
        "08",
        "An object is deleted once",
        "DELETE of an object is answered with OK, DELETE of it again with UNKNOWN_REFERENCE.",
        _SPEC + "7.8.3.4",
    ),
    _rule(
        "09",
        "The stream of an answer",
        "CREATE on a reliable stream is answered on stream 80 hex, on a best-effort stream on stream 01.",
        _AGENT + "Processor.cpp, process_create_submessage",
        level="should",
    ),
    _rule(
        "10",
        "What is written is read",
        "WRITE_DATA of a data writer comes back as DATA to READ_DATA of a data reader of its topic within 0.5 s: byte "
        "for byte, once, in order, with the id of READ_DATA and the reader's, on the stream that it asks for.",
        _SPEC + "8.3.5.8, 8.3.5.9 and 8.3.5.10",
    ),
    _rule(
        "11",
        "No more is read than is wanted",
        "Of five samples a read with max_samples 2 brings two; one with max_samples 0 ends a read.",
        _SPEC + "7.7.3, DataDeliveryControl",
    ),
    _rule(
        "12",
        "What is not there cannot be read",
        "READ_DATA of an object that is not there is answered with STATUS UNKNOWN_REFERENCE.",
        _SPEC + "7.8.5.1",
    ),
    _rule(
        "13",
        "The order of a reliable stream",
        "Messages that come too early wait for the one before them: three samples whose messages come as 1, 2, 0 are "
        "handed on as 0, 1, 2, and until 0 has come ACKNACK names it as missing.",
        _SPEC + "8.4.14",
    ),
    _rule(
        "14",
        "A message that comes twice",
        "A message of a reliable stream that comes twice is obeyed once, and acknowledged both times.",
        _SPEC + "8.4.14",
    ),
    _rule(
        "15",
        "A HEARTBEAT is answered",
        "HEARTBEAT is answered within 0.2 s with ACKNACK of that stream: what was received, and what is missing.",
        _SPEC + "8.3.5.12 and 8.4.14",
    ),
    _rule(
        "16",
        "What is not acknowledged is sent again",
        "DATA on a reliable stream that is not acknowledged is followed by HEARTBEAT within 1 s, and sent again, the "
        "same bytes, after an ACKNACK that names it.",
        _SPEC + "8.4.14",
    ),
    _rule(
        "17",
        "Fragments are put together",
        "WRITE_DATA in three FRAGMENTs is obeyed as one.",
        _SPEC + "8.3.5.14",
    ),
    _rule(
        "18",
        "A best-effort stream goes forward",
        "A message of a best-effort stream that is older than the latest one, or the same, is not obeyed.",
        _SPEC + "8.4.13",
    ),
    _rule(
        "19",
        "A client starts over",
        "CREATE_CLIENT of a client that has a session begins all streams at 0.",
        _SPEC + "7.8.2.1",
        _AGENT + "Root.cpp, create_client",
    ),
    _rule(
        "20",
        "What a client had is gone",
        "After DELETE of the client, answered with OK on no stream, a new session can create all its objects again.",
        _SPEC + "7.8.2.3",
    ),
    _rule(
        "21",
        "The time is reported",
        "TIMESTAMP is answered with TIMESTAMP_REPLY: the time of the question as it was said, and times of coming and "
        "going in this order, less than 0.2 s apart.",
        _SPEC + "8.3.5.15 and 8.3.5.16",
    ),
    _rule(
        "22",
        "Damage costs one frame",
        "A frame with a wrong CRC, one that is cut short and noise are not obeyed, and the sound frame behind them is.",
        "eProsima/Micro-XRCE-DDS-Client, stream_framing_protocol.c",
    ),
    _rule(
        "23",
        "Either byte order",
        "CREATE and READ_DATA with their numbers in big-endian, as their flags say, are understood.",
        _SPEC + "8.3.4",
    ),
)

CLAUSES = AGENT_CLAUSES
