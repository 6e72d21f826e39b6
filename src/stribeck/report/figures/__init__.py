"""Figures: what a fit's figures show, as data, and how those are drawn as PNG and SVG.

`fit_figures.write_figures` draws them all. A figure is a `plot`, and the page draws the same ones:
`adequacy_plots`, `law_plots`, `log_plots`, `motion_plots`, `residual_plots`, `search_plots`;
that of a log has `overview_plots`.
Figures of other things than fits share their `style`.
"""
