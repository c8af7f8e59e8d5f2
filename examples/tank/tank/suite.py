"""What a node of the tank bus must do: on the model, at a port, and on the firmware."""

import pytest

from hilbench.check import case
from tank.frames import Level, Read, Refused, SetValve, encode, frame

ANSWER_S = 0.05
POWER_ON_S = 0.1


@pytest.fixture
def node(peer):
    """The checker's end of the line, when a node that has just got power listens."""
    peer.run(POWER_ON_S)
    return peer


@case("TANK1", bench_time_s=0.1)
def test_read_is_answered(node):
    assert node.ask(Read(), Level, ANSWER_S).level_mm > 0


@case("TANK2", bench_time_s=0.3)
def test_the_valve_goes_where_it_is_told_to(node):
    for percent in (40, 100, 0):
        assert node.ask(SetValve(percent), Level, ANSWER_S).percent == percent
        assert node.ask(Read(), Level, ANSWER_S).percent == percent


@case("TANK3", bench_time_s=0.3)
def test_what_makes_no_sense_is_refused_and_changes_nothing(node):
    node.ask(SetValve(30), Level, ANSWER_S)
    for wrong in (b"\x02\x65", b"\x02", b"\x07", b"\x01\x00"):
        mark = node.mark()
        node.write(frame(wrong))
        assert node.expect(Refused, ANSWER_S, mark=mark).command == wrong[0]
    assert node.ask(Read(), Level, ANSWER_S).percent == 30


@case("TANK4", bench_time_s=0.5)
def test_a_wrong_crc_is_not_answered_and_the_next_frame_is(node):
    sound = encode(SetValve(70))
    for damaged in (sound[:-1] + bytes([sound[-1] ^ 1]), b"\x00" + sound[1:], sound[:3]):
        node.write(damaged)
        node.expect_silence(0.1, why="its CRC is wrong")
        assert node.ask(Read(), Level, ANSWER_S).percent == 0


@case("TANK5", bench_time_s=2.5)
def test_the_watchdog_shuts_the_valve(node):
    for wait_s, tripped in ((0.9, False), (1.1, True)):  # the bench may be 50 ms late, see below
        begun_ns = node.bench.now_ns
        node.ask(SetValve(60), Level, ANSWER_S)
        node.run(wait_s)
        answer = node.ask(Read(), Level, ANSWER_S)
        node.require_punctual(begun_ns, 0.05, "how long nothing was said is not known so well")
        assert (answer.tripped, answer.percent) == (tripped, 0 if tripped else 60)
