"""The accept corpus: small sheets, each with a recording of inputs and of the outputs calculated by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from saoflow import DiagnosisError, load
from saoflow.blocks.library import SYMBOLS
from saoflow.diagrams.netlist import flat_nodes
from saoflow.recordings import column_names, read_frames, read_table

GOOD = Path(__file__).parent / "sheets" / "good"
SHEETS = sorted([*GOOD.glob("*.yaml"), *GOOD.glob("*/main.yaml")])


def name_of(path: Path) -> str:
    return str(path.relative_to(GOOD).with_suffix(""))


@pytest.mark.parametrize("path", SHEETS, ids=name_of)
@pytest.mark.parametrize("way", ["one flight", "batch", "binary32"])
def test_outputs_are_those_calculated_by_hand(path: Path, way: str) -> None:
    sheet = load(str(path))
    recording = path.with_suffix(".csv")
    frames = read_frames(recording, sheet.input_types)
    simulator = sheet.simulator(real=32 if way == "binary32" else 64)
    inputs = {name: np.stack([array, array]) if way == "batch" else array for name, array in frames.inputs.items()}
    outputs = simulator.run(inputs)
    for name, wire in sheet.output_types.items():
        columns = column_names(name, wire.shape)
        table = read_table(recording, columns)
        expected = np.stack([table[column] for column in columns], axis=-1)
        found = outputs[name][1] if way == "batch" else outputs[name]
        tolerance = 1e-6 if way == "binary32" else 1e-14
        np.testing.assert_allclose(found.reshape(expected.shape), expected, rtol=tolerance, atol=tolerance)


def test_the_corpus_uses_every_symbol() -> None:
    used = {
        node.symbol.name for path in SHEETS for _, node, _ in flat_nodes(load(str(path)).netlist.root) if node.symbol
    }
    assert used == set(SYMBOLS)


def test_parameters_from_python_are_checked_all_at_once() -> None:
    path = str(GOOD / "first_order_lag.yaml")
    for value in (0.25, "1/4", np.float32(0.25)):
        assert load(path, {"gain": value}).simulator().run({"u": [1.0]})["y"].tolist() == [0.25]
    given = {"gain": np.nan, "a": None, "b": [[1, 2], [3]], "c": "1/0", "d": object(), "e": [], "f": 10**400}
    with pytest.raises(DiagnosisError) as caught:
        load(path, given)
    assert [d.code for d in caught.value.diagnoses] == ["E603", "E603", "E603", "E209", "E603", "E603", "E603"]
    with pytest.raises(DiagnosisError, match="did you mean `gain`"):
        load(path, {"gian": 1}).check()
