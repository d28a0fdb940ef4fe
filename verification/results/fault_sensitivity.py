"""Paper 004, Section IV on a flight: how the residual answers a fault, with and without active bounds, and Theorem 1.

In every frame the window's quadratic program (42) is solved exactly, which gives its active bounds; the sensitivities
follow from it by the null space of the active rows, since the Hessian is singular where measurements are lost and (33)
does not exist there.

    python -m verification.results.fault_sensitivity
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from verification.flights import Fault, load_recording, sensors
from verification.reference import cmhe_fte
from verification.reference.arrays import Array, Mask
from verification.reference.estimator import Trace
from verification.reference.inputs import frames
from verification.reference.linearisation import QuadraticProgram
from verification.reference.model import output, transition, transition_jacobian
from verification.reference.tuning import Tuning
from verification.results.fig4 import FAULT, FLIGHT

ALPHA, VC = 2, 3
"""Where the air data stand in y."""

STATES, INPUTS = ("alpha", "V_g", "W_x", "W_z"), ("u_alpha", "u_v", "u_wx", "u_wz")


@dataclass(frozen=True, eq=False)
class Problem:
    """(42) over its free variables w = (dx_l, du_l, ..., du_(k-1)), each in units of its standard deviation.

    z = (dx_l ... dx_k, du_l ... du_(k-1)) is S w + s0; the cost is |G w - r|^2 / 2.
    """

    S: Array  # (n_z, n_w)
    s0: Array  # (n_z,)
    G: Array  # (n_V, n_w), J_1 of (26) over the roots of V, rows in the order of (25)
    r: Array  # (n_V,)
    lower: Array  # (n_z,), (42b)
    upper: Array  # (n_z,)


def deviations(samples: int, tuning: Tuning) -> Array:
    """The roots of V's diagonal, in the order of (25): x_l, then u_i, y_i, and y_k; (n_V,)."""
    blocks = [tuning.P, *([tuning.Q, tuning.R] * (samples - 1)), tuning.R]
    return np.sqrt(np.concatenate(blocks))


def problem(qp: QuadraticProgram, tuning: Tuning) -> Problem:
    """(42) of a window, condensed and in standard deviations."""
    n = len(qp.x)
    n_x, n_z, n_w = 4 * n, 8 * n - 4, 4 * n
    S, s0 = np.zeros((n_z, n_w)), np.zeros(n_z)
    S[:4, :4] = np.diag(np.sqrt(tuning.P))
    S[n_x:, 4:] = np.diag(np.tile(np.sqrt(tuning.Q), n - 1))
    for i in range(n - 1):
        now, after, u = slice(4 * i, 4 * i + 4), slice(4 * i + 4, 4 * i + 8), slice(n_x + 4 * i, n_x + 4 * i + 4)
        S[after] = qp.A[i] @ S[now] + tuning.t_s * S[u]
        s0[after] = qp.A[i] @ s0[now] + qp.f[i]
    rows, right = [S[:4]], [-s0[:4]]
    for i in range(n):
        x = slice(4 * i, 4 * i + 4)
        if i < n - 1:
            u = slice(n_x + 4 * i, n_x + 4 * i + 4)
            rows.append(S[u])
            right.append(qp.r_u[i])
        rows.append(qp.C[i] @ S[x])
        right.append(qp.r_y[i] - qp.C[i] @ s0[x])
    sigma = deviations(n, tuning)
    lower = np.concatenate([(tuning.x_lower - qp.x).ravel(), (tuning.u_lower - qp.u).ravel()])
    upper = np.concatenate([(tuning.x_upper - qp.x).ravel(), (tuning.u_upper - qp.u).ravel()])
    return Problem(S, s0, np.vstack(rows) / sigma[:, None], np.concatenate(right) / sigma, lower, upper)


def free_directions(given: Problem, active: Mask) -> Array:
    """An orthonormal basis of the w that leave the active entries of z where they are, (n_w, n_free)."""
    rows = given.S[active]
    if not len(rows):
        return np.eye(given.S.shape[1])
    _, size, basis = np.linalg.svd(rows / np.linalg.norm(rows, axis=1)[:, None])
    rank = int(np.sum(size > 1e-9))
    free: Array = basis[rank:].T
    return free


def solve(given: Problem) -> tuple[Array, Mask]:
    """Minimise (42) with its bounds exactly; return z and which entries are held at one.

    A primal-dual active set, one change at a time: the worst violation is added, else the worst multiplier released.
    Raises ArithmeticError if that does not settle (it has on every window tried).
    """
    size = np.linalg.norm(given.S, axis=1)
    H, pull = given.G.T @ given.G, given.G.T @ given.r
    side = np.zeros(len(size))  # -1 at the lower bound, 1 at the upper
    for _ in range(10 * len(size)):
        active = side != 0.0
        bound = np.where(side > 0, given.upper, given.lower)
        A = given.S[active] / size[active, None]
        kkt = np.block([[H, A.T], [A, np.zeros((len(A), len(A)))]])
        right = np.concatenate([pull, (bound - given.s0)[active] / size[active]])
        solution = np.linalg.lstsq(kkt, right, rcond=None)[0]
        z = given.S @ solution[: len(H)] + given.s0
        over = np.maximum(z - given.upper, given.lower - z) / size
        over[active] = -np.inf
        wrong = -side[active] * solution[len(H) :]
        if over.max() > 1e-9:
            worst = int(np.argmax(over))
            side[worst] = 1.0 if z[worst] > given.upper[worst] else -1.0
        elif len(wrong) and wrong.max() > 1e-9:
            side[np.flatnonzero(active)[np.argmax(wrong)]] = 0.0
        else:
            return z, active
    raise ArithmeticError("the active set of a window does not settle")


def residual_sensitivity(qp: QuadraticProgram, active: Mask, prediction: Array, tuning: Tuning) -> Array:
    """S_f of (36), or S_f^a of (39) for the active bounds: d r_(k+1) / d (epsilon_k, f_(k+1)), (4, n_V + 4).

    ``prediction`` is C A of the next sample, (4, 4): what a change of x_(k|k) makes of the predicted outputs.
    """
    given = problem(qp, tuning)
    sigma = deviations(len(qp.x), tuning)
    basis = free_directions(given, active)
    reduced = given.G @ basis
    dw = basis @ np.linalg.lstsq(reduced, np.eye(len(reduced)), rcond=None)[0] / sigma
    # A masked row of C is zero: it takes no part, and neither does a fault in it.
    newest = slice(4 * len(qp.x) - 4, 4 * len(qp.x))
    return np.hstack([-prediction @ given.S[newest] @ dw, np.eye(4)])


def next_outputs(trace: Trace, following: Trace, tuning: Tuning) -> Array:
    """C_(k+1) A_k at the estimate x_(k|k), (4, 4)."""
    theta, x = trace.window.theta[-1], trace.x[-1]
    A = transition_jacobian(x, theta, tuning)
    C = output(transition(x, np.zeros(4), theta, tuning), following.inputs.theta, tuning)[1]
    product: Array = C @ A
    return product


def lasting(S: Array, samples: int, output: int = VC) -> float:
    """A residual's answer to a fault of 1 of its own sensors that has lasted through the window and the next sample."""
    columns = [8 + 8 * i + output for i in range(samples - 1)] + [8 * samples - 4 + output, 8 * samples + output]
    return float(S[output, columns].sum())


@dataclass(frozen=True)
class Sensitivity:
    """One frame of CMHE with an active bound, at its own linearisation."""

    frame: int
    active: tuple[str, ...]
    """The bounds that hold the exact solution of (42), as "W_x of k-2"."""
    free: float
    """The residual's answer to a lasting fault without bounds: of airspeed, or of the output asked for."""
    held: float
    """And with the active ones."""
    printed: tuple[float, float]
    """Least and largest eigenvalue of S_a S_a' - S S', SI, as in Theorem 1."""
    in_deviations: tuple[float, float]
    """The same with faults and residuals counted in standard deviations."""


def sensitivity(frame: int, trace: Trace, following: Trace, tuning: Tuning, output: int = VC) -> Sensitivity:
    """Both sensitivities of one window, at the same estimate; the answers are those of one output."""
    n = len(trace.qp.x)
    _, active = solve(problem(trace.qp, tuning))
    ahead = next_outputs(trace, following, tuning)
    S = residual_sensitivity(trace.qp, np.zeros_like(active), ahead, tuning)
    S_a = residual_sensitivity(trace.qp, active, ahead, tuning)
    weight = np.concatenate([deviations(n, tuning), np.sqrt(tuning.R)])
    root_R = np.sqrt(tuning.R)[:, None]

    def ends(matrix: Array) -> tuple[float, float]:
        values = np.linalg.eigvalsh(matrix)
        return float(values[0]), float(values[-1])

    scaled, scaled_a = S * weight / root_R, S_a * weight / root_R
    return Sensitivity(
        frame,
        tuple(_name(int(i), n) for i in np.flatnonzero(active)),
        lasting(S, n, output),
        lasting(S_a, n, output),
        ends(S_a @ S_a.T - S @ S.T),
        ends(scaled_a @ scaled_a.T - scaled @ scaled.T),
    )


def held_newest(trace: Trace, following: Trace, tuning: Tuning) -> tuple[float, ...]:
    """The answer to a lasting airspeed fault with no W_x held, the newest, the two newest, ... all of the window."""
    n, ahead, answers = len(trace.qp.x), next_outputs(trace, following, tuning), []
    for count in range(n + 1):
        active = np.zeros(8 * n - 4, bool)
        active[[4 * (n - 1 - i) + 2 for i in range(count)]] = True
        answers.append(lasting(residual_sensitivity(trace.qp, active, ahead, tuning), n))
    return tuple(answers)


def _name(entry: int, samples: int) -> str:
    names, i = (STATES, entry) if entry < 4 * samples else (INPUTS, entry - 4 * samples)
    age = samples - 1 - i // 4
    return f"{names[i % 4]} of k{f'-{age}' if age else ''}"


def on_flight(inputs: Mapping[str, npt.ArrayLike], tuning: Tuning, output: int = VC) -> tuple[Sensitivity, ...]:
    """Every frame of a run of CMHE whose window has all its measurements and whose solution lies on a bound."""
    traces = run_traces(inputs, tuning)
    found = []
    for k in range(tuning.n_inhibit, len(traces) - 1):
        if traces[k].window.row_mask.all():
            one = sensitivity(k, traces[k], traces[k + 1], tuning, output)
            if one.active:
                found.append(one)
    return tuple(found)


def run_traces(inputs: Mapping[str, npt.ArrayLike], tuning: Tuning) -> list[Trace]:
    """What happens inside every frame of CMHE."""
    state, traces = cmhe_fte.initial_state(tuning), []
    for now in frames(inputs):
        step = cmhe_fte.step(state, now, tuning)
        traces.append(step.trace)
        state = step.state
    return traces


def paper_flight(
    seconds: float = 30.0, onset: float = FAULT.onset, seed: int = 1, flight: str = FLIGHT
) -> dict[str, Array]:
    """The readings of Fig. 4's fault, by default on its own flight."""
    fault: Fault = replace(FAULT, onset=onset)
    return sensors(load_recording(flight).part(0.0, seconds), seed, faults=[fault]).inputs()


def by_count(found: Sequence[Sensitivity]) -> dict[int, tuple[int, float, float, float]]:
    """By the number of active bounds: frames, and mean answer without bounds, least and largest with them."""
    groups: dict[int, list[Sensitivity]] = {}
    for one in found:
        groups.setdefault(len(one.active), []).append(one)
    return {
        count: (len(rows), float(np.mean([r.free for r in rows])), min(r.held for r in rows), max(r.held for r in rows))
        for count, rows in sorted(groups.items())
    }


def main() -> None:
    """Print Fig. 4's flight."""
    found = on_flight(paper_flight(), Tuning())
    first = found[0]
    print(f"{len(found)} frames with an active bound, the first {first.frame}: {', '.join(first.active)}")
    for count, (rows, free, low, high) in by_count(found).items():
        print(f"{count} active: {rows} frames; answer {free:.3f} without bounds, {low:.3f} to {high:.3f} with them")
    print(
        f"Theorem 1 as printed, eigenvalues {min(s.printed[0] for s in found):.3g} to"
        f" {max(s.printed[1] for s in found):.3g}"
    )
    low, high = min(s.in_deviations[0] for s in found), max(s.in_deviations[1] for s in found)
    print(f"in standard deviations {low:.3g} to {high:.3g}")


if __name__ == "__main__":
    main()
