"""How well the data know each parameter: profiles, bootstrap, posterior, verdicts.

`assessment.uncertainty` has everything about a fit, from the residuals that `residuals` describes;
`estimates` are its parameters one by one, with a `verdict` each. By themselves: `posterior` draws
samples, `blind_directions` words what the data hardly determine, `covariance` has quick errors and
autocorrelation, `linearisation` slopes at a fit, `profile` the likelihood along a parameter,
`sensitivity` and `profile_walk` name how their searches ended, `sensor_noise` is that of a log at
rest.
"""
