"""Figures of a fit as PNG and SVG."""
