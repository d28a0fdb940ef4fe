"""Plain numpy references of paper 003's estimators, to be read beside it.

Wan, Keviczky: Real-time nonlinear moving horizon observer with pre-estimation for aircraft sensor fault detection and
estimation, International Journal of Robust and Nonlinear Control. The road of a frame: `inputs` (missing samples,
start), then `mho_pe` (Algorithm 1; with L = 0 it is MHO-woD), `mho_wd` or `ekf`, around `estimator`; `fault_detection`
judges their angle of attack. N counts transitions: a window has N + 1 samples. Units are the paper's: rad, kt, s.
`docs/corrections.md` says where the paper is corrected and what it leaves open.
"""
