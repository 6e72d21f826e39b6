"""Force balance: friction, mass and offset by regression on a measured force.

`force_balance` solves, judges and scores one and makes the fit; `balance` is the solution itself
(`regression.System` of filtered `rows`, solved by `variable_projection`), and `force_residuals`
its residuals over the box of the parameters; `modelled_force` is what a model makes of a log, and
a law with states starts from `state_starts` on `settled_rows`, without the `sensor_bias` of the
position and with the `path_error` of its samples; `curve_prior` places the knots of a free curve
and says how smooth it is.
`training_rows` are the samples that count, and `synchronisation` brings force and motion of their
logs to one time, with a velocity of some `velocity_source`; `one_way` holds what an axis of one
direction cannot tell. `run_balance` does the same for a table of steady speeds.
"""
