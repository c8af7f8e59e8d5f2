"""What an agent must do, and a client, as rules that can be checked from the far end of a line.

The specification is OMG DDS-XRCE 1.0 (formal/2020-02-01). Where eProsima's client and agent differ from it, the rule is
what a client or an agent in use needs, and says so.
"""

from __future__ import annotations

from functools import partial

from protocols.common.clause import Clause

__all__ = ["AGENT_CLAUSES", "AGENT_SUITE", "CLAUSES", "CLIENT_CLAUSES", "CLIENT_SUITE"]

AGENT_SUITE = "xrce-agent"
CLIENT_SUITE = "xrce-client"

_SPEC = "OMG DDS-XRCE 1.0, "
_AGENT = "eProsima/Micro-XRCE-DDS-Agent, "
_CLIENT = "eProsima/Micro-XRCE-DDS-Client, "


def _rule(
    number: str, title: str, text: str, *sources: str, level: str = "must", prefix: str = "XA", suite: str = AGENT_SUITE
) -> Clause:
    return Clause(
        id=f"{prefix}{number}",
        suite=suite,
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

_client_rule = partial(_rule, prefix="XC", suite=CLIENT_SUITE)

CLIENT_CLAUSES = (
    _client_rule(
        "01",
        "A client asks for a session",
        "Before a session a client says nothing but GET_INFO about the agent and, within 15 s, CREATE_CLIENT: with the "
        "cookie, version 1, a key that is not all zeros, the id of a session, and room for 36 bytes at least; outside "
        "of any session, with the key in the header where the id is below 80 hex.",
        _SPEC + "7.8.2.1 and 8.3.2.1",
        _CLIENT + "session_info.c, uxr_buffer_create_session",
    ),
    _client_rule(
        "02",
        "It asks until it is answered",
        "CREATE_CLIENT that is not answered comes again, the same, twice more within 10 s; pings may come between.",
        _CLIENT + "session.c, wait_session_status",
    ),
    _client_rule(
        "03",
        "A refused client has no session",
        "After STATUS_AGENT with an error nothing comes in the session that was asked for, but its end.",
        _SPEC + "7.8.2.1",
    ),
    _client_rule(
        "04",
        "A slow agent is waited for",
        "STATUS_AGENT that comes 1.5 s after CREATE_CLIENT begins the session: within 3 s something comes in it.",
        _CLIENT + "CMakeLists.txt, UCLIENT_MAX_SESSION_CONNECTION_ATTEMPTS",
    ),
    _client_rule(
        "05",
        "Objects are created, parents first",
        "In a session at least a participant is created within 5 s. The kind in the id of an object is its own, and "
        "the objects that it belongs to were asked for before it.",
        _SPEC + "7.8.3.1 and 8.3.5.2",
    ),
    _client_rule(
        "06",
        "No object twice",
        "In one session no object is created again, but with reuse or replace.",
        _SPEC + "7.8.3.2",
    ),
    _client_rule(
        "07",
        "Numbers of a reliable stream",
        "The messages of each reliable stream have the numbers 0, 1, 2 and so on; one that came may come again.",
        _SPEC + "8.3.2.3 and 8.4.14",
    ),
    _client_rule(
        "08",
        "No more than the window",
        "Without an ACKNACK no more than 16 messages of a reliable stream are sent, as many as it can name.",
        _SPEC + "8.3.5.11",
    ),
    _client_rule(
        "09",
        "What is not acknowledged is said",
        "Within 1 s of a message of a reliable stream that is not acknowledged HEARTBEAT says from where to where "
        "messages are unacknowledged, and of which stream.",
        _SPEC + "8.3.5.12 and 8.4.14",
    ),
    _client_rule(
        "10",
        "What is missing is sent again",
        "A message that an ACKNACK names as missing comes again within 0.5 s, the same bytes.",
        _SPEC + "8.4.14",
    ),
    _client_rule(
        "11",
        "What is acknowledged is done with",
        "A message that was acknowledged does not come again, and no HEARTBEAT names it.",
        _SPEC + "8.4.14",
    ),
    _client_rule(
        "12",
        "A HEARTBEAT is answered",
        "HEARTBEAT is answered within 0.2 s with ACKNACK of that stream: what was received, and what is missing.",
        _SPEC + "8.3.5.12 and 8.4.14",
    ),
    _client_rule(
        "13",
        "What comes too early waits",
        "Of two messages of the reliable stream whose second comes first, ACKNACK names the first as missing and not "
        "the second; when the first has come, both are acknowledged.",
        _SPEC + "8.4.14",
    ),
    _client_rule(
        "14",
        "What comes twice is acknowledged twice",
        "A message of the reliable stream that comes again is acknowledged again.",
        _SPEC + "8.4.14",
    ),
    _client_rule(
        "15",
        "Either byte order",
        "HEARTBEAT with its numbers in big-endian, as its flags say, is understood.",
        _SPEC + "8.3.4",
    ),
    _client_rule(
        "16",
        "Damage is not obeyed",
        "STATUS_AGENT in a frame with a wrong CRC begins no session; noise and a frame that is cut short cost nothing "
        "of the sound HEARTBEAT behind them.",
        _CLIENT + "stream_framing_protocol.c",
    ),
    _client_rule(
        "17",
        "Another session is not its own",
        "HEARTBEAT in a session of another id is not answered.",
        _SPEC + "8.3.2.1",
    ),
    _client_rule(
        "18",
        "An agent that was restarted is found",
        "An agent that has forgotten all, and says so where it is pinged, is asked for a session within 10 s; in that "
        "all streams begin at 0, and the same objects are created.",
        "docs.vulcanexus.org, Reconnections and liveliness; asked for in eProsima/Micro-XRCE-DDS-Client#367",
        level="should",
    ),
    _client_rule(
        "19",
        "An agent that was away is found",
        "The same where an agent is mute for 10 s, and another one takes its place.",
        "docs.vulcanexus.org, Reconnections and liveliness; asked for in eProsima/Micro-XRCE-DDS-Client#367",
        level="should",
    ),
    _client_rule(
        "20",
        "What a client had can be freed",
        "Each session of a client has the same key, by which an agent knows what the one before has left.",
        _SPEC + "7.8.2.1",
        _AGENT + "Root.cpp, create_client",
        level="should",
    ),
    _client_rule(
        "21",
        "Two agents at a line",
        "Where each answer comes twice, as with two agents at one line, the session goes on: it is not asked for "
        "again, and what is said in it is what is said with one.",
        _SPEC + "8.4.14",
    ),
)

CLAUSES = (*AGENT_CLAUSES, *CLIENT_CLAUSES)
