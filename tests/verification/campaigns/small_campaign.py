"""A campaign small enough for tests, with several chunks: parts of a few seconds, faults right after start-up."""

from __future__ import annotations

from dataclasses import replace

from verification.campaigns.plan import Campaign, FaultMix, Range, RecordedFlights, RunSet, Variant

MIX = FaultMix((47, 22, 25, 15), (), onset=Range(3.0, 5.0))
FLIGHTS = RecordedFlights("shipped", ("a320_wind_350kt_5000ft", "787_ramps_300kt_15000ft"), 12.0)
SMALL = Campaign(
    "small",
    "",
    3,
    (Variant("umhe_fte"),),
    (FLIGHTS,),
    (
        RunSet("quiet", "shipped", 3, None),
        RunSet("hit", "shipped", 12, MIX),
        RunSet("one", "shipped", 5, replace(MIX, weights=None, sensors=("alpha_2", "vc_1"))),
    ),
)
"""Three sets, so three chunks."""

YAML = """\
campaign: small
seed: 3
sheets: [umhe_fte]
flights:
  shipped: {recorded: [a320_wind_350kt_5000ft, 787_ramps_300kt_15000ft], part: 12}
runs:
"""


def yaml_of(sets: int, runs: int) -> str:
    """The text of a campaign of so many sets (chunks) of runs."""
    line = "  set_{}: {{flights: shipped, count: {}, categories: {{I: 47, II: 22, III: 25, IV: 15}}, onset: [3, 5]}}\n"
    return YAML + "".join(line.format(i, runs) for i in range(sets))
