"""Axis and friction as a co-simulation unit (FMI 2.0), with its C sources: `build.fmu`."""
