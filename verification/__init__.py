"""Numpy references, equivalence cases, recordings, sensor noise and faults."""
