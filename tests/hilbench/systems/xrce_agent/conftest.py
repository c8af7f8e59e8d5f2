"""Where the processes of a test meet in DDS."""

from __future__ import annotations

import uuid

import pytest


@pytest.fixture
def domain():
    """A domain of its own at the loopback interface, for all processes that are begun with this environment."""
    uri = (
        "<CycloneDDS><Domain><General><Interfaces><NetworkInterface address='127.0.0.1'/></Interfaces>"
        "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
        f"<Peers><Peer address='127.0.0.1'/></Peers><Tag>{uuid.uuid4()}</Tag></Discovery></Domain></CycloneDDS>"
    )
    return {"CYCLONEDDS_URI": uri}
