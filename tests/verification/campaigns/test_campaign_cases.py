"""The runs of a campaign: their numbers, shares and ranges, and that nothing of one depends on another."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import asdict, replace

import numpy as np
import pytest
from small_campaign import FLIGHTS, MIX, SMALL

from verification.campaigns.cases import MOST_FRAMES, MOST_RUNS, Cases, category_of, duration_of, part_of
from verification.campaigns.plan import DrawnFlights, RecordedFlights, RunSet, Variant
from verification.campaigns.reader import load_campaign
from verification.campaigns.readings import stacked_readings
from verification.campaigns.row import NAN, Row
from verification.campaigns.work import _flight, fly_chunk
from verification.flights import KINDS, TABLE_II, sensors


def faulty(name: str):
    cases = Cases(load_campaign(name))
    return [case for case in (cases.case(i) for i in range(len(cases))) if case.runs.faults is not None]


def test_the_shipped_campaign_has_the_papers_shares():
    runs = faulty("table_iv")
    assert Counter(case.category for case in runs) == {"I": 47, "II": 22, "III": 25, "IV": 15}
    cases = Cases(load_campaign("table_iv"))
    assert sum(not cases.case(i).category for i in range(len(cases))) == 140 + 21
    for sensor in ("alpha", "vc"):
        kinds = Counter(f.kind for case in runs for f in case.faults if f.sensor == sensor)
        # equally often before those runs are left out in which the sensor is healthy
        assert set(kinds) == set(KINDS)
        assert max(kinds.values()) - min(kinds.values()) <= 8


def test_the_category_is_that_of_table_i():
    for case in faulty("table_iv"):
        hit = {f.sensor: len(f.which) for f in case.faults}
        all_alpha, all_vc = hit.get("alpha", 0) == 3, hit.get("vc", 0) == 3
        assert hit
        assert case.category == {(0, 0): "I", (1, 0): "II", (0, 1): "III", (1, 1): "IV"}[all_alpha, all_vc]
    assert [category_of(2, 2), category_of(3, 0), category_of(0, 3), category_of(3, 3)] == ["I", "II", "III", "IV"]


def test_faults_lie_in_table_ii_log_uniformly():
    levels = {(kind, sensor, field): (low, high) for kind, sensor, field, low, high in TABLE_II}
    shares = []
    for case in faulty("monte_carlo")[:1500]:
        for fault in case.faults:
            assert 10.0 <= fault.onset <= 30.0
            for field in ("amplitude", "rate", "frequency"):
                value = getattr(fault, field)
                assert (value is None) == ((fault.kind, fault.sensor, field) not in levels)
                if value is not None:
                    low, high = levels[fault.kind, fault.sensor, field]
                    assert low * 0.999999 <= abs(value) <= high * 1.000001
                    shares += [np.log(abs(value) / low) / np.log(high / low)] if high > low else []
    counts, _ = np.histogram(shares, bins=10, range=(0.0, 1.0))
    # chi-square with 9 degrees of freedom: 27.9 is exceeded once in a thousand
    assert float(((counts - len(shares) / 10) ** 2 / (len(shares) / 10)).sum()) < 27.9


def test_a_run_does_not_depend_on_other_sets_or_sheets():
    more = replace(SMALL, sheets=(Variant("cmhe_fte"), *SMALL.sheets))
    ours, theirs = Cases(SMALL), Cases(more)
    assert len(theirs) == 2 * len(ours) == 40
    for i in (0, 7, 19):
        assert replace(theirs.case(20 + i), number=i) == ours.case(i)
        assert replace(theirs.case(i), variant=Variant("umhe_fte")) == ours.case(i)


def test_all_runs_lie_in_one_chunk_each():
    for name in ("table_iv", "monte_carlo"):
        cases = Cases(load_campaign(name))
        numbers = [i for chunk in cases.chunks for i in range(chunk.first, chunk.stop)]
        assert numbers == list(range(len(cases)))
        assert [chunk.number for chunk in cases.chunks] == list(range(len(cases.chunks)))
        for chunk in cases.chunks:
            runs = {cases.case(i).runs.name for i in (chunk.first, chunk.stop - 1)}
            longest = max(
                cases.frames_about(cases.case(i).runs, cases.case(i).index) for i in (chunk.first, chunk.stop - 1)
            )
            assert len(runs) == 1 and len(chunk) <= MOST_RUNS
            assert len(chunk) * longest <= MOST_FRAMES or len(chunk) <= 8


def test_lengths_are_log_uniform_and_in_order():
    flights = load_campaign("table_iv").flight_set("inside")
    assert isinstance(flights, DrawnFlights)
    lengths = np.array([duration_of(flights, i) for i in range(flights.count)])
    assert (np.diff(lengths) >= 0.0).all() and lengths[0] >= 60.0 and lengths[-1] <= 700.0
    np.testing.assert_allclose(np.median(lengths), np.sqrt(60.0 * 700.0), rtol=0.02)


def test_every_flight_is_flown():
    cases = Cases(load_campaign("table_iv"))
    flown = Counter(cases.case(i).flight for i in range(140))
    assert flown == Counter(range(140))
    assert len({case.flight for case in faulty("table_iv")}) == 109


def test_a_part_lies_in_its_recording():
    flights = RecordedFlights("x", ("y",), 48.0)
    assert part_of(flights, 1001, 0.0) == (0, 1000)
    assert part_of(flights, 1001, 0.99) == (1, 1000)
    assert part_of(flights, 1001, 1.0) == (1, 1000)
    assert part_of(flights, 400, 0.5) == (0, 400)
    assert part_of(replace(flights, part=None), 400, 0.5) == (0, 400)


def test_readings_are_those_of_sensors():
    cases = Cases(SMALL)
    flights = [_flight(SMALL, cases.case(i)) for i in (1, 5, 9, 16)]
    short = replace(flights[0], truth=flights[0].truth.part(0.0, 6.0))
    inputs = stacked_readings([*flights, short])
    for i, flight in enumerate([*flights, short]):
        expected = sensors(flight.truth, flight.case.seed, faults=flight.case.faults).inputs()
        n = len(flight.truth)
        for name, column in expected.items():
            np.testing.assert_array_equal(inputs[name][i, :n], column)
            assert (inputs[name][i, n:] == column[-1]).all()


def test_rows_do_not_depend_on_chunk_or_backend():
    cases = Cases(replace(SMALL, runs=(RunSet("hit", "shipped", 3, MIX),), flights=(replace(FLIGHTS, part=6.0),)))
    (chunk,) = cases.chunks
    together = fly_chunk(cases.campaign, chunk)
    alone = [fly_chunk(cases.campaign, replace(chunk, first=i, stop=i + 1))[0] for i in range(3)]
    interpreted = fly_chunk(cases.campaign, chunk, "interpreter")
    assert exact(together) == exact(alone) == exact(interpreted)
    assert not any(row.failure for row in together)


def exact(rows: list[Row]) -> str:
    """Every bit of the rows, NaN equal to NaN."""
    return json.dumps([{k: v.hex() if isinstance(v, float) else v for k, v in asdict(row).items()} for row in rows])


@pytest.mark.parametrize("number", range(3))
def test_the_row_says_what_was_flown(number: int):
    cases = Cases(SMALL)
    case = cases.case(3 + number)
    (row,) = fly_chunk(SMALL, replace(cases.chunks[1], first=3 + number, stop=4 + number))
    assert (row.run, row.category, row.frames) == (3 + number, case.category, 250)
    for fault in case.faults:
        assert row.hit(fault.sensor) == fault.which
        assert row.onset(fault.sensor) == fault.onset_frame(0.048)
    assert row.failure == "" and row.alpha_error_max >= row.alpha_error_mean > 0.0
    assert row.wind_x != NAN
