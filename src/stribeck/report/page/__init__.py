"""A fit as one page that needs no network: its tables, and the script that draws its plots.

`fit_page` writes it of a fit, `html_page` from a report, or from a folder that has one;
`fit_tables` has its tables. `log_page` writes that of a log.
"""
