"""The demonstration is run once for all tests."""

from __future__ import annotations

import pytest

from verification.demo import DemoResult, Scenario, run_demo


@pytest.fixture(scope="session")
def result() -> DemoResult:
    return run_demo(Scenario())
