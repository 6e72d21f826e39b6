"""From a file to a `Recording`: a reader a format, columns to channels, repairs that are told.

`read.read` reads any: a `log_path` names its files, `opening` opens them, `registry.opened` each by
its reader, as a `log_file` whose samples come as a `raw_table` a clock; several files of one run
are a `joined_run`. `file_bytes` are what a file is of. `log_contents` lists its
channels; `heads`, `log_map` and `column_map` say which column is which channel, and
`assembly.assembled` makes a recording's arrays of them.
A `choice` is a column with its unit, as `heads` say it. `budget` says what a read may take.
"""
