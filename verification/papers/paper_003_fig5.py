"""Paper 003, Fig. 5: spectral radius of the linearised dynamics inside each iteration."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from verification.flights.true_airspeed import load_pulls, readings
from verification.papers.finding import Finding, Verdict
from verification.papers.mho_runs import FLIGHTS, PE, PE_PLACED, SCENARIOS, SETTLED, WOD, Array, Variant
from verification.papers.paper_003 import PAPER
from verification.papers.style import COLOURS, LIMIT, figure, save

HORIZON = 15
SHORT_HORIZON = 3

MARGINAL = 1e-3
"""Marginally stable: a spectral radius within so much of 1."""

STABLE = 0.999
"""Asymptotically stable: no spectral radius is more."""


def radii(variant: Variant, flight: str, N: int) -> Array:
    """Spectral radius of Phi_i|k, shape (frames, N): of A - L C; without L, of A."""
    sheet = variant.loaded(N)
    paths = [f"step.stages[{i}].Phi" for i in range(N)]
    read = readings(load_pulls(flight), 1).inputs()
    out = sheet.simulator(probes=paths).run({port: read[port] for port in sheet.input_types})
    Phi = np.stack([out[path] for path in paths], axis=1)
    found: Array = np.abs(np.linalg.eigvals(Phi)).max(axis=-1)
    return found


def findings(pictures: Path, *, short: bool = False) -> Iterator[Finding]:
    """Fig. 5."""
    N = SHORT_HORIZON if short else HORIZON
    found = {(v.name, flight): radii(v, flight, N) for v in (WOD, PE, PE_PLACED) for flight in FLIGHTS}
    name = "003_fig_5.png"
    with figure(7.2, 2.8) as drawn:
        axis = drawn.subplots()
        t = load_pulls(FLIGHTS[0])["t"]
        for number, variant in enumerate((WOD, PE, PE_PLACED)):
            axis.plot(t, found[variant.name, FLIGHTS[0]].max(axis=1), color=COLOURS[number], lw=0.9, label=variant.name)
        axis.axhline(1.0, color=LIMIT, ls="--", lw=0.9)
        axis.set_ylabel("largest spectral radius")
        axis.set_xlabel("t, s")
        axis.legend(ncols=3)
        save(drawn, pictures / name)
    rows = ["| | " + " | ".join(f"{scenario}: least / largest" for scenario in SCENARIOS) + " |", "|---|---:|---:|"]
    for variant in (WOD, PE, PE_PLACED):
        ranges = [found[variant.name, flight][SETTLED:].max(axis=1) for flight in FLIGHTS]
        rows.append(f"| {variant.name} | " + " | ".join(f"{r.min():.5f} / {r.max():.5f}" for r in ranges) + " |")
    open_loop = np.concatenate([found[WOD.name, flight][SETTLED:].max(axis=1) for flight in FLIGHTS])
    closed = np.concatenate([found[v.name, f][SETTLED:].max(axis=1) for v in (PE, PE_PLACED) for f in FLIGHTS])
    holds = bool(open_loop.min() > 1.0 - MARGINAL and closed.max() < STABLE)
    text = (
        f"The largest over the {N} transitions of each frame's horizon, from the sheets' own matrices; the first scenario is "
        f"drawn. {np.mean(open_loop > 1.0):.0%} of the frames of MHO-woD have one above 1, by at most {open_loop.max() - 1:.1e}: "
        f"marginal, not unstable. The rule: in every frame above {1 - MARGINAL} without the observer and below {STABLE} with "
        "it, whichever of the two gains.\n\n" + "\n".join(rows)
    )
    verdict = Verdict.HOLDS if holds else Verdict.FAILS
    claim = (
        "The linearised dynamics of MHO-woD are unstable or marginally stable, those of MHO-PE asymptotically stable"
    )
    yield Finding(PAPER, "Fig. 5", "spectral radius", claim, verdict, "", text, (name,))
