"""Cycles and time of a frame on named processors: an estimate from published pipeline models, calibrated in instructions."""

from saoflow.targets.frame_cost import CAVEAT, FORMS, BodyCost, FormCost, FrameCost, frame_cost
from saoflow.targets.target import InstructionSet, Shares, Target, Timing, find_target, targets

__all__ = [
    "CAVEAT",
    "FORMS",
    "BodyCost",
    "FormCost",
    "FrameCost",
    "InstructionSet",
    "Shares",
    "Target",
    "Timing",
    "find_target",
    "frame_cost",
    "targets",
]
