"""From a file to a `Recording`: a reader a format, columns to channels, repairs that are told.

`read.read` reads any; `assembly.assembled` makes channels of a table;
`columns.mapping` is a map from channels to columns, and a format gives a
`raw_table`.
"""
