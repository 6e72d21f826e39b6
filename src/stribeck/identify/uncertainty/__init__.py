"""How well the data know each parameter: profiles, bootstrap, posterior, verdicts."""
