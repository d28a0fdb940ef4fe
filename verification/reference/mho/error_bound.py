"""Theorem 1 of paper 003 with numbers: the constants (36) of a run, and a and b of (41).

All maxima are taken over a run whose truth is known, so they are as small as the run allows: kappa_f and kappa_h are the
largest linearisation errors that occurred, over the squared errors they occurred at; epsilon is the largest error; r_w and
r_v are the largest disturbance and noise. The norms mix units, so the result depends on them: `Scales` chooses.

Corrected: Xi of the last horizon is Xi_k-N-1,k-1, and H_bar of (34) is -G_bar blkdiag(L).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from verification.reference.arrays import DEGREE, Array
from verification.reference.mho.estimator import Step
from verification.reference.mho.mho_pe import Linearised, linearise, stacked_matrices
from verification.reference.mho.model import f, f_jacobian, h, h_jacobian
from verification.reference.mho.tuning import MhoTuning


@dataclass(frozen=True)
class Scales:
    """The units that norms are taken in: one of each is so many rad and kt."""

    name: str
    x: tuple[float, float, float]
    y: tuple[float, float, float]


PRINTED_UNITS = Scales("rad and kt, as the paper's M and W", (1.0, 1.0, 1.0), (1.0, 1.0, 1.0))
NOISE_UNITS = Scales(
    "standard deviations of the noise", (0.1 * DEGREE, 0.7775, 0.1 * DEGREE), (0.7775, 0.5832, 0.1 * DEGREE)
)


@dataclass(frozen=True)
class Bound:
    """(36), (41) and what they bound."""

    delta_gamma: float
    delta_xi: float
    delta_f: float
    delta_g: float
    delta_h: float
    delta_w: float
    delta_l: float
    mu_m: float
    mu_o: float
    rho_e: float
    rho_w: float
    rho_v: float
    kappa_f: float
    kappa_h: float
    epsilon: float
    r_w: float
    r_v: float
    N: int
    largest_error: float
    """The largest ||e_k-N|| that occurred."""

    @property
    def linearisation(self) -> float:
        """What linearisation errors contribute: the factor of rho_e, rho_w, rho_v in (39) and (41)."""
        bend = self.delta_g * self.kappa_f + self.delta_h * self.kappa_h
        return self.delta_f * self.delta_w * self.epsilon * bend / (self.mu_m + self.mu_o)

    @property
    def a(self) -> float:
        """a of (41)."""
        return self.delta_gamma * self.delta_xi + self.linearisation * self.rho_e

    @property
    def b(self) -> float:
        """b of (41)."""
        gain = self.delta_f * self.delta_w / (self.mu_m + self.mu_o) * np.sqrt(self.N + 1)
        bent = self.linearisation * np.sqrt(self.N + 2)
        of_w = self.delta_gamma + gain * self.delta_g + bent * self.rho_w
        of_v = self.delta_gamma * self.delta_l + gain * self.delta_h + bent * self.rho_v
        return float(of_w * self.r_w + of_v * self.r_v)

    @property
    def limit(self) -> float:
        """zeta_infinity = b/(1 - a); infinite unless a < 1."""
        return self.b / (1.0 - self.a) if self.a < 1.0 else float("inf")

    @property
    def needed_m(self) -> float:
        """The right-hand side of (43), which mu_M must exceed; infinite unless delta_Xi < 1."""
        if self.delta_xi >= 1.0:
            return float("inf")
        return self.linearisation * self.rho_e * (self.mu_m + self.mu_o) / (1.0 - self.delta_xi) - self.mu_o


@dataclass(frozen=True)
class _Frame:
    """The norms of one frame."""

    gamma: float
    xi: float
    F: float
    G: float
    H: float
    information: float  # least singular value of F' W F
    F_hat: float
    G_hat: float
    H_hat: float
    kappa_f: float
    kappa_h: float
    epsilon: float
    error: float


def error_bound(
    steps: Sequence[Step], truth: Array, measured: tuple[Array, Array], tuning: MhoTuning, scales: Scales, skip: int
) -> Bound:
    """Evaluate Theorem 1 on a run of MHO-PE.

    `truth` (n, 3) is x, `measured` y_m and u_m, (n, 3) each; the first `skip` frames are left out.
    """
    D, E, L = np.array(scales.x), np.array(scales.y), tuning.gain
    frames = [_frame(steps[k], steps[k - 1], truth, k, tuning, D, E) for k in range(skip, len(steps))]
    w = np.array([truth[k + 1] - f(truth[k], measured[1][k], tuning) for k in range(skip, len(truth) - 1)]) / D
    v = np.array([measured[0][k] - h(truth[k], tuning) for k in range(skip, len(truth))]) / E

    def largest(name: str) -> float:
        return max(float(getattr(frame, name)) for frame in frames)

    return Bound(
        delta_gamma=largest("gamma"),
        delta_xi=largest("xi"),
        delta_f=largest("F"),
        delta_g=largest("G"),
        delta_h=largest("H"),
        delta_w=float((tuning.W * E**2).max()),
        delta_l=_norm(L * E / D[:, None]),
        mu_m=float((tuning.M * D**2).min()),
        mu_o=min(frame.information for frame in frames),
        rho_e=largest("F_hat"),
        rho_w=largest("G_hat"),
        rho_v=largest("H_hat"),
        kappa_f=largest("kappa_f"),
        kappa_h=largest("kappa_h"),
        epsilon=largest("epsilon"),
        r_w=float(np.linalg.norm(w, axis=1).max()),
        r_v=float(np.linalg.norm(v, axis=1).max()),
        N=tuning.N,
        largest_error=largest("error"),
    )


def _norm(matrix: npt.NDArray[np.floating[Any]]) -> float:
    return float(np.linalg.norm(matrix, 2))


def _frame(step: Step, before: Step, truth: Array, k: int, tuning: MhoTuning, D: Array, E: Array) -> _Frame:
    N, L = tuning.N, tuning.gain
    point = linearise(step.window, L, tuning)
    states, outputs = np.tile(D, N + 1), np.tile(E, N + 1)

    # (9) and (28)
    F, G, H = stacked_matrices(point, L)
    F, G, H = F * D / outputs[:, None], G * states / outputs[:, None], H * outputs / outputs[:, None]
    information = F.T @ (np.tile(tuning.W * E**2, N + 1)[:, None] * F)
    M = np.diag(tuning.M * D**2)
    gamma = np.linalg.solve(M + information, M)  # I - (M + F'WF)^-1 F'WF

    # Xi of the last horizon's first transition, (29), and (34)
    x, u = before.solution.x[0], before.window.u[0]
    Xi = (f_jacobian(x, u, tuning) - L @ h_jacobian(x, tuning)) * D / D[:, None]
    of_states = replace(point, C=np.tile(np.eye(3), (N + 1, 1, 1)))
    F_bar, G_bar, _ = stacked_matrices(of_states, L)
    F_bar, G_bar = F_bar * D / states[:, None], G_bar * states / states[:, None]
    L_scaled = L * E / D[:, None]
    kappa_f, kappa_h, epsilon = _linearisation_errors(point, truth[k - N : k + 1], step.window.u, tuning, D, E)
    H_bar = -G_bar @ np.kron(np.eye(N + 1), L_scaled)
    return _Frame(
        gamma=_norm(gamma),
        xi=_norm(Xi),
        F=_norm(F),
        G=_norm(G),
        H=_norm(H),
        information=float(np.linalg.svd(information, compute_uv=False).min()),
        F_hat=_norm(F_bar @ Xi),
        G_hat=_norm(np.hstack([F_bar, G_bar])),
        H_hat=_norm(np.hstack([-F_bar @ L_scaled, H_bar])),
        kappa_f=kappa_f,
        kappa_h=kappa_h,
        epsilon=epsilon,
        error=float(np.linalg.norm((truth[k - N] - step.solution.x[0]) / D)),
    )


def _linearisation_errors(
    point: Linearised, truth: Array, u: Array, tuning: MhoTuning, D: Array, E: Array
) -> tuple[float, float, float]:
    """(22) at the errors that occurred: Assumption 3's kappa_f, kappa_h and epsilon."""
    kappa_f, kappa_h, epsilon = 0.0, 0.0, 0.0
    for i, (x, x_bar) in enumerate(zip(truth, point.x_bar, strict=True)):
        square = float(np.sum(((x - x_bar) / D) ** 2))
        psi_h = h(x, tuning) - h(x_bar, tuning) - point.C[i] @ (x - x_bar)
        kappa_h = max(kappa_h, float(np.linalg.norm(psi_h / E)) / square)
        if i < len(u):
            psi_f = f(x, u[i], tuning) - f(x_bar, u[i], tuning) - point.A[i] @ (x - x_bar)
            kappa_f = max(kappa_f, float(np.linalg.norm(psi_f / D)) / square)
        epsilon = max(epsilon, square**0.5)
    return kappa_f, kappa_h, epsilon
