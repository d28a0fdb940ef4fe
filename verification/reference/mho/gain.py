"""The observer gain L, which the paper does not give: the gain of the steady-state Kalman predictor.

With Q^-1 and W^-1 as covariances, in level flight at 300 kt true airspeed and 4 deg angle of attack,

    P = A P A' + Q^-1 - L (C P C' + W^-1) L',   L = A P C' (C P C' + W^-1)^-1

(the discrete algebraic Riccati equation). The command prints the numbers that stand in the sheet and in `tuning`,
and the spectral radius of A - L C at other speeds:

    python -m verification.reference.mho.gain
"""

from __future__ import annotations

import numpy as np

from verification.reference.arrays import DEGREE, Array
from verification.reference.mho.model import f_jacobian, h_jacobian
from verification.reference.mho.tuning import GRAVITY, Q_V_PRINTED, MhoTuning

DESIGN_V = 300.0
"""True airspeed of the design point [kt]."""

DESIGN_ALPHA = 4.0
"""Angle of attack and pitch angle of the design point [deg]."""


def level_flight(v: float = DESIGN_V, alpha: float = DESIGN_ALPHA) -> tuple[Array, Array]:
    """Return x and u of steady level flight at `v` [kt] and `alpha` [deg]."""
    angle = alpha * DEGREE
    x = np.array([angle, v, angle])
    return x, np.array([GRAVITY * np.sin(angle), -GRAVITY * np.cos(angle), 0.0])


def observer_gain(tuning: MhoTuning, v: float = DESIGN_V, alpha: float = DESIGN_ALPHA) -> Array:
    """Return L, (3, 3), by the Riccati recursion run to its fixed point."""
    x, u = level_flight(v, alpha)
    A, C = f_jacobian(x, u, tuning), h_jacobian(x, tuning)
    process, noise = np.diag(1.0 / tuning.Q), np.diag(1.0 / tuning.W)
    P: Array = process
    L: Array = np.zeros((3, 3))
    before = L
    while np.abs(P - before).max() > 1e-15 * np.abs(P).max():
        before = P
        L = np.asarray(np.linalg.solve(C @ P @ C.T + noise, C @ P @ A.T).T)
        P = A @ P @ A.T + process - L @ (C @ P @ C.T + noise) @ L.T
        P = 0.5 * (P + P.T)
    return L


def placed_gain(tuning: MhoTuning, x: Array, u: Array, pole: float = 0.5) -> Array:
    """Return the other stated choice, L = (A - pole I) C^-1, (3, 3), which makes A - L C = pole I at (x, u)."""
    A, C = f_jacobian(x, u, tuning), h_jacobian(x, tuning)
    gain: Array = (A - pole * np.eye(3)) @ np.linalg.inv(C)
    return gain


def spectral_radius(matrix: Array) -> float:
    """Return the largest magnitude of the eigenvalues."""
    return float(np.abs(np.linalg.eigvals(matrix)).max())


def rounded(gain: Array) -> Array:
    """Return the gain to 4 significant digits, as it stands in the sheet; what is below 1e-12 is 0."""
    text = [[f"{value:.3e}" if abs(value) > 1e-12 else "0" for value in row] for row in gain]
    return np.array(text, dtype=float)


def main() -> None:
    """Print L for both readings of Q(2), and how it holds at other speeds."""
    for name, tuning in (("Q(2) of the noise", MhoTuning()), ("Q(2) as printed", MhoTuning(q_v=Q_V_PRINTED))):
        gain = rounded(observer_gain(tuning))
        print(f"L, {name}:")
        print("\n".join("  [" + ", ".join(f"{value:g}" for value in row) + "]" for row in gain))
        for v in (150.0, 200.0, 300.0, 400.0, 500.0):
            x, u = level_flight(v)
            A, C = f_jacobian(x, u, tuning), h_jacobian(x, tuning)
            radii = spectral_radius(A), spectral_radius(A - gain @ C)
            print(f"  at {v:.0f} kt: spectral radius of A {radii[0]:.5f}, of A - L C {radii[1]:.4f}")


if __name__ == "__main__":
    main()
