"""Strongly connected components, without recursion, in time proportional to nodes and edges."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence


def is_loop(component: Sequence[int], neighbours: Callable[[int], Sequence[int]]) -> bool:
    """Whether a strong component is a loop: several nodes, or one that is its own neighbour."""
    return len(component) > 1 or component[0] in neighbours(component[0])


def strong_components(nodes: Iterable[int], neighbours: Callable[[int], Sequence[int]]) -> Iterator[list[int]]:
    """Tarjan's algorithm with an explicit stack; components come in reverse topological order of ``neighbours``."""
    number: dict[int, int] = {}
    low: dict[int, int] = {}
    on_stack: set[int] = set()
    stack: list[int] = []
    for root in nodes:
        if root in number:
            continue
        work: list[tuple[int, Iterator[int]]] = [(root, iter(neighbours(root)))]
        number[root] = low[root] = len(number)
        stack.append(root)
        on_stack.add(root)
        while work:
            node, rest = work[-1]
            following = next(rest, None)
            if following is not None:
                if following not in number:
                    number[following] = low[following] = len(number)
                    stack.append(following)
                    on_stack.add(following)
                    work.append((following, iter(neighbours(following))))
                elif following in on_stack:
                    low[node] = min(low[node], number[following])
                continue
            work.pop()
            if work:
                parent = work[-1][0]
                low[parent] = min(low[parent], low[node])
            if low[node] == number[node]:
                component = []
                while True:
                    member = stack.pop()
                    on_stack.discard(member)
                    component.append(member)
                    if member == node:
                        break
                yield component
