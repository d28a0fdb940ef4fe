"""The checks of one sheet's C by compilers, sanitizers and valgrind. MISRA is in :mod:`verification.cleanliness.misra`."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field

from verification.cleanliness.callgraph import deepest, read_call_graph, recursive
from verification.cleanliness.subjects import Subject
from verification.cleanliness.tools import run

WARNINGS = (
    "-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Wfloat-equal", "-Wvla", "-Werror",
)  # fmt: skip
ALLOWED_UNDEFINED = frozenset({"memcpy", "memset"})
"""What a compiler may call by itself in freestanding code (and memmove, memcmp, which it has no cause for)."""
STACK_LIMIT = 64 * 1024
"""Bytes of stack that a frame may take, even compiled without optimisation."""


@dataclass(slots=True)
class Found:
    """What one check finds in one sheet: findings (none: clean), and a note for the line that is printed."""

    findings: list[str] = field(default_factory=list)
    note: str = ""
    measure: int = 0


@dataclass(frozen=True, slots=True)
class Check:
    """A check by name, the tools that it needs, and how it looks at one sheet."""

    name: str
    tools: tuple[str, ...]
    look: Callable[[Subject], Found]


def warnings(compiler: str, *flags: str) -> Callable[[Subject], Found]:
    """Compile the sheet's file with every warning an error."""

    def look(subject: Subject) -> Found:
        command = (compiler, *WARNINGS, *flags, "-c", subject.source.name, "-o", f"warnings_{compiler}.o")
        done = run(command, subject.folder)
        return Found(done.complaint())

    return look


def sanitized(compiler: str) -> Callable[[Subject], Found]:
    """Run frames under the address and undefined-behaviour sanitizers; their first word ends the program."""

    def look(subject: Subject) -> Found:
        program = f"sanitized_{compiler}"
        flags = (
            "-std=c99",
            "-O1",
            "-g",
            "-ffp-contract=off",
            "-fsanitize=address,undefined",
            "-fno-sanitize-recover=all",
        )
        built = run((compiler, *flags, subject.source.name, "main.c", "-o", program), subject.folder)
        if built.code:
            return Found(built.complaint())
        done = run((f"./{program}", "in.bin", f"{program}.out", str(subject.frames)), subject.folder)
        return Found(done.complaint() or _short(subject, f"{program}.out"))

    return look


def valgrind(subject: Subject) -> Found:
    """Run frames under memcheck: no error, no value used before it is set, nothing leaked."""
    built = run(
        ("gcc", "-std=c99", "-O1", "-g", "-ffp-contract=off", subject.source.name, "main.c", "-o", "plain"),
        subject.folder,
    )
    if built.code:
        return Found(built.complaint())
    command = ("valgrind", "--quiet", "--error-exitcode=9", "--track-origins=no", "--max-stackframe=8000000")
    done = run((*command, "./plain", "in.bin", "plain.out", str(subject.frames)), subject.folder)
    return Found(done.complaint() or _short(subject, "plain.out"))


def _short(subject: Subject, name: str) -> list[str]:
    """A finding when a program did not give results for every frame."""
    written = (subject.folder / name).stat().st_size
    per_frame = written // max(subject.frames, 1)
    if written == 0 or written % subject.frames or per_frame % (subject.real // 8):
        return [f"{name} has {written} bytes for {subject.frames} frames: the program ended early"]
    return []


def freestanding(compiler: str, prefix: str = "", *flags: str) -> Callable[[Subject], Found]:
    """No library but memcpy and memset, no writable data, nothing visible but init and step: so no heap either."""

    def look(subject: Subject) -> Found:
        found = Found()
        face = subject.interface
        for level in ("-O0", "-O2"):
            name = f"free_{prefix}{compiler}{level}.o"
            built = run(
                (
                    f"{prefix}{compiler}",
                    "-std=c99",
                    "-ffreestanding",
                    level,
                    *flags,
                    "-c",
                    subject.source.name,
                    "-o",
                    name,
                ),
                subject.folder,
            )
            if built.code:
                return Found(built.complaint())
            found.findings += [
                f"{level}: {text}" for text in _symbols(subject, f"{prefix}nm", name, {face.init, face.step})
            ]
        return found

    return look


def _symbols(subject: Subject, nm: str, name: str, visible: set[str]) -> list[str]:
    """The findings in the symbols of an object file, and in the sizes of its writable sections."""
    findings: list[str] = []
    undefined: set[str] = set()
    seen: set[str] = set()
    for line in run((nm, "-P", name), subject.folder).out.splitlines():
        symbol, kind, *_ = line.split()
        if kind in "Uwv":
            undefined.add(symbol)
        elif kind in "BbDdGgSsCc":
            findings.append(f"writable global data: {symbol}")
        elif kind.isupper():
            seen.add(symbol)
    if unwanted := sorted(undefined - ALLOWED_UNDEFINED):
        findings.append(f"needs {', '.join(unwanted)} from outside")
    if seen != visible:
        findings.append(f"visible: {', '.join(sorted(seen))}; should be: {', '.join(sorted(visible))}")
    sizes = run(("size", "-A", name), subject.folder).out
    for section, size in re.findall(r"^(\.(?:data|bss|tdata|tbss|sdata|sbss)\S*)\s+(\d+)", sizes, re.MULTILINE):
        if int(size) and not section.startswith(".data.rel.ro"):
            findings.append(f"section {section} holds {size} bytes")
    return findings


def stack(level: str) -> Callable[[Subject], Found]:
    """The deepest stack of a frame as gcc tells it, bounded whatever the data, and no recursion."""

    def look(subject: Subject) -> Found:
        name = f"stack{level}.o"
        flags = ("-std=c99", level, "-fstack-usage", "-fcallgraph-info=su")
        built = run(("gcc", *flags, "-c", subject.source.name, "-o", name), subject.folder)
        if built.code:
            return Found(built.complaint())
        graph = read_call_graph((subject.folder / f"stack{level}.ci").read_text(encoding="utf-8"))
        if loop := recursive(graph):
            return Found([f"recursion: {' calls '.join(loop)}"])
        unbounded = [n.name for n in graph.values() if n.kind == "dynamic"]
        findings = [f"the stack of {name} depends on data" for name in unbounded]
        step = deepest(graph, subject.interface.step)
        if step > STACK_LIMIT:
            findings.append(f"a frame takes {step} bytes of stack; {STACK_LIMIT} are allowed")
        return Found(findings, f"{step} bytes", step)

    return look


def limits(subject: Subject) -> Found:
    """What C99 5.2.4.1 promises of every compiler: 127 parameters of a function, 511 identifiers in a block; told, not judged."""
    return Found(
        [], f"{subject.parameters} parameters, {subject.identifiers} identifiers in a block", subject.identifiers
    )


CHECKS: tuple[Check, ...] = (
    *(Check(f"warnings, {c} {o}", (c,), warnings(c, o)) for c in ("gcc", "clang") for o in ("-O0", "-O2")),
    Check("warnings, PowerPC", ("powerpc-linux-gnu-gcc",), warnings("powerpc-linux-gnu-gcc", "-O2", "-mcpu=750")),
    Check("warnings, ARM", ("arm-linux-gnueabihf-gcc",), warnings("arm-linux-gnueabihf-gcc", "-O2")),
    *(Check(f"sanitizers, {c}", (c,), sanitized(c)) for c in ("gcc", "clang")),
    Check("valgrind", ("gcc", "valgrind"), valgrind),
    *(Check(f"freestanding, {c}", (c, "nm", "size"), freestanding(c)) for c in ("gcc", "clang")),
    Check(
        "freestanding, PowerPC",
        ("powerpc-linux-gnu-gcc", "powerpc-linux-gnu-nm", "size"),
        freestanding("gcc", "powerpc-linux-gnu-", "-mcpu=750"),
    ),
    Check(
        "freestanding, ARM",
        ("arm-linux-gnueabihf-gcc", "arm-linux-gnueabihf-nm", "size"),
        freestanding("gcc", "arm-linux-gnueabihf-"),
    ),
    Check("stack, gcc -O0", ("gcc",), stack("-O0")),
    Check("stack, gcc -O2", ("gcc",), stack("-O2")),
    Check("limits of C99", (), limits),
)
"""Every check but MISRA, in the order in which they run."""
