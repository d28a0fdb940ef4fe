"""Call graphs with stack sizes, as gcc writes them (``-fcallgraph-info=su``, a VCG file)."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

_NODE = re.compile(r'node: \{ title: "([^"]*)" label: "([^"]*)"')
_EDGE = re.compile(r'edge: \{ sourcename: "([^"]*)" targetname: "([^"]*)"')
_STACK = re.compile(r"(\d+) bytes \(([^)]*)\)")


@dataclass(slots=True)
class Node:
    """A function: its stack in bytes (None: defined elsewhere), how gcc knows it (``static``), and what it calls."""

    name: str
    bytes: int | None
    kind: str
    calls: list[str]


def read_call_graph(text: str) -> dict[str, Node]:
    """The functions of a file by name."""
    graph: dict[str, Node] = {}
    for title, label in _NODE.findall(text):
        size = _STACK.search(label)
        name = _plain(title)
        graph[name] = Node(name, int(size[1]) if size else None, size[2] if size else "", [])
    for source, target in _EDGE.findall(text):
        graph[_plain(source)].calls.append(_plain(target))
    return graph


def _plain(title: str) -> str:
    """A static function's title is ``file.c:name``."""
    return title.rpartition(":")[2]


def recursive(graph: Mapping[str, Node]) -> list[str]:
    """A chain of calls that comes back to its first function; empty when there is none."""
    done: set[str] = set()

    def visit(name: str, path: list[str]) -> list[str]:
        if name in path:
            return [*path[path.index(name) :], name]
        if name in done:
            return []
        for called in graph[name].calls if name in graph else []:
            if loop := visit(called, [*path, name]):
                return loop
        done.add(name)
        return []

    return next((loop for name in graph if (loop := visit(name, []))), [])


def deepest(graph: Mapping[str, Node], name: str) -> int:
    """Bytes of stack from a function down its deepest chain of calls; 0 for one defined elsewhere. No recursion allowed."""
    known: dict[str, int] = {}

    def visit(at: str) -> int:
        if at not in known:
            node = graph.get(at)
            known[at] = (node.bytes or 0) + max(map(visit, node.calls), default=0) if node else 0
        return known[at]

    return visit(name)
