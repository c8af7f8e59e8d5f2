from __future__ import annotations

import faulthandler

import pytest


@pytest.fixture(autouse=True)
def patience():
    faulthandler.cancel_dump_traceback_later()  # minutes are no sign of a hang here
