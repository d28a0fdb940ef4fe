"""What a moving horizon observer estimates from, and what it gives."""

from __future__ import annotations

from dataclasses import dataclass

from verification.reference.arrays import Array


@dataclass(frozen=True)
class Window:
    """The horizon [k - N, k] of paper 003, oldest sample first."""

    y: Array  # (N + 1, 3): y_m,k-N ... y_m,k
    u: Array  # (N, 3): u_m,k-N ... u_m,k-1
    x_prior: Array  # (3,): x_bar_k-N|k
    w_prior: Array  # (N, 3): first guess of w_k-N ... w_k-1; MHO-PE and MHO-woD have none


@dataclass(frozen=True)
class Solution:
    """What one SQP iteration gives."""

    x_bar: Array  # (N + 1, 3): the trajectory that it was linearised along, x_bar_k-N|k ... x_bar_k|k
    p: Array  # (3,): the search direction of x_k-N, (12)
    x: Array  # (N + 1, 3): x*_k-N|k ... x*_k|k
    w: Array  # (N, 3): w*_k-N|k ... w*_k-1|k; 0 without disturbance estimates
