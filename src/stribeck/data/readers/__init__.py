"""From a file to a `Recording`: a reader a format, columns to channels, repairs that are told.

`read.read` reads any; `registry.opened` is a file as its reader opens it, a `log_file`, whose
samples come as a `raw_table` a clock; `assembly.assembled` makes channels of them, and `column_map`
says which column is which.
"""
