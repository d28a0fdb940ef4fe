"""The equations of paper 004 that the flagship's sheets are, sheet by sheet, as the flagship's page shows them beside the drawings.

In the form that is right: what the paper prints otherwise is marked ``corrected``, and told in docs/corrections.md. Names and
numbers are the paper's; W_z is positive down.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import zip_longest

from rich.cells import cell_len

WIDTH = 78
"""Letters that a page shows in one line."""

EQUATIONS: Mapping[str, tuple[tuple[str, str], ...]] = {
    "cmhe_fte": (
        ("x = (α, V_g, W_x, W_z),  u = (u_α, u_v, u_wx, u_wz)", "(22)"),
        ("y = (V_g, V_z, α, V_c),  Θ = (V_g,m, θ, q, A_x, A_z, z)", ""),
        ("x_i+1 = F(x_i, u_i, Θ_i),  y_m,i = h(x_i, Θ_i) + n_i", "(20a) to (20d)"),
        ("min  ½‖x_l − x⁻_l|k‖²_P⁻¹ + ½ Σ_l..k−1 ‖u_i‖²_Q⁻¹", "(21a)"),
        ("     + ½ Σ_l..k ‖y_m,i − h(x_i, Θ_i)‖²_R⁻¹", ""),
        ("u^LB ≤ u_i ≤ u^UB,  x^LB ≤ x_i ≤ x^UB", "(21b)"),
        ("P = diag(p_α, p_v, p_w I_2),  Q = diag(q_α, q_v, q_w I_2),  R = diag(R_vg, R_vz, R_α, R_vc)", "(22), corrected"),
    ),
    "warm_start": (
        ("x̂_i|k−1, û_i|k−1 of the last frame's window, one sample further", "V-A"),
        ("x̂_k|k−1 = F(x̂_k−1|k−1, û_k−1|k−1, Θ_k−1),  û_k−1|k−1 = 0", ""),
    ),
    "output_equation": (
        ("V_t ≈ V_g − W_x cos(α − θ) − W_z sin(α − θ)", "(11)"),
        ("V_z = −V_g sin(α − θ) − W_z", "(15), corrected"),
        ("V_c = √(5γRT_0) ϱ(V_t, T, p̄)", "(16)"),
        ("y = h(x, Θ) = (V_g, V_z, α, V_c)", "(20d)"),
        ("C = ∂h/∂x = [0 1 0 0;  c_21 0 0 −1;  1 0 0 0;  c_41 0 c_43 c_44]", "(23), corrected"),
    ),
    "calibrated_airspeed": (
        ("ϱ(V_t, T, p̄) = √( [((1 + V_t²/(5γRT))^3.5 − 1) p̄ + 1]^(1/3.5) − 1 )", "(16)"),
        ("V_c = √(5γRT_0) ϱ(V_t, T, p̄)", ""),
    ),
    "atmosphere": (
        ("T = T_0 + L z,  p̄ = (1 + (L/T_0) z)^(−g/(RL))", "below (16)"),
    ),
    "step1": (
        ("r⁽ⁱ⁾_α,k = α⁽ⁱ⁾_m,k − α̂_k|k−1,  r⁽ⁱ⁾_vc,k = V⁽ⁱ⁾_c,m,k − V̂_c,k|k−1,  i = 1, 2, 3", "(17)"),
        ("J⁽ⁱ⁾_k = √( 1/N_eval Σ_j=k−N_eval+1..k (r⁽ⁱ⁾_j)² )", "(18)"),
        ("sensor i is faulty if J⁽ⁱ⁾_k > J_th for n_D frames", ""),
    ),
    "step2": (
        ("α_m,k = Σ_i β⁽ⁱ⁾_k α⁽ⁱ⁾_m,k,  over the sensors that are used", "(19)"),
        ("β⁽ⁱ⁾_k = 1/(J⁽ⁱ⁾_k)² / Σ_j 1/(J⁽ʲ⁾_k)²;  likewise V_c", ""),
    ),
    "configuration": (
        ("I    N^f_α < 3, N^f_v < 3    y_m = (V_g, V_z, α, V_c)", "Table I"),
        ("II   N^f_α = 3, N^f_v < 3    y_m = (V_g, V_z, V_c)", ""),
        ("III  N^f_α < 3, N^f_v = 3    y_m = (V_g, V_z, α)", ""),
        ("IV   N^f_α = 3, N^f_v = 3    y_m = (V_g, V_z)", ""),
    ),
    "step3": (
        ("min  ½‖Δx_l‖²_P⁻¹ + ½ Σ ‖r_u,i − Δu_i‖²_Q⁻¹", "(42a)"),
        ("     + ½ Σ ‖r_y,i − C_i Δx_i‖²_R⁻¹", ""),
        ("Δx_i+1 = f_i + A_i Δx_i + B_i Δu_i", "(42b)"),
        ("Δu^LB_i ≤ Δu_i ≤ Δu^UB_i,  Δx^LB_i ≤ Δx_i ≤ Δx^UB_i", ""),
        ("solved by Algorithm 1;  x̂_i|k = x̂_i|k−1 + Δx_i|k,  û_i|k = û_i|k−1 + Δu_i|k", ""),
    ),
    "linearisation": (
        ("r_u,i = −û_i|k−1,  r_y,i = y_m,i − h(x̂_i|k−1, Θ_i)", "below (42)"),
        ("A_i = ∂F/∂x,  B_i = ∂F/∂u,  C_i = ∂h/∂x  at (x̂_i|k−1, û_i|k−1, Θ_i)", ""),
        ("f_i = F(x̂_i|k−1, û_i|k−1, Θ_i) − x̂_i+1|k−1", "corrected"),
    ),
    "linearised_output": (
        ("r_y,i = y_m,i − h(x̂_i|k−1, Θ_i),  C_i = ∂h/∂x", "below (42)"),
        ("the third, fourth row of C_i is 0 when all sensors of α, of V_c are lost", "V-C"),
    ),
    "transition": (
        ("f_α = −A_x sin α + A_z cos α + g cos(α − θ),  f_v = A_x cos α + A_z sin α + g sin(α − θ)", "below (9)"),
        ("dα/dt = f_α/V_g + q + u_α", "(13)"),
        ("dV_g/dt = f_v + u_v", "(14)"),
        ("x_i+1 = x_i + t_s (dx/dt)_i = F(x_i, u_i, Θ_i);  the wind: w_i+1 = w_i + t_s u_w,i", "(20a) to (20c)"),
        ("A = ∂F/∂x = [1 − t_s f_v/V_g 0 0 0;  t_s f_α 1 0 0;  0 0 1 0;  0 0 0 1],  B = t_s I", "(23)"),
    ),
    "room": (
        ("Δx^LB_i = x^LB − x̂_i|k−1,  Δx^UB_i = x^UB − x̂_i|k−1;  likewise Δu", "below (42)"),
    ),
    "interior_point": (
        ("min  ... + κ φ(Δu, Δx),  φ = −Σ log(Δ^UB − Δ) − Σ log(Δ − Δ^LB)", "(43), (44)"),
        ("linearise (46);  Δ²x, Δ²u by Algorithm 2;  s by the line search", "Algorithm 1"),
        ("(Δx⁻, Δu⁻) ← (Δx⁻, Δu⁻) + s (Δ²x, Δ²u)", ""),
        ("κ ← 0.1 κ  when j + 1 is a multiple of n_QP", "corrected"),
    ),
    "barrier": (
        ("d_1 = Δ^UB − Δ⁻,  d_2 = Δ⁻ − Δ^LB,  entry by entry, j = 1 to 4", "corrected"),
        ("g = ∇φ = 1/d_1 − 1/d_2", "(46a)"),
        ("L = diag √(∇²φ) = diag √(1/d_1² + 1/d_2²)", "(46b)"),
    ),
    "newton_transition": (
        ("r_p,i = −f_i − A_i Δx⁻_i − B_i Δu⁻_i + Δx⁻_i+1", "(46c)"),
        ("r̄_u,i = Q̄_i (Q⁻¹ (r_u,i − Δu⁻_i) − κ g_u,i)", "(46d), corrected"),
        ("Q̄_i = (Q⁻¹ + κ Lᵀ_u,i L_u,i)⁻¹", "(46f)"),
    ),
    "newton_output": (
        ("r̄_y,i = [r_y,i − C_i Δx⁻_i; −√κ L⁻¹_x,i g_x,i],  C̄_i = [C_i; √κ L_x,i]", "(46e), corrected"),
        ("R̄_i = diag(R_i, I)", "(46f)"),
    ),
    "stage": (
        ("measurement_update (lines 4, 5, 13), then time_update (lines 7, 15, 16)", "Algorithm 2"),
    ),
    "measurement_update": (
        ("Π_i ← C̄_i P̂_i,  Ξ_i ← (R̄_i + Π_i C̄ᵀ_i)⁻¹,  Ω_i ← C̄ᵀ_i Ξ_i", "line 4"),
        ("K_i ← P̂_i Ω_i,  P^f_i ← P̂_i − K_i Π_i", "line 5"),
        ("r̆_i ← r̄_y,i − C̄_i Δ²x̂_i,  Δ²x'_i ← Δ²x̂_i + K_i r̆_i", "line 13"),
    ),
    "time_update": (
        ("P̂_i+1 ← A_i P^f_i Aᵀ_i + B_i Q̄_i Bᵀ_i", "line 7"),
        ("Δ²u'_i ← r̄_u,i,  Δ²x̂_i+1 ← −r_p,i + A_i Δ²x'_i + B_i Δ²u'_i", "lines 15, 16"),
    ),
    "backward_stage": (
        ("ξ_i ← Aᵀ_i λ_i,  Δ²u_i ← Δ²u'_i − Q̄_i Bᵀ_i λ_i", "line 22"),
        ("Δ²x_i ← Δ²x'_i − P^f_i ξ_i", "line 23"),
        ("λ_i−1 ← ξ_i − Ω_i (r̆_i + Π_i ξ_i),  i > l", "lines 24, 25, corrected"),
    ),
    "line_search": (
        ("s = max { 2^−n | Δ^LB < Δ⁻ + 2^−n Δ² < Δ^UB,", "corrected"),
        ("          every entry of x and u, 0 ≤ n ≤ n_s^max },  or 0", ""),
    ),
}
"""By sheet: lines of formula, and the number that the paper gives it; none for a sheet that the paper leaves open."""


def aligned(lines: Sequence[tuple[str, str]]) -> str:
    """The lines as text, the paper's numbers before them; what is too wide for a page goes on below."""
    before = max(len(number) for _, number in lines)
    text = []
    for formula, number in lines:
        parts = [""]
        for piece in re.split(r"(?<=[,;])  ", formula):
            joined = f"{parts[-1]}  {piece}" if parts[-1] else piece
            if parts[-1] and cell_len(joined) > WIDTH - before:
                parts.append(piece)
            else:
                parts[-1] = joined
        text += [f"{label:{before}}   {part}" for label, part in zip_longest([number], parts, fillvalue="")]
    return "\n".join(text)
