"""Whatever two boards and their lines do, what one hears of the other is what was said, once and in order."""

from __future__ import annotations

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from protocols import xrce
from protocols.xrce import AgentOptions, AgentService, ClientState, Status
from tests.protocols.xrce.star import MS, SECOND, Star, objects
from tests.share import examples

NAMES = st.sampled_from(["a", "b"])


class AnyUse(RuleBasedStateMachine):
    """Samples are numbered over all; each client hears rising numbers, of each writer none twice."""

    def __init__(self):
        super().__init__()
        streams = xrce.StreamOptions(max_queued=1000)
        self.star = Star("a", "b", mtu=96, options=AgentOptions(streams=streams), max_queued=1000)
        self.mute = False
        self.star.damage = lambda data: b"" if self.mute else data
        self.written = 0

    @rule(ms=st.integers(1, 1500))
    def time_passes(self, ms):
        self.star.run(ms * MS)

    @rule(mute=st.booleans())
    def lines_are_cut_or_mended(self, mute):
        self.mute = mute

    @rule(name=NAMES)
    def board_connects_and_creates(self, name):
        client = self.star.clients[name]
        if client.state is ClientState.CLOSED:
            self.star.connect(name)
        if client.state is ClientState.OPEN:
            for object_id, made in objects().items():
                said = xrce.Create(request_id=10, object_id=object_id, object=made, replace=True)
                self.say(name, said)

    @rule(name=NAMES, stream_id=st.sampled_from([0x80, 0x81, 1]), most=st.sampled_from([1, 3, xrce.UNLIMITED]))
    def board_reads(self, name, stream_id, most):
        control = xrce.DeliveryControl(max_samples=most)
        specification = xrce.ReadSpecification(stream_id=stream_id, delivery=control)
        self.say(name, xrce.ReadData(request_id=20, object_id=0x16, specification=specification))

    @rule(name=NAMES, size=st.integers(1, 60), stream_id=st.sampled_from([0x80, 1]))
    def board_writes(self, name, size, stream_id):
        data = self.written.to_bytes(2, "big") * (size if stream_id == 0x80 else 1)
        self.written += 1
        self.say(name, xrce.WriteData(request_id=30, object_id=0x15, data=data), stream_id)

    @rule(name=NAMES)
    def board_is_reset(self, name):
        self.star.restart(name)

    @rule(name=NAMES)
    def line_goes_down(self, name):
        self.star._wrote(self.star.agent.line_down(name, self.star.now_ns))

    @rule()
    def agent_is_started_anew(self):
        self.star.agent = AgentService(("a", "b"), self.star.options)

    @rule(name=NAMES)
    def board_says_farewell(self, name):
        client = self.star.clients[name]
        if client.state is ClientState.OPEN:
            self.star._took(name, client.disconnect(self.star.now_ns))

    def say(self, name, said, stream_id=0x80):
        client = self.star.clients[name]
        if client.state is ClientState.OPEN:
            try:
                self.star.say(name, said, stream_id=stream_id)
            except xrce.StreamFullError:
                return

    @invariant()
    def samples_are_whole_and_come_once(self):
        for name in ("a", "b"):
            for stream_id in (0x80, 0x81, 1):
                heard = self.star.data(name, stream_id=stream_id)
                assert all(data == data[:2] * (len(data) // 2) for data in heard)
                assert len({*heard}) == len(heard)

    @invariant()
    def little_is_held(self):
        assert self.star.agent.held <= 200_000

    def teardown(self):
        """However it went, boards that are reset find the agent, and each other."""
        self.mute = False
        for name in ("a", "b"):
            self.star.restart(name)
        self.star.run(SECOND)  # what is under way for those before them
        for name in ("a", "b"):
            self.star.heard[name].clear()
            self.star.connect(name)
            for object_id, made in objects().items():
                assert self.star.create(name, object_id, made) is Status.OK
        self.star.read("b")
        self.star.write("a", b"found")
        self.star.run(SECOND)
        assert self.star.data("b") == [b"found"]


TestAnyUse = AnyUse.TestCase
TestAnyUse.settings = settings(max_examples=examples(60), stateful_step_count=25)
