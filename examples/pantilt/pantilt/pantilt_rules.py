"""What a pan-tilt head must do: in its world, where the truth is known, and at a port."""

import math

import pytest

from hilbench.check import case
from pantilt.frames import IDS, Goal, Read, Refused, Status, Torque, Why, encode, frame

POWER_ON_S, ANSWER_S, SPEED_DEG_S, REST_S = 0.1, 0.02, 60, 0.6  # to listen, to answer, to turn, to come to rest
joints = pytest.mark.parametrize("joint", [*IDS])


@pytest.fixture
def hands(peer):
    peer.run(POWER_ON_S)
    return Hands(peer)


class Hands:
    """The checker at the bus."""

    def __init__(self, peer):
        self.peer = peer

    def status(self, message):
        return self.peer.ask(message, Status, ANSWER_S, where=lambda answer: answer.servo == message.servo)

    def refused(self, servo, payload):
        mark = self.peer.mark()
        self.peer.write(frame(servo, payload))
        return Why(self.peer.expect(Refused, ANSWER_S, where=lambda answer: answer.servo == servo, mark=mark).why)

    def says(self, joint):
        return self.status(Read(IDS[joint])).angle_cdeg / 100

    def go(self, joint, degrees, seconds=None):
        """Send a joint somewhere, and wait until it has to be there."""
        begin = self.status(Torque(IDS[joint], True)).angle_cdeg / 100
        self.status(Goal(IDS[joint], 100 * degrees))
        self.wait(abs(degrees - begin) / SPEED_DEG_S + REST_S if seconds is None else seconds)

    def wait(self, seconds):
        """Let time pass, and feed both watchdogs."""
        for _ in range(math.ceil(seconds / 0.1)):
            begun_ns = self.peer.bench.now_ns
            self.peer.run(0.1)
            for servo in IDS.values():
                self.status(Read(servo))
            self.peer.require_punctual(begun_ns, 0.8, "a watchdog may have let go")


def true(world, joint):
    return math.degrees(world.joint(joint).angle_rad)


def near(degrees, by=0.5):
    return pytest.approx(degrees, abs=by)


@joints
@case("PT1", bench_time_s=0.3)
def test_commands_are_answered(hands, joint):
    servo = IDS[joint]
    for command in (Read(servo), Torque(servo, True), Goal(servo, 0), Torque(servo, False)):
        hands.status(command)
    assert hands.refused(servo, b"\x07") is Why.SENSELESS


@joints
@case("PT2", bench_time_s=6.0)
def test_a_goal_is_reached_and_held(hands, world, joint):
    for degrees in (50, -55, 0):
        hands.go(joint, degrees)
        for _ in range(3):
            assert true(world, joint) == near(degrees)
            hands.wait(0.1)


@joints
@case("PT3", bench_time_s=1.2)
def test_status_says_where_the_joint_is(hands, world, joint):
    hands.go(joint, 45, seconds=0)
    for _ in range(12):
        hands.wait(0.1)
        assert hands.says(joint) == near(true(world, joint), 1)


@joints
@case("PT4", bench_time_s=0.5)
def test_a_goal_beyond_the_limit_is_refused(hands, joint):
    hands.go(joint, 0)
    limit = {"pan": 9000, "tilt": 6000}[joint]
    for angle_cdeg in (limit + 1, -limit - 1, 32767):
        assert hands.refused(IDS[joint], b"\x01" + angle_cdeg.to_bytes(2, "little", signed=True)) is Why.OUT_OF_RANGE
    hands.wait(0.3)
    assert hands.says(joint) == near(0)


@case("PT5", bench_time_s=0.6)
def test_a_wrong_checksum_is_not_answered_and_the_next_frame_is(hands):
    sound = encode(Torque(1, True))
    for damaged in (sound[:-1] + bytes([sound[-1] ^ 1]), sound[:3] + b"\x02" + sound[4:], sound[:4]):
        hands.peer.write(damaged)
        hands.peer.expect_silence(0.1, why="its checksum is wrong")
        assert not hands.status(Read(1)).torque


@case("PT6", bench_time_s=3.0)
def test_servos_do_not_answer_or_move_for_each_other(hands, world):
    hands.go("tilt", 20)
    hands.go("pan", 40)
    assert (true(world, "tilt"), true(world, "pan")) == (near(20), near(40))
    for servo in (0, 3, 0xFF):
        hands.peer.write(frame(servo, b"\x02"))
        hands.peer.expect_silence(0.1, why="nobody has this id")


@joints
@case("PT7", bench_time_s=2.5)
def test_the_watchdog_lets_go(hands, joint):
    for wait_s, tripped in ((0.9, False), (1.1, True)):  # the bench may be 50 ms late, see below
        begun_ns = hands.peer.bench.now_ns
        hands.status(Torque(IDS[joint], True))
        hands.peer.run(wait_s)
        answer = hands.status(Read(IDS[joint]))
        hands.peer.require_punctual(begun_ns, 0.05, "how long nothing was said is not known so well")
        assert (answer.tripped, answer.torque) == (tripped, not tripped)


@joints
@case("PT8", bench_time_s=1.5)
def test_without_torque_nothing_moves(hands, joint):
    hands.go(joint, 30)
    hands.status(Torque(IDS[joint], False))
    assert hands.refused(IDS[joint], b"\x01\x00\x00") is Why.TORQUE_OFF
    there = hands.status(Torque(IDS[joint], True)).angle_cdeg / 100
    hands.wait(0.5)
    assert hands.says(joint) == near(there, 1)


@case("PT9", bench_time_s=3.5)
def test_a_blocked_servo_says_so(hands, world):
    hands.go("tilt", -45)
    hands.go("pan", 90)
    answer = hands.status(Read(IDS["pan"]))
    assert {contact.other for contact in world.contacts("tilt")} == {"post"}
    assert answer.angle_cdeg / 100 == near(true(world, "pan"), 1)
    assert answer.load_percent >= 90
