"""Axis and friction as a co-simulation unit (FMI 2.0): `fmu.fmu` makes one, with its C sources."""
