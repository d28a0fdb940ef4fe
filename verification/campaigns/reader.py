"""Reading a campaign file, with every mistake that can be seen.

    campaign: NAME                       # required
    doc: TEXT
    seed: 1                              # of everything that is drawn for the runs
    sheets: [cmhe_fte, {sheet: cmhe_fte, set: {n_QP: 3}}]                # required: shipped names or paths
    flights:                             # required: sets of flights by name
      SET: {drawn: 140, seed: 1, wind: inside | beyond, duration: [60, 700], aircraft: [A320, 787-8],
            cas: [190, 350], altitude: [3000, 36000]}
      SET: {recorded: [NAME or PATH, ...], part: 60}
    runs:                                # required: sets of runs by name
      SET: {flights: SET, count: 140}                                    # fault-free
      SET: {flights: SET, count: 109, categories: {I: 47, II: 22, III: 25, IV: 15},   # or sensors: [alpha_1, vc_3]
            kinds: [bias, ...], onset: [10, 30], ranges: {bias: {alpha: {amplitude: [0.5, 25]}}}}

Lengths in s, speeds in kt, heights in ft; ranges of faults in deg, kt, deg/s, kt/s, Hz. Paths are relative to the file.
"""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from saoflow.diagnosis import did_you_mean, refusal
from saoflow.diagrams.store import SheetStore
from saoflow.yaml_document import Document, Mapping, Node, Scalar, Sequence, open_document, short
from verification.campaigns import values
from verification.campaigns.plan import (
    BEYOND,
    INSIDE,
    Campaign,
    DrawnFlights,
    FlightSet,
    Range,
    RecordedFlights,
    RunSet,
    Variant,
)
from verification.campaigns.reader_faults import FAULT_KEYS, read_faults
from verification.flights import AIRCRAFT
from verification.recordings import shipped_recordings

SHIPPED = Path(__file__).parent / "shipped"
_KEYS = ("campaign", "doc", "seed", "sheets", "flights", "runs")
_DRAWN = ("drawn", "seed", "wind", "duration", "aircraft", "cas", "altitude")
_RECORDED = ("recorded", "part")
_RUNS = ("flights", "count", *FAULT_KEYS)
MOST_SEED = 2**31 - 1


def shipped_campaigns() -> tuple[str, ...]:
    """Names of the shipped campaigns, sorted."""
    return tuple(sorted(path.stem for path in SHIPPED.glob("*.yaml")))


def load_campaign(name: str) -> Campaign:
    """The campaign in a file, or the shipped one of that name. Raises DiagnosisError E1xx, E801, E803."""
    if name in shipped_campaigns() and not Path(name).exists():
        return read_campaign(SHIPPED / f"{name}.yaml")
    if Path(name).suffix in (".yaml", ".yml") or Path(name).exists():
        return read_campaign(name)
    known = shipped_campaigns()
    raise refusal(
        "E803",
        f"there is no campaign `{name}`",
        cause="it is neither a path to a YAML file nor the name of a shipped campaign",
        remedy=did_you_mean(name, known) or f"shipped campaigns: {', '.join(known)}",
    )


def read_campaign(path: str | os.PathLike[str]) -> Campaign:
    """The campaign in a file. Raises DiagnosisError with everything that is wrong with it."""
    document = open_document(path, "a campaign", "`campaign: NAME`")
    campaign = _campaign(document)
    document.raise_if_wrong()
    assert campaign is not None
    return campaign


def _campaign(document: Document) -> Campaign | None:
    name, doc, seed = "", "", 1
    sheets: tuple[Variant, ...] = ()
    flights: tuple[FlightSet, ...] = ()
    runs_node: Node | None = None
    for key, node in document.root.entries:
        match key.value:
            case "campaign":
                found = document.name(node, "a campaign")
                name = found.text if found is not None else ""
            case "doc":
                doc = document.word(node, "`doc`") or ""
            case "seed":
                seed = values.whole(document, node, "`seed`", 0, MOST_SEED) or 0
            case "sheets":
                sheets = _sheets(document, node)
            case "flights":
                flights = _flight_sets(document, node)
            case "runs":
                runs_node = node
            case _:
                document.unknown_key(key, "a campaign", _KEYS)
    for required, remedy in (
        ("campaign", "add `campaign: NAME`"),
        ("sheets", "add `sheets: [cmhe_fte]`"),
        ("flights", "add `flights:` with sets by name"),
        ("runs", "add `runs:` with sets by name"),
    ):
        if required not in document.root.keys:
            document.missing(document.root, required, f"every campaign has the key `{required}`", remedy)
        elif _nothing(document, required):
            key = document.root.keys[required]
            document.report("E108", f"`{required}` is empty", key, "nothing stands there", remedy)
    named = _names(document, "flights")
    runs = () if runs_node is None else _run_sets(document, runs_node, named, {f.name: f for f in flights})
    return Campaign(name, doc, seed, sheets, flights, runs) if name and sheets and flights and runs else None


def _nothing(document: Document, key: str) -> bool:
    """Whether a key holds an empty list or mapping, or nothing at all."""
    node = next(node for found, node in document.root.entries if found.value == key)
    if type(node) is Scalar:
        return node.nothing
    return not (node.entries if type(node) is Mapping else node.items)


def _names(document: Document, key: str) -> tuple[str, ...]:
    """Names of the sets below a key, right or wrong in themselves."""
    for found, node in document.root.entries:
        if found.value == key and type(node) is Mapping:
            return tuple(name.value for name, _ in node.entries)
    return ()


def _beside(document: Document, text: str, suffixes: tuple[str, ...]) -> str:
    """A path of the file as this process finds it; anything else stays."""
    if not text.endswith(suffixes) or os.path.isabs(text):
        return text
    return str(Path(document.source.file).parent / text)


# -- sheets


def _sheets(document: Document, node: Node) -> tuple[Variant, ...]:
    found: list[Variant] = []
    for item in values.items(document, node, "`sheets`"):
        variant = _variant(document, item)
        if variant is None:
            continue
        if variant in found:
            document.report("E105", f"`{variant.label}` is named twice", item, "every sheet flies once", "remove one")
        else:
            found.append(variant)
    return tuple(found)


def _variant(document: Document, node: Node) -> Variant | None:
    if type(node) is Scalar:
        return Variant(_sheet_path(document, node))
    sheet = ""
    settings: dict[str, str] = {}
    for key, value in document.entries(node, "a sheet", "write `sheet: NAME`, `set: {n_QP: 3}`"):
        if key.value == "sheet" and type(value) is Scalar and not value.nothing:
            sheet = _sheet_path(document, value)
        elif key.value == "set":
            settings = _settings(document, value)
        elif key.value == "sheet":
            document.wrong_kind(value, "`sheet`", "a name or a path", "name a sheet")
        else:
            document.unknown_key(key, "a sheet of a campaign", ("sheet", "set"))
    if type(node) is Mapping and "sheet" not in node.keys:
        document.missing(node, "sheet", "it says which sheet flies", "add `sheet: cmhe_fte`")
    return Variant(sheet, tuple(settings.items())) if sheet else None


def _sheet_path(document: Document, node: Scalar) -> str:
    """A path or a shipped name; what is wrong inside the sheet, loading it will say."""
    path = _beside(document, node.value, (".yaml", ".yml"))
    known = SheetStore().shipped
    if path not in known and not Path(path).exists():
        document.report(
            "E602",
            f"there is no sheet `{short(node.value)}`",
            node,
            "it is neither a path to a YAML file nor the name of a shipped sheet",
            did_you_mean(node.value, known) or "name one with the ports of cmhe_fte",
        )
    return path


def _settings(document: Document, node: Node) -> dict[str, str]:
    found: dict[str, str] = {}
    for key, value in document.entries(node, "`set`", "write `set: {n_QP: 3}`"):
        if type(value) is Scalar and not value.nothing:
            found[key.value] = value.value
        else:
            document.wrong_kind(value, f"`{key.value}`", "a number or an expression", "write a value")
    return found


# -- flights


def _flight_sets(document: Document, node: Node) -> tuple[FlightSet, ...]:
    found: list[FlightSet] = []
    for key, value in document.entries(node, "`flights`", "write `NAME: {drawn: 10}` or `NAME: {recorded: [...]}`"):
        name = document.name(key, "a set of flights")
        if type(value) is not Mapping:
            document.wrong_kind(
                value, f"`{key.value}`", "`key: value` entries", "write {drawn: 10} or {recorded: [...]}"
            )
        elif "recorded" in value.keys:
            recorded = _recorded(document, key.value, value)
            found += [recorded] if name is not None and recorded is not None else []
        elif "drawn" in value.keys:
            drawn = _drawn(document, key.value, value)
            found += [drawn] if name is not None and drawn is not None else []
        else:
            wrong = [word for word, _ in value.entries if word.value not in (*_DRAWN, *_RECORDED)]
            for word in wrong:
                document.unknown_key(word, "a set of flights", (*_DRAWN, *_RECORDED))
            if wrong:
                continue
            document.missing(
                value, "drawn", "flights are `drawn` or `recorded`", "add `drawn: 10` or `recorded: [NAME]`"
            )
    return tuple(found)


def _recorded(document: Document, name: str, node: Mapping) -> RecordedFlights | None:
    recordings: list[str] = []
    part: float | None = None
    for key, value in node.entries:
        if key.value == "recorded":
            for item in values.items(document, value, "`recorded`"):
                if type(item) is Scalar and not item.nothing:
                    recordings += _recording(document, item)
                else:
                    document.wrong_kind(item, "a recording", "a name or a path", "name a recording")
            if type(value) is Sequence and not value.items:
                document.report("E108", "`recorded` is empty", key, "a set has a flight at least", "name a recording")
        elif key.value == "part":
            part = values.number(document, value, "`part`", 5.0, 3600.0, "s")
        else:
            document.unknown_key(key, "a set of recorded flights", _RECORDED)
    return RecordedFlights(name, tuple(recordings), part) if recordings else None


def _recording(document: Document, node: Scalar) -> list[str]:
    if node.value in shipped_recordings():
        return [node.value]
    path = _beside(document, node.value, (".csv", ".csv.gz", ".parquet"))
    if path.endswith((".csv", ".csv.gz", ".parquet")) and Path(path).is_file():
        return [path]
    values.unknown(document, node, "recordings", shipped_recordings(), "E721")
    return []


def _drawn(document: Document, name: str, node: Mapping) -> DrawnFlights | None:
    found = DrawnFlights(name, 1, 1, AIRCRAFT, Range(60.0, 700.0), Range(190.0, 350.0), Range(3000.0, 36000.0), INSIDE)
    for key, value in node.entries:
        what = f"`{key.value}`"
        match key.value:
            case "drawn":
                found = replace(found, count=values.whole(document, value, what, 1, 100_000) or 1)
            case "seed":
                found = replace(found, seed=values.whole(document, value, what, 0, MOST_SEED) or 0)
            case "wind":
                choice = document.choice(value, "wind", (INSIDE, BEYOND))
                found = replace(found, wind=choice.text if choice else INSIDE)
            case "aircraft":
                found = replace(found, aircraft=values.words(document, value, what, AIRCRAFT, "E702") or AIRCRAFT)
            case "duration":
                found = replace(
                    found, duration=values.interval(document, value, what, 20.0, 3600.0, "s") or found.duration
                )
            case "cas":
                found = replace(found, cas=values.interval(document, value, what, 160.0, 400.0, "kt") or found.cas)
            case "altitude":
                interval = values.interval(document, value, what, 1000.0, 41000.0, "ft")
                found = replace(found, altitude=interval or found.altitude)
            case _:
                document.unknown_key(key, "a set of drawn flights", _DRAWN)
    return found


# -- runs


def _run_sets(
    document: Document, node: Node, named: tuple[str, ...], flights: dict[str, FlightSet]
) -> tuple[RunSet, ...]:
    found = []
    for key, value in document.entries(node, "`runs`", "write `NAME: {flights: SET, count: 10}`"):
        document.name(key, "a set of runs")
        if type(value) is Mapping:
            runs = _runs(document, key.value, value, named, flights)
            found += [runs] if runs is not None else []
        else:
            document.wrong_kind(value, f"`{key.value}`", "`key: value` entries", "write {flights: SET, count: 10}")
    return tuple(found)


def _runs(
    document: Document, name: str, node: Mapping, named: tuple[str, ...], flights: dict[str, FlightSet]
) -> RunSet | None:
    which, count = "", 0
    for key, value in node.entries:
        if key.value == "flights":
            if type(value) is Scalar and value.value in named:
                which = value.value
            elif type(value) is Scalar and not value.nothing:
                values.unknown(document, value, "sets of flights", named)
            else:
                document.wrong_kind(value, "`flights`", "the name of a set of flights", "name one")
        elif key.value == "count":
            count = values.whole(document, value, "`count`", 1) or 0
        elif key.value not in FAULT_KEYS:
            document.unknown_key(key, "a set of runs", _RUNS)
    for required, remedy in (("flights", "name a set of flights"), ("count", "say how many runs: `count: 140`")):
        if required not in node.keys:
            document.missing(node, required, f"every set of runs has the key `{required}`", remedy)
    faults = read_faults(document, node, shortest(flights[which]) if which in flights else 3600.0)
    return RunSet(name, which, count, faults) if which and count else None


def shortest(flights: FlightSet) -> float:
    """The shortest flight of a set [s]; of whole recordings, what any of them has."""
    return flights.duration.low if isinstance(flights, DrawnFlights) else flights.part or 60.0
