"""Simulated plants: what the estimators of the papers that need no aircraft are run on."""
