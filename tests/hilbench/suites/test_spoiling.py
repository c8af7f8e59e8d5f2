"""Frames with one wrong byte: together the families hold each wrong value of the named bytes once, and no other."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hilbench.suites._spoiling import other_rules, other_values, single_bits
from protocols.pkt.decoding import DecodeOptions, checksum

NAMES = {1: "the mark", 3: "the sum"}


@given(st.binary(min_size=4, max_size=8))
def test_each_wrong_value_is_a_member_once(frame):
    bits, others = single_bits(frame, NAMES), other_values(frame, NAMES)
    members = [wrong for _, wrong in (*bits, *others)]
    assert len(bits) == 8 * len(NAMES)
    assert len(members) == len(set(members)) == 255 * len(NAMES)
    for wrong in members:
        corrupted = wrong.put_into(frame)
        assert [place for place in range(len(frame)) if corrupted[place] != frame[place]] == [wrong.place]


def test_members_say_what_is_wrong():
    assert single_bits(b"\0\0\0\5", NAMES)[8][0] == "the sum, bit 0"
    what, wrong = other_values(b"\0\0\0\5", NAMES)[-1]
    assert (what, wrong.put_into(b"\0\0\0\5")) == ("the sum is FF", b"\0\0\0\xff")


def test_some_values_are_left_out():
    assert all(wrong.value != 0xFA for _, wrong in other_values(bytes(4), NAMES, b"\xfa"))


def test_other_rules_make_frames_that_are_sound_but_for_their_checksum():
    rule = checksum(DecodeOptions())
    frame = rule.mended(bytes.fromhex("504B542106800102030405 0000 0A".replace(" ", "")))
    others = other_rules(frame, rule)
    assert len({what for what, _ in others}) == len(others) == 4
    for _, wrong in others:
        assert wrong != frame
        assert rule.mended(wrong) == frame
