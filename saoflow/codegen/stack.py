"""How much stack a frame takes: measured by gcc, else a bound from the program."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path

from saoflow.codegen.interface import Interface
from saoflow.operations import Kind
from saoflow.scheduler.program import FrameProgram, ProgramBody

CALL = 256
"""Bytes allowed for return address, saved registers and alignment of one call."""


def stack_bound(program: FrameProgram, lanes: int = 1) -> int:
    """Bytes that a frame cannot exceed: every value, argument and result of every body on the way in memory."""
    size = program.real // 8 * max(lanes, 1)

    def own(body: ProgramBody) -> int:
        passed = [len(op.operands) + len(op.results) for op in body.operations if op.kind is Kind.CALL]
        given = sum(len(op.results) for op in body.operations if op.kind is Kind.CALL)
        return CALL + size * (body.value_count + given + max(passed, default=0))

    ports = sum(port.type.size for port in (*program.inputs, *program.outputs, *program.probes))
    return _deepest(program, [own(body) for body in program.bodies], CALL) + size * (ports + len(program.states)) + CALL


def measured_stack(program: FrameProgram, face: Interface, folder: Path, level: str) -> int | None:
    """Bytes of the deepest chain of calls from ``step`` as gcc compiles it at ``level`` (-O0, ...); None without gcc."""
    gcc = shutil.which("gcc")
    if gcc is None:
        return None
    with tempfile.TemporaryDirectory() as work:
        target = Path(work) / "frame.o"
        flags = ["-std=c99", level, "-ffp-contract=off", "-fstack-usage", "-c"]
        done = subprocess.run(
            [gcc, *flags, str(folder / f"{face.prefix}.c"), "-o", str(target)], capture_output=True, check=False
        )
        usage = target.with_suffix(".su")
        if done.returncode or not usage.exists():
            return None
        used = _read_usage(usage.read_text(encoding="utf-8", errors="replace"))
    own = [used.get(name, 0) for name in (*face.procedures, face.step)]
    return _deepest(program, own, max((used.get(name, 0) for name in face.tables), default=0))


def _read_usage(text: str) -> dict[str, int]:
    """Bytes by function. A clone (``f.constprop.0``) counts as its function; one that is inlined is in its caller."""
    used: dict[str, int] = {}
    for match in re.finditer(r"^.*:\d+:\d+:([A-Za-z0-9_]+)\S*\t(\d+)\t", text, re.MULTILINE):
        used[match[1]] = max(used.get(match[1], 0), int(match[2]))
    return used


def _deepest(program: FrameProgram, own: list[int], leaf: int) -> int:
    """The deepest chain of calls: each body calls earlier ones only. ``leaf``: what a look-up takes."""
    depth: list[int] = []
    for body, bytes_ in zip(program.bodies, own, strict=True):
        below = [depth[op.detail] for op in body.operations if op.kind is Kind.CALL]
        below += [leaf] if any(op.kind is Kind.LOOKUP for op in body.operations) else []
        depth.append(bytes_ + max(below, default=0))
    return max(depth[len(program.procedures) :], default=0)


def describe(measured: Mapping[str, int | None], bound: int) -> str:
    """One line for README and report."""
    known = ", ".join(f"{value} bytes at {level}" for level, value in measured.items() if value is not None)
    return f"{known} (gcc -fstack-usage, deepest chain of calls)" if known else f"at most {bound} bytes (calculated)"
