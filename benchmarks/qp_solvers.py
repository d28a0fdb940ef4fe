"""The flagship's quadratic program by its four passes, against DAQP, PIQP and OSQP: ``python benchmarks/qp_solvers.py --python PYTHON``.

(42) of paper 004, 4 states, 3 samples, 20 unknowns, every one of them between two bounds: ``qp.yaml`` in C (backend ``c``; the
interior point alone, no linearisation) and three solvers, which saoflow does not depend on. PYTHON is one that has them:

    python -m venv qp-tools && qp-tools/bin/pip install daqp piqp osqp quadprog
    python benchmarks/qp_solvers.py --python qp-tools/bin/python

The problems are those of the numpy reference in flight: turbulence without a fault, and three airspeeds that run away
together, so that bounds of wind and wind acceleration hold. Solvers start cold, as A and C change in every frame, and
run by their own clocks (median of five, then over the problems); saoflow's is processor time over many problems in a row,
and the same for every problem. Forming H and condensing it is on nobody's clock; saoflow needs neither.
Solvers get the problem in widths of the bounds, with equations (full) and without (condensed). Errors are against
quadprog: of all unknowns in widths of their bounds, and of alpha and horizontal wind at the newest sample. Four passes with
kappa ending at 0.1 are not meant to find the exact solution; the estimator does not need it.
"""

from __future__ import annotations

import argparse
import dataclasses
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from qp_problems import Dense, condensed, flagship_problems, full, widths

import saoflow
from verification.reference.linearisation import QuadraticProgram
from verification.reference.tuning import Tuning

HERE = Path(__file__).parent
SHARED = ("t_s", "P", "Q", "R", "kappa_init", "kappa_factor", "distance_floor")
RUN = 20_000
"""Problems in a row for saoflow's clock."""


def flagship(problems: list[QuadraticProgram], tuning: Tuning, repeat: int) -> tuple[np.ndarray, float]:
    """Solutions in widths (problems, 20), and processor seconds a problem."""
    given = {name: np.asarray(getattr(tuning, name)).tolist() for name in SHARED}
    given |= {"N": tuning.n_horizon, "n_kappa": tuning.n_kappa, "n_QP": tuning.n_qp, "n_s_max": tuning.n_s_max}
    given |= {"x_min": tuning.x_lower.tolist(), "x_max": tuning.x_upper.tolist()}
    given |= {"u_min": tuning.u_lower.tolist(), "u_max": tuning.u_upper.tolist()}
    simulator = saoflow.load(str(HERE / "qp.yaml"), given).simulator(backend="c")
    inputs = {name: np.array([getattr(qp, name) for qp in problems]) for name in ("x", "u", "f", "r_y")}
    inputs["a"] = np.array([qp.A[:, :2, 0] for qp in problems])
    inputs["c"] = np.array([np.stack([qp.C[:, 1, 0], *(qp.C[:, 3, j] for j in (0, 2, 3))], axis=1) for qp in problems])
    many = {name: np.resize(array, (RUN, *array.shape[1:])) for name, array in inputs.items()}
    out = simulator.run(inputs)
    found = np.hstack([out["dx"].reshape(len(problems), -1), out["du"].reshape(len(problems), -1)]) / widths(tuning)
    times = []
    for _ in range(repeat):
        start = time.process_time()
        simulator.run(many)
        times.append((time.process_time() - start) / RUN)
    return found, statistics.median(times)


def solvers(wholes: list[Dense], shorts: list[Dense], python: str) -> dict[str, np.ndarray]:
    """Answers of ``qp_tools.py``. Raises SystemExit, with the way out, where a solver is missing or fails."""
    with tempfile.TemporaryDirectory() as folder:
        problems, answers = Path(folder) / "problems.npz", Path(folder) / "answers.npz"
        fields: dict[str, Any] = _fields("full", wholes) | _fields("condensed", shorts)
        np.savez(problems, **fields)
        command = [python, str(HERE / "qp_tools.py"), str(problems), str(answers)]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=600)
        except OSError as error:
            raise SystemExit(f"{python} does not run: {error.strerror}. Give a Python with --python.") from None
        if done.returncode:
            said = (done.stderr.strip().splitlines() or ["it says nothing"])[-1]
            raise SystemExit(
                f"the solvers do not run in {python}: {said}\n"
                "python -m venv qp-tools && qp-tools/bin/pip install daqp piqp osqp quadprog\n"
                "makes a Python that has them; give it with --python qp-tools/bin/python"
            )
        with np.load(answers) as found:
            return dict(found)


def _fields(form: str, problems: list[Dense]) -> dict[str, np.ndarray]:
    names = [field.name for field in dataclasses.fields(Dense)]
    return {f"{form}_{name}": np.array([getattr(p, name) for p in problems]) for name in names}


def table(problems: list[QuadraticProgram], only_held: bool, tuning: Tuning, python: str, repeat: int) -> str:
    """Print times and errors, of all or of those in which a bound holds; returns the versions of the solvers."""
    wholes = [full(qp, tuning) for qp in problems]
    shorts, maps, offsets = zip(*(condensed(whole) for whole in wholes), strict=True)
    answers = solvers(wholes, list(shorts), python)

    def every(solutions: np.ndarray) -> np.ndarray:
        if solutions.shape[1] == len(wholes[0].g):
            return solutions
        return np.array([T @ v + t for T, t, v in zip(maps, offsets, solutions, strict=True)])

    exact = every(answers["exact/solution"])
    held = (exact <= _all(w.low for w in wholes) + 1e-9) | (exact >= _all(w.high for w in wholes) - 1e-9)
    holds = np.asarray(held.any(axis=1))
    taken = holds if only_held else np.ones(len(problems), dtype=bool)
    print(f"{taken.sum()} of {len(problems)} problems; a bound holds in {holds[taken].sum()} of them")
    print(f"{'':<22}{'setup':>9}{'solve':>9}   {'error, widths':>19}{'alpha, deg':>19}{'W_x, kt':>19}")
    print(f"{'':<22}{'us':>9}{'us':>9}   {'median   largest':>19}{'median   largest':>19}{'median   largest':>19}")
    found, seconds = flagship(problems, tuning, repeat)
    _row("saoflow, four passes", (None, 1e6 * seconds), found[taken], exact[taken], tuning)
    for name in (key.split("/")[0] for key in answers if key.endswith("/solution") and not key.startswith("exact")):
        setup, solve = 1e6 * np.median(answers[f"{name}/seconds"][taken], axis=0)
        _row(name, (setup, solve), every(answers[f"{name}/solution"])[taken], exact[taken], tuning)
    return ", ".join(answers["versions"].tolist())


def _all(rows: Iterable[np.ndarray]) -> np.ndarray:
    return np.array(list(rows))


def _row(name: str, us: tuple[float | None, float], found: np.ndarray, exact: np.ndarray, tuning: Tuning) -> None:
    error = np.abs(found - exact)
    newest = 4 * (tuning.n_horizon - 1)
    size = widths(tuning)
    columns = [
        error.max(axis=1),
        np.degrees(error[:, newest] * size[newest]),
        error[:, newest + 2] * size[newest + 2] * 3600 / 1852,
    ]
    cells = "".join(f"{np.median(c):>10.1e}{np.max(c):>9.1e}" for c in columns)
    setup = "none" if us[0] is None else f"{us[0]:.2f}"
    print(f"{name:<22}{setup:>9}{us[1]:>9.2f}   {cells}")


def main() -> None:
    """Two tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--python", default=sys.executable, help="a Python with daqp, piqp, osqp and quadprog")
    parser.add_argument("--repeat", type=int, default=7)
    options = parser.parse_args()
    tuning = Tuning()
    versions = ""
    calm, running = flagship_problems(tuning)
    for name, problems, only_held in (("without a fault", calm, False), ("airspeeds run away", running, True)):
        print(f"\n{name}: ", end="", flush=True)
        versions = table(problems, only_held, tuning, options.python, options.repeat)
    print(f"\n{versions}")


if __name__ == "__main__":
    main()
