"""A fit as one page that needs no network: its tables, and the script that draws its plots.

`html_page` writes it from a report, or from a folder that has one.
"""
