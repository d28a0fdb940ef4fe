"""The paper's Fig. 4 with the sheets: CMHE finds the triple airspeed runaway within 6 s, UMHE not in 370 frames."""

from __future__ import annotations

from verification.results.fig4 import FAULT, FLIGHT, NOT_WITHIN, WITHIN_S, fig4


def test_cmhe_detects_within_6_s_of_onset_and_keeps_its_estimates():
    assert (FAULT.kind, FAULT.sensor, FAULT.which, FAULT.rate) == ("runaway", "vc", (1, 2, 3), -15.0)
    assert "350kt_5000ft" in FLIGHT
    for one in fig4("cmhe_fte"):
        assert one.delay_frames is not None
        assert one.delay_frames * 0.048 <= WITHIN_S
        assert one.wrong == 0
        assert one.alpha_error < 0.5  # deg; the airspeed sensors' fault does not reach the angle of attack


def test_umhe_does_not_detect_within_370_frames():
    for one in fig4("umhe_fte"):
        assert one.first_frames is None or one.first_frames > NOT_WITHIN
        assert one.vc_error > 200.0  # kt: it follows the fault and calls it wind


def test_ekf_does_not_detect_within_370_frames_either():
    """The paper: the same reason, and the same failure, as UMHE-FTE's."""
    for one in fig4("ekf_fte"):
        assert one.first_frames is None or one.first_frames > NOT_WITHIN
        assert one.wrong == 0
        assert one.vc_error > 200.0
