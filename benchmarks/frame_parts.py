"""Where the time of the flagship's compiled frame goes: ``python benchmarks/frame_parts.py [--compiler "clang -O2"]``.

The frame is compiled again with something left out, and the difference told: every look-up is replaced by ``u + u``, every
reciprocal by ``a * a``, procedures stay functions or are laid out in place. The last row is the longest chain of operations
that wait for each other, alone: no arrangement of the same operations can be faster than that. (Longest by latencies of 3
for a sum or product, 13 for a reciprocal, 30 for a look-up and 1 for anything else; its time is measured, not added up.)

Variants take turns; medians of processor time; one flight, one core, binary64.
"""

from __future__ import annotations

import argparse
import shlex
import shutil
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

import saoflow
from saoflow.cache import Folder, cache_folder
from saoflow.codegen.compiler import Compiler, compiled
from saoflow.codegen.generate import native_files
from saoflow.codegen.native import NativeSimulator
from saoflow.codegen.objects import Objects
from saoflow.codegen.printer import print_file
from saoflow.operations import Atom, Kind, Tensor
from saoflow.scheduler.program import FrameProgram, Operation, ProgramBody
from verification.flights import load_recording, sensors

LATENCY = {Kind.ADD: 3, Kind.SUBTRACT: 3, Kind.MULTIPLY: 3, Kind.RECIPROCAL: 13, Kind.LOOKUP: 30}
Chain = tuple[int, tuple[Operation, ...]]
"""A latency, and the operations that it adds up from."""


class _Variant(Objects):
    """The objects of a program with procedures in place or not, whatever the compiler's level is."""

    def __init__(self, program: FrameProgram, compiler: Compiler, folder: Folder, placed: bool) -> None:
        Objects.__init__(self, program, compiler, folder, "")
        object.__setattr__(self, "placed", placed)

    def path(self, lanes: int) -> Path:
        """One flight alone is asked for."""
        placed: bool = object.__getattribute__(self, "placed")
        texts = [print_file(file, traced=False).text for file in native_files(self.program, lanes, placed)]
        return compiled(texts, self.compiler, self.folder)


def replaced(program: FrameProgram, change: Callable[[Operation], Operation]) -> FrameProgram:
    """The program with every operation changed."""

    def body(old: ProgramBody) -> ProgramBody:
        return replace(old, operations=tuple(change(op) for op in old.operations))

    procedures = tuple(body(p) for p in program.procedures)
    return replace(program, procedures=procedures, groups=tuple(replace(g, body=body(g.body)) for g in program.groups))


def without(kind: Kind, instead: Kind) -> Callable[[Operation], Operation]:
    """An operation of one operand becomes one of two equal ones."""
    return lambda op: replace(op, kind=instead, operands=op.operands * 2, detail=0) if op.kind is kind else op


def longest(program: FrameProgram, body: ProgramBody, given: tuple[Chain, ...]) -> tuple[tuple[Chain, ...], Chain]:
    """The chains to the results of a body, and the longest of all; procedures are followed."""
    chains: dict[Atom, Chain] = dict(zip(body.parameters, given, strict=True))
    most: Chain = (0, ())
    for op in body.operations:
        before = [chains.get(a, (0, ())) for a in op.operands]
        if op.kind is Kind.CALL:
            results, inner = longest(program, program.procedures[op.detail], tuple(before))
            chains.update(zip(op.results, results, strict=True))
            most = max(most, inner, key=lambda c: c[0])
            continue
        cycles, path = max(before, key=lambda c: c[0], default=(0, ()))
        if op.kind in (Kind.READ, Kind.WRITE):
            here: Chain = (cycles, path)
        else:
            here = (cycles + LATENCY.get(op.kind, 1), (*path, op))
        chains.update(dict.fromkeys(op.results, here))
        most = max(most, here, key=lambda c: c[0])
    return tuple(chains.get(a, (0, ())) for a in body.results), most


def chain_alone(program: FrameProgram, path: tuple[Operation, ...]) -> FrameProgram:
    """A frame that does the operations of a path, each on the last one's result, and gives that out everywhere."""
    (group,) = program.groups
    body = group.body
    last, other = body.parameters[0], body.parameters[1]
    operations: list[Operation] = []
    booleans = list(body.booleans)
    for op in path:
        kind = op.kind if op.kind in LATENCY or op.kind in (Kind.MAXIMUM, Kind.MINIMUM) else Kind.MAXIMUM
        operands = (last,) if kind in (Kind.RECIPROCAL, Kind.LOOKUP) else (last, other)
        booleans.append(False)
        operations.append(Operation(kind, (len(booleans) - 1,), operands, op.detail, 0))
        last = len(booleans) - 1
    results = tuple(last if not port.type.boolean else other for port in program.outputs for _ in range(port.type.size))
    ports = tuple(
        replace(p, type=replace(p.type, boolean=False), tensor=Tensor(p.type.shape, (last,) * p.type.size))
        for p in program.outputs
    )
    alone = replace(body, operations=tuple(operations), booleans=tuple(booleans), results=results)
    return replace(program, groups=(replace(group, body=alone),), procedures=(), states=(), outputs=ports)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--compiler", default="clang -O2")
    parser.add_argument("--frames", type=int, default=2000)
    parser.add_argument("--repeat", type=int, default=15)
    options = parser.parse_args()
    name, *level = shlex.split(options.compiler)
    path = shutil.which(name)
    if path is None:
        sys.exit(f"{name} is missing")
    said = subprocess.run([path, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    compiler = Compiler((path, *level), said)
    program = saoflow.load("cmhe_fte").frame_program
    (group,) = program.groups
    cycles, chain = longest(program, group.body, ((0, ()),) * len(group.body.parameters))[1]
    no_tables, no_reciprocals = without(Kind.LOOKUP, Kind.ADD), without(Kind.RECIPROCAL, Kind.MULTIPLY)
    variants = {
        "the frame": (program, True),
        "procedures as functions": (program, False),
        "without look-ups": (replaced(program, no_tables), True),
        "without reciprocals": (replaced(program, no_reciprocals), True),
        "without either": (replaced(replaced(program, no_tables), no_reciprocals), True),
        f"its longest chain: {len(chain)} operations": (chain_alone(program, chain), False),
    }
    recording = sensors(load_recording("a320_wind_350kt_5000ft"), seed=1).inputs()
    inputs = {p.name: np.resize(recording[p.name], (options.frames, *p.type.shape)) for p in program.inputs}
    runs = {
        text: NativeSimulator(p, _Variant(p, compiler, cache_folder(), placed))
        for text, (p, placed) in variants.items()
    }
    times: dict[str, list[float]] = {text: [] for text in runs}
    for _ in range(options.repeat):
        for text, simulator in runs.items():
            simulator.reset()
            start = time.process_time()
            simulator.run(inputs)
            times[text].append((time.process_time() - start) / options.frames)
    print(f"{compiler.version.splitlines()[0]}: {' '.join((*level, *compiler.flags))}; {cycles} cycles in the longest chain")
    whole = statistics.median(times["the frame"])
    for text, values in times.items():
        print(f"{text:<40}{1e6 * statistics.median(values):7.2f} us{statistics.median(values) / whole:8.2f}")


if __name__ == "__main__":
    main()
