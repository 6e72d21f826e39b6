"""Friction compensation in a closed loop.

`compensator` defines what a controller adds to its command, `closed_loop` simulates it, and
`compensation` recommends its settings.
"""
