"""A fit as data: what its page and its figures show, and the file of it, `report.json`.

`gather.Contents` has it all: the report of the `schema`, and the finer lines of `motion_traces`
and `law_curve` that figures for print draw, within a `frame`. `decimation` thins lines.
"""
