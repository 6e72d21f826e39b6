"""Friction of a joint in a simulator's robot file.

`mjcf.mjcf` and `urdf.urdf` patch the user's file, `usd.usd` lays a layer over the user's stage,
in the units of `usd_stage`.
"""
