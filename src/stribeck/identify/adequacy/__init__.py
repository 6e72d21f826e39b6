"""Adequacy: what a residual shows of the forces that a model leaves out."""
