"""Look-up tables: breakpoints from a formula, the proof of their error, and their values to the bit."""
