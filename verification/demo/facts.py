"""The demonstration in words: the same lines in the terminal and on the page."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from saoflow.report import Fact, TextTable
from verification.demo.result import ROUNDING, SETTLED, TOLERANCES, DemoResult, Method, OtherDecision
from verification.demo.scenario import FRAMES_SHOWN, WITHIN

SENSORS = {"alpha": "angle-of-attack", "vc": "airspeed"}


def facts(result: DemoResult) -> tuple[Fact, ...]:
    """What was found, each with its verdict."""
    return (
        Fact("detected", _detected(result), result.detected),
        Fact("without bounds", _without_bounds(result), result.not_by_umhe),
        Fact("angle of attack", _alpha(result)),
        Fact("airspeed", _airspeed(result)),
        *(Fact(f"budget {m.sheet.name}", _budget(m), not m.budget.over) for m in result.methods),
        Fact("equal to numpy", _equal(result), result.equal),
    )


def _detected(result: DemoResult) -> str:
    delays = result.delays(result.cmhe)
    wrong = result.false_alarms(result.cmhe)
    frame = result.isolated_frame(result.cmhe)
    what = SENSORS[result.scenario.fault.sensor]
    if frame is None:
        text = f"CMHE-FTE misses {what} sensors {_numbers(set(result.scenario.fault.which) - set(delays))}"
    else:
        seconds = max(delays.values()) * result.recording.period
        text = (
            f"CMHE-FTE isolates {what} sensors {_numbers(delays)} at t = {result.time[frame]:.2f} s, {seconds:.2f} s after "
            f"the onset (asked: {WITHIN:g} s)"
        )
    return text + (f"; false alarms: {len(wrong)}" if wrong else "; no healthy sensor is condemned")


def _without_bounds(result: DemoResult) -> str:
    shown = FRAMES_SHOWN * result.recording.period
    frame = result.isolated_frame(result.umhe)
    if not result.not_by_umhe:
        return f"UMHE-FTE condemns a sensor within {FRAMES_SHOWN} frames"
    text = f"UMHE-FTE does not notice within {FRAMES_SHOWN} frames ({shown:.2f} s)"
    if frame is None:
        return text
    late = frame - result.scenario.onset_frame
    return f"{text}; it does after {late} ({late * result.recording.period:.1f} s), at {_reading(result, frame):.0f} kt"


def _reading(result: DemoResult, frame: int) -> float:
    return float(result.recording["vc_1"][frame])


def spans(result: DemoResult, method: Method) -> tuple[tuple[str, int, int], ...]:
    """Before the fault (settled), from its onset to its isolation, and after: name, first frame, end."""
    onset, end = result.scenario.onset_frame, len(result.time)
    isolated = result.isolated_frame(method)
    if isolated is None:
        return ("before the fault", SETTLED, onset), ("after the onset", onset, end)
    return ("before the fault", SETTLED, onset), ("until isolated", onset, isolated), ("after", isolated, end)


def _alpha(result: DemoResult) -> str:
    parts = [
        f"{result.errors(result.cmhe, 'alpha', first, end).largest:.2f} deg {name}"
        for name, first, end in spans(result, result.cmhe)
    ]
    return "largest error " + ", ".join(parts)


def _airspeed(result: DemoResult) -> str:
    parts = [
        f"{result.errors(result.cmhe, 'vc', first, end).largest:.1f} kt {name}"
        for name, first, end in spans(result, result.cmhe)
    ]
    return (
        "largest error " + ", ".join(parts) + "; no airspeed sensor is left then, and wind cannot be told from airspeed"
    )


def _budget(method: Method) -> str:
    limit = next((line.limit for line in method.budget.lines if line.kind == "operations"), None)
    asked = f" of {thousands(limit)} allowed" if limit is not None else ""
    frames = len(method.outputs["configuration"])
    return f"{thousands(method.budget.total)} operations a frame{asked}; {frames} frames in {method.seconds:.2f} s"


def _equal(result: DemoResult) -> str:
    def worst(quantity: str, exact: bool, fault_free: bool) -> float:
        return max(result.largest_difference(m, quantity, exact, fault_free) for m in result.methods)

    others = [f"{m.label} {_other(other)}" for m in result.methods for other in m.other_decisions]
    decisions = "every decision at the same frame" + (" but " if others else "") + ", ".join(others)
    return (
        f"before the fault within {worst('alpha', False, True):.1e} deg and {worst('vc', False, True):.1e} kt with tables, "
        f"{worst('alpha', True, True):.0e} deg and {worst('vc', True, True):.0e} kt with exact functions; "
        f"{decisions}"
    )


def _other(other: OtherDecision) -> str:
    unit = {"alpha": "deg", "vc": "kt"}[other.sensor]
    own, reference = ("never" if frame is None else f"frame {frame}" for frame in (other.own, other.other))
    return f"{other.sensor}_{other.number} at {own}, not {reference} (rms {other.margin:.0e} {unit} from the threshold)"


def error_table(result: DemoResult) -> TextTable:
    """Errors of the estimates against truth, by estimator and span."""
    rows = []
    for method in result.methods:
        for name, first, end in spans(result, method):
            alpha = result.errors(method, "alpha", first, end)
            vc = result.errors(method, "vc", first, end)
            time = f"{result.time[first]:.1f} to {result.time[end - 1]:.1f}"
            numbers = (f"{alpha.rms:.3f}", f"{alpha.largest:.3f}", f"{vc.rms:.2f}", f"{vc.largest:.2f}")
            rows.append((method.label, name, time, *numbers))
    return TextTable(
        "Errors of the estimates",
        ("estimator", "span", "time [s]", "alpha rms [deg]", "largest", "airspeed rms [kt]", "largest"),
        tuple(rows),
        f"Estimate minus truth. Before the fault: from frame {SETTLED}, when the start-up ends.",
        words=2,
    )


def equality_table(result: DemoResult) -> TextTable:
    """Largest distances from the reference, by estimator."""
    rows = []
    for method in result.methods:
        for exact in (False, True):
            numbers = [
                f"{result.largest_difference(method, quantity, exact, fault_free):.1e}"
                for fault_free in (True, False)
                for quantity in ("alpha", "vc")
            ]
            rows.append((method.label, "exact functions" if exact else "tables", *numbers))
    return TextTable(
        "Largest distances from the numpy reference, in closed loop",
        (
            "estimator",
            "sheet with",
            "alpha [deg], fault-free",
            "airspeed [kt]",
            "alpha [deg], whole run",
            "airspeed [kt]",
        ),
        tuple(rows),
        f"Asked fault-free: {TOLERANCES['alpha']:g} deg and {TOLERANCES['vc']:g} kt with tables, {ROUNDING['alpha']:g} deg "
        f"and {ROUNDING['vc']:g} kt with exact functions. At the wind bound the line search may take another step on the "
        "last bit, so that the whole run is shown, not judged; `saoflow verify cmhe_fte` judges every step there.",
        words=2,
    )


def to_dict(result: DemoResult, files: tuple[str, ...]) -> dict[str, Any]:
    """The machine-readable form (``--json``)."""
    return {
        "holds": result.holds,
        "flight": result.scenario.flight,
        "seed": result.scenario.seed,
        "frames": len(result.time),
        "onset_frame": result.scenario.onset_frame,
        "facts": [{"label": f.label, "text": f.text, "holds": f.holds} for f in facts(result)],
        "methods": {m.sheet.name: _method_dict(result, m) for m in result.methods},
        "files": list(files),
    }


def _method_dict(result: DemoResult, method: Method) -> dict[str, Any]:
    return {
        "operations": method.budget.total,
        "confirmed": [{"sensor": f"{c.sensor}_{c.number}", "frame": c.frame} for c in method.confirmed],
        "delays_frames": {str(number): frames for number, frames in sorted(result.delays(method).items())},
        "errors": {
            name: {
                quantity: {"rms": error.rms, "largest": error.largest}
                for quantity in ("alpha", "vc")
                for error in [result.errors(method, quantity, first, end)]
            }
            for name, first, end in spans(result, method)
        },
        "largest_difference": {
            f"{quantity}_{'exact' if exact else 'tables'}_{'fault_free' if free else 'whole'}": (
                result.largest_difference(method, quantity, exact, free)
            )
            for quantity in ("alpha", "vc")
            for exact in (False, True)
            for free in (True, False)
        },
        "same_decisions": method.same_decisions,
        "other_decisions": [_other(other) for other in method.other_decisions],
        "seconds": method.seconds,
    }


def thousands(number: float) -> str:
    """16742 as 16 742."""
    return f"{number:,.0f}".replace(",", "\N{NARROW NO-BREAK SPACE}")


def _numbers(numbers: Iterable[int]) -> str:
    found = [str(n) for n in sorted(numbers)]
    return found[0] if len(found) == 1 else f"{', '.join(found[:-1])} and {found[-1]}"
