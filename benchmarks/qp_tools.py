"""Solvers on quadratic programs, by their own clocks, for ``qp_solvers.py``: ``PYTHON qp_tools.py PROBLEMS.npz ANSWERS.npz``.

Runs in a Python that has daqp, piqp, osqp and quadprog; needs nothing of saoflow. PROBLEMS holds the fields of ``Dense``
(``qp_problems.py``) with a leading axis of problems, of both forms: ``full_H``, ..., ``condensed_H``, ... ANSWERS gets, by
solver, ``NAME/solution`` (problems, unknowns) and ``NAME/seconds`` (problems, 2): setting up, and solving, each the median
of the repeats; quadprog's solution is what the others are measured by.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib.metadata import version
from types import SimpleNamespace
from typing import Any

import numpy as np

REPEAT = 5
Answer = tuple[np.ndarray, float, float]


def daqp(p: Any) -> Answer:
    """Dual active set, default settings."""
    import daqp as solver

    sense = np.zeros(len(p.low) + len(p.rows) + len(p.equal), dtype=np.int32)
    sense[len(p.low) + len(p.rows) :] = 5
    upper, lower = np.concatenate([p.high, p.high_rows, p.b]), np.concatenate([p.low, p.low_rows, p.b])
    rows = np.vstack([p.rows, p.equal])
    x, _, flag, info = solver.solve(p.H, p.g, rows, upper, lower, sense)
    if flag != 1:
        raise SystemExit(f"daqp ends with exit flag {flag}")
    return np.array(x), info["setup_time"], info["solve_time"]


def piqp(p: Any) -> Answer:
    """Proximal interior point, dense, default settings."""
    import piqp as package

    solver = package.DenseSolver()
    solver.settings.compute_timings = True
    order = {name: np.asfortranarray(getattr(p, name)) for name in ("H", "equal", "rows")}
    equal = (order["equal"], p.b) if len(p.b) else (None, None)
    rows = (order["rows"], p.low_rows, p.high_rows) if len(p.rows) else (None, None, None)
    solver.setup(order["H"], p.g, *equal, *rows, p.low, p.high)
    status = solver.solve()
    if status != package.PIQP_SOLVED:
        raise SystemExit(f"piqp ends with {status}")
    return np.array(solver.result.x), solver.result.info.setup_time, solver.result.info.solve_time


def osqp(p: Any, **settings: float) -> Answer:
    """Operator splitting; default settings, or tighter ones."""
    import osqp as package
    from scipy import sparse

    solver = package.OSQP()
    rows = sparse.csc_matrix(np.vstack([p.equal, np.eye(len(p.g)), p.rows]))
    low, high = np.concatenate([p.b, p.low, p.low_rows]), np.concatenate([p.b, p.high, p.high_rows])
    solver.setup(sparse.csc_matrix(np.triu(p.H)), p.g, rows, low, high, verbose=False, max_iter=100_000, **settings)
    result = solver.solve()
    if result.info.status != "solved":
        raise SystemExit(f"osqp ends with {result.info.status}")
    return np.array(result.x), result.info.setup_time, result.info.solve_time


def quadprog(p: Any) -> Answer:
    """The exact solution of the condensed form, to rounding; no clock."""
    import quadprog as solver

    rows = np.vstack([np.eye(len(p.g)), p.rows])
    low, high = np.concatenate([p.low, p.low_rows]), np.concatenate([p.high, p.high_rows])
    x = solver.solve_qp(p.H, -p.g, np.vstack([rows, -rows]).T, np.concatenate([low, -high]))[0]
    return np.array(x), float("nan"), float("nan")


def tight(p: Any) -> Answer:
    """OSQP at 1e-6."""
    return osqp(p, eps_abs=1e-6, eps_rel=1e-6)


SOLVERS: dict[str, tuple[str, Callable[[Any], Answer]]] = {
    "exact": ("condensed", quadprog),
    "DAQP, condensed": ("condensed", daqp),
    "DAQP, full": ("full", daqp),
    "PIQP, condensed": ("condensed", piqp),
    "PIQP, full": ("full", piqp),
    "OSQP, full": ("full", osqp),
    "OSQP 1e-6, full": ("full", tight),
    "OSQP 1e-6, condensed": ("condensed", tight),
}


def main() -> None:
    """All solvers on all problems."""
    given = np.load(sys.argv[1])
    answers: dict[str, np.ndarray] = {
        "versions": np.array([f"{name} {version(name)}" for name in ("daqp", "piqp", "osqp")])
    }
    for name, (form, solve) in SOLVERS.items():
        fields = {key.split("_", 1)[1]: given[key] for key in given if key.startswith(f"{form}_")}
        solutions, seconds = [], []
        for k in range(len(fields["g"])):
            problem = SimpleNamespace(**{key: np.ascontiguousarray(array[k]) for key, array in fields.items()})
            found = [solve(problem) for _ in range(REPEAT)]
            solutions.append(found[0][0])
            seconds.append(np.median([answer[1:] for answer in found], axis=0))
        answers[f"{name}/solution"], answers[f"{name}/seconds"] = np.array(solutions), np.array(seconds)
    np.savez(sys.argv[2], **answers)


if __name__ == "__main__":
    main()
