"""The cost model's instructions against those of GCC's code, counted under qemu: ``python benchmarks/calibration.py``.

For the flagship, two shipped sheets of its kind and 20 random sheets (seeds 400 to 419): instructions a frame, predicted and counted, for both forms
(memory against -O0, registers against -O2; -O1 for comparison) and every instruction set whose tools are installed.
``--fit`` prints the measured shares of ``saoflow/targets/targets.toml`` from the flagship and 40 other random sheets
(seeds 0 to 19 and 100 to 119): least squares of the relative errors, drawn a little to what stands there; the model was
made on these and on seeds 200 to 219 and 300 to 319; the 20 sheets and the two took no part. ``--markdown`` prints the tables of
``docs/cost_model.md`` (without -O1), ``--tuned`` checks the sheets of the fit, ``--cycles`` compares cycles
of the flagship with those of GCC's instructions on the same pipeline.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from executed import executed
from instruction_count import TOOLCHAINS, Toolchain, count_instructions
from random_sheets import random_sheet
from scipy.optimize import lsq_linear

import saoflow
from saoflow.scheduler.program import FrameProgram
from saoflow.targets import InstructionSet, Shares, Target, find_target, frame_cost, targets
from saoflow.targets.pipeline import cycles

TOLERANCE = 0.10
CHECKED, FITTED = range(400, 420), (*range(20), *range(100, 120))
SHIPPED = ("cmhe_fte", "cmhe_fte_lean", "umhe_fte")
"""Sheets that the first frames of one recording fit; only the flagship takes part in the fit."""
PRIOR = 0.05
"""Relative error that a share off by its own size counts as."""
LEVELS = {"memory": "-O0", "registers": "-O2"}
FRAMES = 6
LEAST = {
    "minimum": 2.0, "compare": 1.0, "select": 1.0, "lookup": 6.0, "lookup_2d": 20.0, "lookup_step": 3.0,
}  # fmt: skip
"""Instructions of a share that the model knows by name: no fit goes below (nor below 0)."""


@dataclass(frozen=True, slots=True)
class Sample:
    """A sheet: its program, and the frames that it is run on."""

    name: str
    program: FrameProgram
    rows: np.ndarray
    """(frames, elements of all inputs)"""


def random_samples(seeds: Iterable[int], folder: Path) -> Iterator[Sample]:
    """Random sheets with normally distributed inputs."""
    for seed in seeds:
        program = random_sheet(seed, folder).frame_program
        size = sum(port.type.size for port in program.inputs)
        yield Sample(f"random {seed}", program, np.random.default_rng(seed).normal(size=(FRAMES, size)))


def shipped(name: str) -> Sample:
    """A sheet with the flagship's inputs on the first frames of a shipped recording, with sensor noise."""
    from verification.flights import load_recording, sensors

    program = saoflow.load(name).frame_program
    inputs = sensors(load_recording("a320_wind_350kt_5000ft"), seed=1).inputs()
    rows = np.hstack([np.reshape(inputs[port.name], (len(inputs[port.name]), -1)) for port in program.inputs])
    return Sample(name, program, rows[:FRAMES])


def predicted(program: FrameProgram, isa: InstructionSet) -> Mapping[str, int]:
    """Instructions a frame by form, on the first target of the instruction set."""
    target = next(t for t in targets().values() if t.instruction_set.name == isa.name)
    target = dataclasses.replace(target, instruction_set=isa)
    return {form.form: form.instructions for form in frame_cost(program, target).forms}


def check(samples: list[Sample], isa: InstructionSet, tools: Toolchain, folder: Path, markdown: bool) -> int:
    """Print predicted and counted instructions of every sheet; how many of the two forms miss the tolerance."""
    pairs = (("memory", "-O0"), ("registers", "-O2"), ("registers", "-O1"))[: 2 if markdown else 3]
    head = ["sheet", *(cell for form, level in pairs for cell in ([] if level == "-O1" else [form]) + [level, "miss"])]
    print(_row(head, markdown))
    if markdown:
        print("|" + "---|" * len(head))
    misses: list[str] = []
    errors: dict[str, list[float]] = {level: [] for _, level in pairs}
    for sample in samples:
        found = predicted(sample.program, isa)
        cells = [sample.name]
        for form, level in pairs:
            counted = count_instructions(sample.program, sample.rows, tools, level, folder).instructions
            miss = found[form] / counted - 1
            errors[level].append(miss)
            if abs(miss) > TOLERANCE and level in LEVELS.values():
                misses.append(f"{sample.name} {level} {100 * miss:+.1f} %")
            cells += ([] if level == "-O1" else [f"{found[form]}"]) + [f"{counted:.0f}", f"{100 * miss:+.1f} %"]
        print(_row(cells, markdown), flush=True)
    print()
    for level, e in errors.items():
        print(f"{level}: mean {100 * np.mean(e):+.1f} %, mean size {100 * np.mean(np.abs(e)):.1f} %, "
              f"largest {100 * max(e, key=abs):+.1f} %, beyond {100 * TOLERANCE:.0f} %: "
              f"{sum(abs(miss) > TOLERANCE for miss in e)} of {len(e)}")  # fmt: skip
    print(f"beyond {100 * TOLERANCE:.0f} %: {', '.join(misses) or 'none'}\n")
    return len(misses)


def check_cycles(tools: Toolchain, folder: Path) -> None:
    """Print the flagship's cycles on PowerPC targets: predicted, and of the instructions that GCC made, on the same pipeline."""
    sample = shipped(SHIPPED[0])
    made = executed(count_instructions(sample.program, sample.rows, tools, LEVELS["registers"], folder).last)
    for name in ("mpc755", "e300c3", "e500mc"):
        target = find_target(name)
        predicted, counted = frame_cost(sample.program, target).forms[1].cycles, cycles(made, target, sample.program.real)
        print(f"{name}: {predicted} cycles predicted, {counted} of GCC's code, {100 * (predicted / counted - 1):+.1f} %")


def _row(cells: list[str], markdown: bool) -> str:
    if markdown:
        return "| " + " | ".join(cells) + " |"
    return f"{cells[0]:<12}" + "".join(f"{c:>11}" for c in cells[1:])


def fit(samples: list[Sample], isa: InstructionSet, tools: Toolchain, folder: Path) -> None:
    """Print the shares that make predictions fit best, with how often each was seen."""
    for form, level in LEVELS.items():
        counted = np.array([count_instructions(s.program, s.rows, tools, level, folder).instructions for s in samples])
        print(f"{form} = {_toml(fitted(samples, isa, form, counted))}", flush=True)


def fitted(samples: list[Sample], isa: InstructionSet, form: str, counted: np.ndarray) -> Shares:
    """Shares by least squares of relative errors; the model is linear in them."""
    names = [f.name for f in dataclasses.fields(Shares)]
    start = isa.shares[form]

    def with_shares(shares: Shares) -> np.ndarray:
        changed = dataclasses.replace(isa, shares={**isa.shares, form: shares})
        return np.array([predicted(s.program, changed)[form] for s in samples], dtype=float)

    base = with_shares(start)
    slopes = [with_shares(dataclasses.replace(start, **{n: getattr(start, n) + 2.0})) - base for n in names]
    matrix = np.stack(slopes, axis=1) / 2.0
    now = np.array([getattr(start, n) for n in names])
    free = [k for k in range(len(names)) if np.any(matrix[:, k])]
    least = np.array([LEAST.get(n, 0.0) for n in names])
    rows = np.vstack([matrix[:, free] / counted[:, None], np.diag(PRIOR / np.maximum(1.0, now[free]))])
    wanted = np.concatenate([(counted - base) / counted, np.zeros(len(free))])
    found = lsq_linear(rows, wanted, bounds=((least - now)[free] - 1e-9, np.inf))
    now[free] += found.x
    return Shares(**{n: round(float(v), 2) for n, v in zip(names, now, strict=True)})


def _toml(shares: Shares) -> str:
    return "{" + ", ".join(f"{f.name} = {getattr(shares, f.name)}" for f in dataclasses.fields(Shares)) + "}"


def main() -> int:
    """Calibrate what the installed tools allow; exit 1 if a prediction misses the tolerance."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fit", action="store_true", help="print the measured shares instead")
    parser.add_argument("--markdown", action="store_true", help="print tables for docs/cost_model.md")
    parser.add_argument("--tuned", action="store_true", help="check the sheets that the model was made on")
    parser.add_argument("--set", action="append", choices=list(TOOLCHAINS), help="only this instruction set")
    parser.add_argument("--seeds", type=int, nargs="+", metavar="SEED", help="random sheets of these seeds alone: a look")
    parser.add_argument("--cycles", action="store_true", help="print cycles of GCC's code on PowerPC instead")
    options = parser.parse_args()
    sets: dict[str, Target] = {}
    for target in targets().values():
        sets.setdefault(target.instruction_set.name, target)
    missed = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if options.cycles:
            print(TOOLCHAINS["powerpc"].missing, end="")
            if not TOOLCHAINS["powerpc"].missing:
                check_cycles(TOOLCHAINS["powerpc"], folder)
            return 0
        tuned = options.fit or options.tuned
        seeds = options.seeds or (FITTED if tuned else CHECKED)
        names = SHIPPED[: 0 if options.seeds else 1 if tuned else None]
        samples = [*(shipped(name) for name in names), *random_samples(seeds, folder)]
        for key in options.set or TOOLCHAINS:
            tools = TOOLCHAINS[key]
            isa = sets[key].instruction_set
            print(f"{key}: {tools.missing or isa.calibrated}")
            if tools.missing:
                continue
            if options.fit:
                fit(samples, isa, tools, folder)
            else:
                missed += check(samples, isa, tools, folder, options.markdown)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
