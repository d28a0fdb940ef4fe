"""`saoflow schema`: fresh, complete, accepts every sheet that can be read and refuses mutated ones; judged by jsonschema."""

from __future__ import annotations

import json
import re
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml

import verification.campaigns
from saoflow import DiagnosisError, cli
from saoflow.authoring.schema import schema, schema_text
from saoflow.blocks.library import SYMBOLS
from saoflow.diagrams import reader, reader_ports
from saoflow.diagrams.store import SHIPPED
from verification.campaigns import reader as campaign_reader
from verification.campaigns import reader_faults

ROOT = Path(__file__).parents[2]
SHEET_FILE = SHIPPED / "sheet.schema.json"
CAMPAIGNS = Path(verification.campaigns.__file__).parent
CAMPAIGN_FILE = CAMPAIGNS / "campaign.schema.json"
SHEETS = sorted([*SHIPPED.glob("*/*.yaml"), *(ROOT / "tests/sheets/good").glob("**/*.yaml")])


class Yaml12(yaml.SafeLoader):
    """YAML 1.2's core schema, as editors read it: ``no`` is text, ``1e-3`` a number."""

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012


Yaml12.add_implicit_resolver("tag:yaml.org,2002:bool", re.compile("^(?:true|false)$"), list("tf"))
Yaml12.add_implicit_resolver("tag:yaml.org,2002:null", re.compile("^(?:~|null|)$"), ["~", "n", ""])
Yaml12.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"^[-+]?(?:\.\d+|\d+(?:\.\d*)?)(?:[eE][-+]?\d+)?$"), list("-+.0123456789")
)
Yaml12.add_constructor(
    "tag:yaml.org,2002:float", lambda _, n: int(n.value) if re.fullmatch(r"[-+]?\d+", n.value) else float(n.value)
)


@cache
def validator(kind: str) -> jsonschema.Draft202012Validator:
    return jsonschema.Draft202012Validator(schema(kind))


def errors(kind: str, text: str) -> list[str]:
    """What jsonschema finds in a text."""
    return [f"{list(e.absolute_path)}: {e.message}" for e in validator(kind).iter_errors(yaml.load(text, Yaml12))]


def test_the_schemas_are_schemas_and_the_files_are_fresh() -> None:
    for kind, file in (("sheet", SHEET_FILE), ("campaign", CAMPAIGN_FILE)):
        jsonschema.Draft202012Validator.check_schema(schema(kind))
        assert file.read_text(encoding="utf-8") == schema_text(kind), f"saoflow schema {kind} -o {file.relative_to(ROOT)}"


@pytest.mark.parametrize("folder", sorted({path.parent for path in SHEETS}), ids=lambda path: path.name)
def test_every_good_sheet_is_accepted(folder: Path) -> None:
    for path in SHEETS:
        if path.parent == folder:
            assert errors("sheet", path.read_text(encoding="utf-8")) == [], path


def test_every_campaign_is_accepted() -> None:
    files = [*(CAMPAIGNS / "shipped").glob("*.yaml"), ROOT / "saoflow/authoring/templates/campaign.yaml"]
    for path in files:
        assert errors("campaign", path.read_text(encoding="utf-8")) == [], path


def test_the_keys_are_those_of_the_readers() -> None:
    found = schema("sheet")
    assert tuple(found["properties"]) == reader._KEYS
    assert set(found["properties"]["budget"]["properties"]) == {"operations", "period", *reader.BUDGET_KINDS}
    parts = found["$defs"]
    assert tuple(parts["parameter"]["anyOf"][2]["properties"]) == ("value", "inherited", "unit", "range", "doc", "source")
    assert set(parts["parameter"]["anyOf"][2]["properties"]) == set(reader_ports._PARAMETER_KEYS)
    assert set(parts["input"]["properties"]) == set(reader_ports._INPUT_KEYS)
    assert set(parts["output"]["anyOf"][2]["properties"]) == set(reader_ports._OUTPUT_KEYS)
    for symbol in SYMBOLS.values():
        keys = set(parts[f"symbol {symbol.name}"]["properties"])
        assert keys >= {symbol.name, "doc", *(p.name for p in symbol.ports), *(p.name for p in symbol.parameters)}
    campaign = schema("campaign")["properties"]
    assert tuple(campaign) == campaign_reader._KEYS
    drawn, recorded = (part["properties"] for part in campaign["flights"]["additionalProperties"]["anyOf"])
    assert tuple(drawn) == campaign_reader._DRAWN and tuple(recorded) == campaign_reader._RECORDED
    runs = campaign["runs"]["additionalProperties"]["properties"]
    assert set(runs) == {"flights", "count", *reader_faults.FAULT_KEYS}


GOOD = """\
sheet: s
profile: sao
parameters: {k: {value: 2, unit: kt, source: chosen}, n: inherited, m: [[1, 2], [3, 4]]}
inputs: {u: {shape: [3], unit: kt, type: real}, p: {type: boolean}, q: }
blocks:
  a: {add: [u, -u]}
  b: {lookup: q, breakpoints: [0, 1], values: [0, 1], interpolation: hold}
  c: {divide: {a: q, b: k}, every: 2, transition: hold}
  d: {fold: stage, count: 3, order: reverse, carry: {x: q}, gain: 2}
  e: {saturation: q, low: 0, high: 1}
  f: {mul: [u, u], product: matrix, symmetric: true}
outputs: {y: {from: "a[0]", unit: kt}, z: b}
budget: {operations: 10, period: 0.1}
"""


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("sheet: s\n", ""),
        ("sheet: s", "sheet: my-sheet"),
        ("profile: sao", "profile: seven"),
        ("budget:", "bugdet:"),
        ("operations: 10", "operation: 10"),
        ("source: chosen", "sorce: chosen"),
        ("unit: kt, type", "units: kt, type"),
        ("type: boolean", "type: bool"),
        ("from:", "form:"),
        ("{y: ", "{1y: "),
        ("outputs: {y: {from: \"a[0]\", unit: kt}, z: b}", "outputs: []"),
        ("a: {add: [u, -u]}", "a: {}"),
        ("a: {add: [u, -u]}", "a: {doc: nothing}"),
        ("a: {add: [u, -u]}", "a: add"),
        ("a: {add: [u, -u]}", "a: {add: [u, -u], product: matrix}"),
        ("a: {add: [u, -u]}", "a: {add: []}"),
        ("a: {add: [u, -u]}", "a: {add: [u], mul: [u]}"),
        ("a: {add: [u, -u]}", "a: {delay: [u, p]}"),
        ("a: {add: [u, -u]}", "a: {compare: [u], relation: '>'}"),
        ("a: {add: [u, -u]}", "a: {compare: [u, 1], relation: above}"),
        ("a: {add: [u, -u]}", "a: {switch: {condition: p, a: u, c: u}}"),
        ("product: matrix", "product: matirx"),
        ("interpolation: hold", "interpolate: hold"),
        (", transition: hold", ""),
        ("transition: hold", "transition: keep"),
        ("every: 2", "offset: 1"),
        ("count: 3, ", ""),
        ("order: reverse", "order: backward"),
        ("carry: {x: q}", "carry: [q]"),
        ("gain: 2}", "gain: 2, every: 2}"),
    ],
)
def test_a_mutated_sheet_is_refused(old: str, new: str) -> None:
    assert errors("sheet", GOOD) == []
    assert old in GOOD and errors("sheet", GOOD.replace(old, new, 1)), new


CAMPAIGN = """\
campaign: few
seed: 1
sheets: [cmhe_fte, {sheet: cmhe_fte, set: {n_QP: 3}}]
flights: {calm: {recorded: [a320_calm_350kt_5000ft], part: 60}, drawn: {drawn: 4, wind: inside, duration: [60, 70]}}
runs: {a: {flights: calm, count: 4}, b: {flights: drawn, count: 4, categories: {I: 1}, kinds: [bias], onset: [10, 30]}}
"""


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("campaign: few\n", ""), ("seed: 1", "seed: -1"), ("part: 60", "part: 2"), ("wind: inside", "wind: calm"),
        ("drawn: 4", "drawn: 0"), ("count: 4", "count: 4.5"), ("kinds: [bias]", "kinds: [bais]"), ("{I: 1}", "{V: 1}"),
        ("set: {n_QP: 3}", "sets: {n_QP: 3}"), ("onset: [10, 30]", "onset: [10]"), (", count: 4}, b", "}, b"),
        ("kinds: [bias]", "sensors: [vc_1]"), ("duration: [60, 70]", "duration: [6, 70]"),
    ],
)  # fmt: skip
def test_a_mutated_campaign_is_refused(tmp_path: Path, old: str, new: str) -> None:
    assert errors("campaign", CAMPAIGN) == []
    mutated = CAMPAIGN.replace(old, new, 1)
    assert errors("campaign", mutated), new
    (tmp_path / "few.yaml").write_text(mutated)  # and the reader agrees
    with pytest.raises(DiagnosisError):
        campaign_reader.read_campaign(tmp_path / "few.yaml")


def test_what_the_symbols_examples_write_is_accepted() -> None:
    from saoflow.symbol_catalogue import EXAMPLE

    for symbol in SYMBOLS.values():
        for example in symbol.examples:
            assert errors("sheet", EXAMPLE.format(block=example)) == [], example


def test_the_command_prints_writes_and_refuses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["schema"]) == 0
    assert json.loads(capsys.readouterr().out) == schema("sheet")
    assert cli.run(["schema", "campaign", "-o", str(tmp_path / "c.json")]) == 0
    assert json.loads((tmp_path / "c.json").read_text()) == schema("campaign")
    assert cli.run(["schema", "shet"]) == 2
    assert "did you mean `sheet`?" in capsys.readouterr().err
    assert cli.run(["schema", "-o", str(tmp_path / "nowhere" / "s.json")]) == 2
    assert "error[E601]" in capsys.readouterr().err


def test_shipped_files_name_their_schema_in_the_first_line() -> None:
    for path in [*SHIPPED.glob("*/*.yaml"), *(CAMPAIGNS / "shipped").glob("*.yaml")]:
        first = path.read_text(encoding="utf-8").split("\n")[0]
        found = re.fullmatch(r"# yaml-language-server: \$schema=(\S+)", first)
        assert found is not None, f"{path} lacks the modeline: # yaml-language-server: $schema=../sheet.schema.json"
        assert (path.parent / found[1]).resolve() in (SHEET_FILE, CAMPAIGN_FILE), path
