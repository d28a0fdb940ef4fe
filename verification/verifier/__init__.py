"""The verifier: sheets against their numpy references.

from verification.verifier import verify

print(verify("cmhe_fte", frames=600).summary)
"""

from verification.verifier.case import (
    Choice,
    ClosedLoop,
    Closeness,
    Compared,
    Decision,
    Expected,
    FunctionReference,
    ReferenceCase,
    Scenario,
)
from verification.verifier.find import find_reference
from verification.verifier.report import Check, OtherChoice, OtherDecision, Place, Report
from verification.verifier.verify import FRAMES, verify

__all__ = [
    "FRAMES",
    "Check",
    "Choice",
    "ClosedLoop",
    "Closeness",
    "Compared",
    "Decision",
    "Expected",
    "FunctionReference",
    "OtherChoice",
    "OtherDecision",
    "Place",
    "ReferenceCase",
    "Report",
    "Scenario",
    "find_reference",
    "verify",
]
