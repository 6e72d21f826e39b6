"""Many axes: each identified once and kept, all in one table, and what changed since.

`manifest` reads which axes there are, `axis_job` is one of them as work for an engine, `axis_run`
does it, `fleet_store` keeps what came of it, `fleet_table` writes that, with the
columns of `table_columns`, and reads it as `table_check` has it; `fleet_run` is the whole.
"""
