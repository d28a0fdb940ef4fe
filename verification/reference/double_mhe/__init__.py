"""Plain numpy for paper 002: the convexified, linearised, double and nonlinear moving horizon estimators.

Written from the paper, with its equation numbers; dense matrices where the sheets use the tridiagonal structure.
"""
