"""Simulated motion: the compiled integrators, and the tracks that they run over."""
