"""The site of these pages, as Sphinx builds it: `make site`.

It asks no other host: fonts are the reader's own, and search runs in the page.
"""

from importlib.metadata import version as installed

project = "stribeck"
author = "stribeck"
copyright = "stribeck, BSD-3-Clause"  # noqa: A001 - Sphinx's name for it
version = release = installed("stribeck")

extensions = ["myst_nb"]
exclude_patterns = ["data"]
source_suffix = {".md": "myst-nb", ".ipynb": "myst-nb"}
nb_execution_mode = "off"  # tools/notebooks.py runs them, and a test holds what they print
myst_heading_anchors = 4
myst_enable_extensions = ["dollarmath"]

html_theme = "furo"
html_title = "stribeck"
html_copy_source = False
html_show_sourcelink = False
nitpicky = True
