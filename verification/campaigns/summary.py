"""One run in a few numbers: when which sensor was confirmed, and how far the estimates were from the truth."""

from __future__ import annotations

import numpy as np

from verification.campaigns.detectable import detectable
from verification.campaigns.readings import Flight
from verification.campaigns.row import NAN, NEVER
from verification.flights.drawn import measure_wind
from verification.flights.faults import SENSORS
from verification.recordings.recording import Array
from verification.reference.tuning import Tuning

OUTPUTS = ("alpha_hat", "vc_hat", "alpha_faulty", "vc_faulty", "alpha_rms", "vc_rms", "configuration")
"""Outputs of the sheet that a summary needs."""
TUNING = Tuning()
SETTLED = TUNING.n_inhibit
"""Frames after the start in which nothing is decided: the wind estimate settles. Errors count from then on."""
DEGREES = 180.0 / np.pi


def summary(flight: Flight, out: dict[str, Array]) -> dict[str, object]:
    """Columns of a row. ``out``: the :data:`OUTPUTS`, one row a frame, finite."""
    wind = measure_wind(flight.truth)
    found: dict[str, object] = {
        "wind_x": wind.wx,
        "wind_z": wind.wz,
        "wind_rate": wind.rate,
        "wind_inside": wind.inside,
    }
    for fault in flight.case.faults:
        found[f"{fault.sensor}_detectable"] = detectable(fault, flight.truth, TUNING)
    for sensor in SENSORS:
        faulty = out[f"{sensor}_faulty"] > 0.5
        for i in range(3):
            found[f"{sensor}_confirmed_{i + 1}"] = int(faulty[:, i].argmax()) if faulty[:, i].any() else NEVER
    alpha = np.abs(out["alpha_hat"] - flight.truth["alpha_true"])[SETTLED:] * DEGREES
    vc = np.abs(out["vc_hat"] - flight.truth["vc_true"])[SETTLED:]
    lost = out["configuration"][SETTLED:] > 2.5
    found["alpha_error_max"], found["alpha_error_mean"] = _largest_and_mean(alpha)
    found["vc_error_max"], found["vc_error_mean"] = _largest_and_mean(vc[~lost])
    found["vc_error_max_lost"], found["vc_error_mean_lost"] = _largest_and_mean(vc[lost])
    found["alpha_rms"] = _largest_and_mean(out["alpha_rms"][SETTLED:].ravel())[0] * DEGREES
    found["vc_rms"] = _largest_and_mean(out["vc_rms"][SETTLED:].ravel())[0]
    return found


def _largest_and_mean(values: Array) -> tuple[float, float]:
    return (float(values.max()), float(values.mean())) if len(values) else (NAN, NAN)
