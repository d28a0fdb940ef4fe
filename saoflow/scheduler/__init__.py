"""Causality and order, the frame program, execution, operation counts and budgets."""
