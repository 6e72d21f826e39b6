"""Friction of a joint in a simulator's robot file: `mjcf.mjcf` and `urdf.urdf` patch the user's."""
