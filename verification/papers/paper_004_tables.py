"""Paper 004, Tables III and IV: from the report that ``saoflow campaign`` writes, in ``docs/campaign``."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from verification.papers.document import DocumentError
from verification.papers.finding import Finding, Verdict

PAPER = "004"
SHEET = "cmhe_fte"
CAMPAIGNS = Path(__file__).parents[2] / "docs" / "campaign"

TABLE_III = {"fault_free": (2.44, 8.22, 0.02, 0.02), "faulty": (16.39, 8.22, 0.24, 0.02)}
"""Largest AOA [deg], largest airspeed [kt], mean AOA, mean airspeed."""

TABLE_IV = {"alpha": (0.0, 0.0, 0.92, 19.16, 0.75), "vc": (0.0, 0.0, 0.0, 4.64, 0.80)}
"""FAR, MDR, FIR [%], largest and mean delay [s]."""

WORDS = {"alpha": "AOA", "vc": "airspeed"}
Json = Mapping[str, Any]


def findings(pictures: Path, *, short: bool = False) -> Iterator[Finding]:
    """Both tables, from the campaign's report that is there."""
    yield from tables(reported(CAMPAIGNS))


def reported(folder: Path) -> tuple[str, Json] | None:
    """Name and figures of CMHE in a campaign's report; of several, the one of fewest runs (the paper has 249).

    None if there is no report with both fault-free and faulty runs. Raises DocumentError for a file that is no report.
    """
    found = []
    for path in sorted(folder.rglob("*.json")) if folder.is_dir() else []:
        try:
            report = json.loads(path.read_text(encoding="utf-8"))
            for sheet in report["sheets"]:
                if sheet["sheet"] == SHEET and sheet["fault_free"]["runs"] and sheet["faulty"]["runs"]:
                    found.append((report["runs"], report["campaign"], sheet))
        except (KeyError, TypeError, ValueError) as problem:
            raise DocumentError(f"{path} is no report of a campaign: {problem}") from None
    if not found:
        return None
    runs, name, sheet = min(found, key=lambda one: (one[0], one[1]))
    return f"campaign `{name}`, {runs} runs", sheet


def tables(found: tuple[str, Json] | None) -> Iterator[Finding]:
    """The two findings; without a report they cannot be made."""
    claims = (
        (
            "140 fault-free and 109 faulty runs: AOA errs by at most 2.44 deg without a fault and 0.24 deg in the mean"
            " with one, airspeed by at most 8.22 kt"
        ),
        (
            "no false alarm, no missed detection, at most 0.92 % false isolations, mean delays of 0.75 s (AOA) and 0.80"
            " s (airspeed)"
        ),
    )
    if found is None:
        for item, title, claim in zip(
            ("Table III", "Table IV"), ("estimation", "fault diagnosis"), claims, strict=True
        ):
            yield Finding(
                PAPER,
                item,
                title,
                claim,
                Verdict.NOT_HERE,
                "no campaign's report is in docs/campaign",
                "`saoflow campaign`",
            )
        return
    name, sheet = found
    yield table_iii(name, sheet, claims[0])
    yield table_iv(name, sheet, claims[1])


def table_iii(name: str, sheet: Json, claim: str) -> Finding:
    """Errors of the estimates. Holds: none of ours is more than twice the paper's, counted from its noise on."""
    ours = {group: _errors(sheet[group]) for group in TABLE_III}
    worse = [
        f"{'largest' if i < 2 else 'mean'} error of {WORDS['alpha' if i % 2 == 0 else 'vc']}, {group.replace('_', '-')}"
        for group, values in ours.items()
        for i, (mine, paper) in enumerate(zip(values, TABLE_III[group], strict=True))
        if mine > 2.0 * max(paper, (0.2, 0.8)[i % 2])
    ]
    verdict, condition = _judged(len(worse), 8, worse)
    rows = "\n".join(
        f"| {group.replace('_', '-')}{' (' + str(sheet[group]['runs']) + ' runs)' if who == 'saoflow' else ''} |"
        f" {who} | "
        + " | ".join(f"{v:.2f}" for v in values)
        + " |"
        for group in TABLE_III
        for who, values in (("saoflow", ours[group]), ("paper", TABLE_III[group]))
    )
    text = (
        f"{name[0].upper()}{name[1:]}; winds inside the assumed bounds; airspeed without the categories III and IV, as"
        " in the paper.\n\n| runs | | largest AOA, deg | largest airspeed, kt | mean AOA | mean airspeed"
        f" |\n|---|---|---|---|---|---|\n{rows}\n\nAn error counts as larger than the paper's when it is more than"
        " twice it, and more than twice a sensor's noise (0.2 deg, 0.8 kt)."
    )
    return Finding(PAPER, "Table III", "estimation", claim, verdict, condition, text)


def table_iv(name: str, sheet: Json, claim: str) -> Finding:
    """Decisions. Holds: no rate above the paper's and 1 %, no mean delay above it by a tenth."""
    ours = {sensor: _decisions(sheet, sensor) for sensor in WORDS}
    words = ("false alarms", "missed detections", "false isolations")
    worse = [
        f"{words[i]} of {WORDS[s]}"
        for s, values in ours.items()
        for i in range(3)
        if values[i] > max(1.0, TABLE_IV[s][i])
    ]
    worse += [f"the mean delay of {WORDS[s]}" for s, values in ours.items() if values[4] > 1.1 * TABLE_IV[s][4]]
    alarms = all(values[0] <= 1.0 and values[2] <= max(1.0, TABLE_IV[s][2]) for s, values in ours.items())
    found = all(sheet["faulty"][s]["detectable"] and not sheet["faulty"][s]["detectable_missed"] for s in WORDS)
    fast = {s: _number(sheet["faulty"][s]["fast_delay"]["mean"]) for s in WORDS}
    verdict, condition = Verdict.FAILS, ""
    if not worse:
        verdict = Verdict.HOLDS
    elif alarms and found and all(fast[s] <= 1.1 * TABLE_IV[s][4] for s in WORDS):
        verdict = Verdict.ONLY_IF
        condition = (
            "misses and delays are counted of faults whose own signal exceeds the threshold; smaller ones are missed or"
            " found late"
        )
    rows = "\n".join(
        f"| {WORDS[s]} | {who} | " + " | ".join(f"{v:.2f}" for v in values) + " |"
        for s in WORDS
        for who, values in (("saoflow", ours[s]), ("paper", TABLE_IV[s]))
    )
    must = "; ".join(
        f"{WORDS[s]} {sheet['faulty'][s]['detectable_missed']} missed of {sheet['faulty'][s]['detectable']}, the mean"
        f" delay of the fast ones among them {fast[s]:.2f} s"
        for s in WORDS
    )
    text = (
        f"{name[0].upper()}{name[1:]}; winds inside the assumed bounds.\n\n| sensors | | FAR, % | MDR, % | FIR, % |"
        f" largest delay, s | mean delay, s |\n|---|---|---|---|---|---|---|\n{rows}\n\nOf the faults whose own signal"
        f" holds the residual above the threshold (`verification/campaigns/detectable.py`): {must}. The paper draws"
        " amplitudes from its Table II down to 0.5 deg and 10 kt, below its thresholds, and does not publish its mix;"
        " ours is log-uniform, so it has many that no threshold detector can find."
    )
    return Finding(PAPER, "Table IV", "fault diagnosis", claim, verdict, condition, text)


def _errors(group: Json) -> tuple[float, float, float, float]:
    (a_max, a_mean), (v_max, v_mean) = group["alpha"]["error"], group["vc"]["error"]
    return _number(a_max), _number(v_max), _number(a_mean), _number(v_mean)


def _decisions(sheet: Json, sensor: str) -> tuple[float, float, float, float, float]:
    free, faulty = sheet["fault_free"], sheet["faulty"]
    figures = faulty[sensor]
    return (
        100.0 * free[sensor]["wrong"] / free["runs"],
        100.0 * figures["missed"] / faulty["runs"],
        100.0 * figures["wrong"] / faulty["runs"],
        _number(figures["delay"]["largest"]),
        _number(figures["delay"]["mean"]),
    )


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)


def _judged(worse: int, of: int, names: list[str]) -> tuple[Verdict, str]:
    if not worse:
        return Verdict.HOLDS, ""
    if worse <= of // 2:
        return Verdict.ONLY_IF, f"these are left out: {'; '.join(names)}"
    return Verdict.FAILS, ""
