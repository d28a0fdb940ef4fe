"""The drawings against the netlist: walked into everywhere, they connect exactly the symbols that the netlist connects."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import networkx as nx
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

import saoflow
from saoflow.drawing.draw import MOST_SHOWN, draw
from saoflow.drawing.drawing import Drawing, Drawings
from verification.bits.random_sheets import SIDE_SHEETS, sheets


def drawings_of(sheet: saoflow.LoadedSheet) -> Drawings:
    return draw(sheet.schedule, sheet.netlist, sheet.store)


def connected_by_netlist(sheet: saoflow.LoadedSheet) -> set[tuple[str, str]]:
    """Pairs of blocks, inputs and outputs that a wire joins; the wiring of operands and the ports of sheets left out."""
    graph = sheet.graph()
    blocks = {n for n in graph if n.startswith("output ") or not _is_port_or_wiring(n, graph)}
    found = set()
    for block in blocks:
        stack, seen = list(graph.predecessors(block)), set()
        while stack:
            source = stack.pop()
            if source in seen:
                continue
            seen.add(source)
            if source in blocks:
                found.add((source, block))
            else:
                stack.extend(graph.predecessors(source))
    return found


def _is_port_or_wiring(name: str, graph: nx.MultiDiGraph) -> bool:
    node = graph.nodes[name]
    return "#" in name.rpartition(".")[2] or (node["symbol"] == "select" and name in _PORTS)


_PORTS: set[str] = set()


def connected_by_drawings(drawings: Drawings) -> set[tuple[str, str]]:
    """The same pairs, from walking into every block of every drawing."""
    ports: nx.DiGraph = nx.DiGraph()
    symbols: dict[str, str] = {}
    outputs: list[str] = []

    def place(number: int, path: str, outside: dict[int, str] | None) -> list[str]:
        """Add a drawing; ``outside`` holds the ports that feed its inputs. Returns the ports of its outputs."""
        drawing = drawings.drawings[number]
        fed = [f"{path}|in{k}" for k in range(len(drawing.inputs))]
        for k, port in enumerate(fed):
            if outside is None:
                symbols[port] = drawing.inputs[k].name
            elif k in outside:
                ports.add_edge(outside[k], port)
        made = block_ports(drawing, path)
        for k, block in enumerate(drawing.blocks):
            given = [f"{path}|{k}in{n}" for n in range(len(block.inputs))]
            for n, operand in enumerate(block.inputs):
                for source in operand.sources:
                    ports.add_edge(fed[source.port] if source.block < 0 else made[source.block][source.port], given[n])
            if block.kind == "symbol":
                symbols[made[k][0]] = symbols[f"{path}|{k}"] = f"{path}{block.name}"
                for port in given:
                    ports.add_edge(port, f"{path}|{k}")
                ports.add_node(f"{path}|{k}")
            else:
                enter(drawing, k, path, given, made[k])
        shown = []
        for k, terminal in enumerate(drawing.outputs):
            port = f"{path}|out{k}"
            for source in terminal.sources:
                ports.add_edge(fed[source.port] if source.block < 0 else made[source.block][source.port], port)
            shown.append(port)
        if outside is None:
            for terminal, port in zip(drawing.outputs, shown, strict=True):
                symbols[port] = f"output {terminal.name}"
                outputs.append(port)
        return shown

    def enter(drawing: Drawing, k: int, path: str, given: list[str], made: list[str]) -> None:
        block = drawing.blocks[k]
        assert block.inside is not None
        if block.kind == "sheet":
            inner = drawings.drawings[block.inside]
            names = {terminal.name: n for n, terminal in enumerate(inner.inputs)}
            outside = {names[operand.name]: given[n] for n, operand in enumerate(block.inputs)}
            for shown, port in zip(place(block.inside, f"{path}{block.name}.", outside), made, strict=True):
                ports.add_edge(shown, port)
            return
        # A stack: its drawing's inputs are wires of the same body, and so are its instances' outputs.
        stack = drawings.drawings[block.inside]
        by_wire = wires_of(drawing, path)
        outside = {n: by_wire[terminal.wire] for n, terminal in enumerate(stack.inputs)}
        inner_path = f"{path}|stack{k}|"
        place_stack(stack, inner_path, path, outside)
        for n, output in enumerate(block.outputs):
            for wire in output.wires:
                ports.add_edge(wires_of(stack, inner_path)[wire], made[n])

    def place_stack(stack: Drawing, inner_path: str, path: str, outside: dict[int, str]) -> None:
        for n, source in outside.items():
            ports.add_edge(source, f"{inner_path}|in{n}")
        made = block_ports(stack, inner_path)
        for k, block in enumerate(stack.blocks):
            given = [f"{inner_path}|{k}in{n}" for n in range(len(block.inputs))]
            for n, operand in enumerate(block.inputs):
                for source in operand.sources:
                    start = f"{inner_path}|in{source.port}" if source.block < 0 else made[source.block][source.port]
                    ports.add_edge(start, given[n])
            assert block.inside is not None
            inner = drawings.drawings[block.inside]
            names = {terminal.name: n for n, terminal in enumerate(inner.inputs)}
            fed = {names[operand.name]: given[n] for n, operand in enumerate(block.inputs)}
            for shown, port in zip(place(block.inside, f"{path}{block.name}.", fed), made[k], strict=True):
                ports.add_edge(shown, port)

    place(0, "", None)
    found = set()
    ends = [node for node in ports if node in symbols and ("in" not in node.rpartition("|")[2])]
    for end in ends:
        stack, seen = list(ports.predecessors(end)), set()
        while stack:
            port = stack.pop()
            if port in seen:
                continue
            seen.add(port)
            if port in symbols and not port.rpartition("|")[2].isdigit():
                found.add((symbols[port], symbols[end]))
            else:
                stack.extend(ports.predecessors(port))
    return found


def block_ports(drawing: Drawing, path: str) -> list[list[str]]:
    return [[f"{path}|{k}o{n}" for n in range(len(block.outputs))] for k, block in enumerate(drawing.blocks)]


def wires_of(drawing: Drawing, path: str) -> dict[int, str]:
    made = {terminal.wire: f"{path}|in{n}" for n, terminal in enumerate(drawing.inputs)}
    for block, ports in zip(drawing.blocks, block_ports(drawing, path), strict=True):
        for output, port in zip(block.outputs, ports, strict=True):
            made.update(dict.fromkeys((output.wire, *output.wires), port))
    return made


def declared_ports(sheet: saoflow.LoadedSheet) -> Iterator[str]:
    stack = [(sheet.netlist.root, "")]
    while stack:
        body, prefix = stack.pop()
        for node, child in zip(body.nodes, body.children, strict=True):
            if node.declared is not None:
                yield prefix + node.path
            if child is not None:
                stack.append((child, f"{prefix}{node.path}."))


def _of_stacks(pairs: set[tuple[str, str]]) -> set[tuple[str, str]]:
    """Instances by their stack: a slice of a stack (``b[0]``) is drawn as a wire from the stack, with the slice as text."""
    return {(re.sub(r"\[\d+\]", "[]", a), re.sub(r"\[\d+\]", "[]", b)) for a, b in pairs}


def assert_same(sheet: saoflow.LoadedSheet) -> int:
    _PORTS.clear()
    _PORTS.update(declared_ports(sheet))
    expected, found = _of_stacks(connected_by_netlist(sheet)), _of_stacks(connected_by_drawings(drawings_of(sheet)))
    assert found == expected, (sorted(found - expected)[:5], sorted(expected - found)[:5])
    return len(found)


@pytest.mark.parametrize("name", ["umhe_fte", "cmhe_fte_lean"])
def test_the_flagships_are_drawn_as_they_are_wired(name: str) -> None:
    assert assert_same(saoflow.load(name)) > 300


@settings(max_examples=25, deadline=None, phases=[Phase.generate], suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_random_sheets_are_drawn_as_they_are_wired(data: st.DataObject, tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("drawn")
    for name, text in SIDE_SHEETS.items():
        (folder / f"{name}.yaml").write_text(text)
    (folder / "s.yaml").write_text(data.draw(sheets()))
    assert_same(saoflow.load(str(folder / "s.yaml")))


def test_a_long_stack_shows_its_ends(tmp_path: Path) -> None:
    (tmp_path / "lag.yaml").write_text(SIDE_SHEETS["lag"])
    (tmp_path / "chain.yaml").write_text(
        "sheet: chain\ninputs: [x]\nblocks:\n  n: {add: [x, 1]}\n"
        "  c: {fold: half, count: 100, carry: {y: n}}\noutputs: {y: 'c.y[-1]'}\n"
    )
    (tmp_path / "half.yaml").write_text("sheet: half\ninputs: [y]\nblocks:\n  h: {mul: [y, 0.5]}\noutputs: {y: h}\n")
    drawings = drawings_of(saoflow.load(str(tmp_path / "chain.yaml")))
    stack = next(d for d in drawings.drawings if d.kind == "stack")
    assert len(stack.blocks) == MOST_SHOWN and stack.left_out == 100 - MOST_SHOWN
    assert stack.blocks[0].name == "c[0]" and stack.blocks[-1].name == "c[99]"
    block = next(b for b in drawings.drawings[0].blocks if b.kind == "stack")
    assert block.count == 100 and block.inputs[0].carried


def test_signs_numbers_and_slices_stand_at_the_operands(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(
        "sheet: s\nparameters: {g: 2}\ninputs: {v: {shape: [3]}, w: {}}\nblocks:\n"
        "  d: {add: ['v[0]', -w, w]}\n  m: {mul: [d, g/3]}\noutputs: [m]\n"
    )
    first, second = drawings_of(saoflow.load(str(tmp_path / "s.yaml"))).drawings[0].blocks
    assert [(p.name, p.text, [s.block for s in p.sources]) for p in first.inputs] == [
        ("+", "v[0]", [-1]),
        ("−", "", [-1]),
        ("+", "", [-1]),
    ]
    assert [(p.text, len(p.sources)) for p in second.inputs] == [("", 1), ("g/3", 0)]
