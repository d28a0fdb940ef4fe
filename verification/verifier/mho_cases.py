"""The reference cases of paper 003's sheets, as the entry points of `saoflow.references` name them."""

from __future__ import annotations

from verification.reference.mho import mho_pe as pe
from verification.reference.mho import mho_wd as wd
from verification.reference.mho.tuning import MhoTuning
from verification.verifier import mho_case

RECURSION = 1e-9
"""Tolerance of mho_wd. Its covariances begin with the arrival cost, 2500 times the variance of theta, and lose those
digits by subtraction: with inputs that no flight has, it is 2e-10 from the dense least-squares solution."""

mho_pe = mho_case.observer_case("mho_pe", pe.mho_pe, MhoTuning())
mho_wod = mho_case.observer_case("mho_wod", pe.mho_wod, MhoTuning())
mho_wd = mho_case.observer_case("mho_wd", wd.mho_wd, MhoTuning(), disturbed=True, tolerance=RECURSION)
mho_wd_condensed = mho_case.observer_case("mho_wd_condensed", wd.mho_wd, MhoTuning(), disturbed=True)
ekf = mho_case.ekf_case(MhoTuning())
mho_fault_detection = mho_case.fault_detection_case(MhoTuning())
