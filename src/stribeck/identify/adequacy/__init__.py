"""Adequacy: what the residual forces of a fit show of what its model leaves out.

`residual_rows` holds them row by row, `equation_error` those of a fit by output error; `effects`
finds patterns in them that chance does not explain, in bins and along patterns with a name, each in
what others leave (`remainder`), those of an inertia without what noise of the acceleration makes of
them (`acceleration_error`);
`advice` widens intervals to hold what an effect would make of them, and says what would catch it;
`generalisation` holds the error of held-out data against that of training; `neighbours` are other
joints that move in a log.
"""
