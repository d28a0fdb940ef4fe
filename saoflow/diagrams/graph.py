"""The netlist as a networkx graph, for users who want to walk it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from saoflow.diagrams.netlist import POISON, Body, Netlist

if TYPE_CHECKING:
    import networkx as nx


def netlist_graph(netlist: Netlist) -> nx.MultiDiGraph:
    """A node per input, output and symbol instance (by path), an edge per connected port.

    Nodes carry ``symbol``, ``position`` and ``type``; edges ``port``, ``type`` and ``feeds_through``.
    """
    import networkx as nx

    graph = nx.MultiDiGraph(name=netlist.root.structure.sheet)
    sources: dict[int, str] = {}
    for port in netlist.root.structure.inputs:
        graph.add_node(port.name, symbol="input", position=port.position, type=netlist.root.types[port.wire])
        sources[port.wire] = port.name
    outputs = _add_body(graph, netlist.root, "", sources)
    for out in netlist.root.structure.outputs:
        name = f"output {out.name}"
        graph.add_node(name, symbol="output", position=out.position, type=netlist.root.types[out.wire])
        graph.add_edge(outputs[out.wire], name, port=0, type=netlist.root.types[out.wire], feeds_through=True)
    return graph


def _add_body(graph: nx.MultiDiGraph, body: Body, prefix: str, sources: dict[int, str]) -> dict[int, str]:
    """Add the nodes of a body; returns which graph node drives each wire of it."""
    drivers = dict(sources)
    for node in body.nodes:
        if node.symbol is not None:
            path = prefix + node.path
            drivers[node.outputs[0]] = path
            graph.add_node(path, symbol=node.symbol.name, position=node.position, type=body.types[node.outputs[0]])
    pending = [i for i, node in enumerate(body.nodes) if node.symbol is None]
    while pending:
        later = []
        for i in pending:
            node, child = body.nodes[i], body.children[i]
            assert child is not None
            if any(w is not None and w not in drivers for w in node.inputs):
                later.append(i)
                continue
            inner_sources = {
                p.wire: drivers[w] for p, w in zip(child.structure.inputs, node.inputs, strict=True) if w is not None
            }
            inner = _add_body(graph, child, f"{prefix}{node.path}.", inner_sources)
            for port, wire in zip(child.structure.outputs, node.outputs, strict=True):
                drivers[wire] = inner[port.wire]
        if len(later) == len(pending):
            break
        pending = later
    for node in body.nodes:
        if node.symbol is None:
            continue
        for number, source in enumerate(node.inputs):
            if source is not None and source != POISON:
                graph.add_edge(
                    drivers[source],
                    prefix + node.path,
                    port=number,
                    type=body.types[source],
                    feeds_through=node.symbol.feeds_through,
                )
    return drivers
