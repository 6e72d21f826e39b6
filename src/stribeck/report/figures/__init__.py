"""Figures: what a fit's figures show, as data, and how those are drawn as PNG and SVG."""
