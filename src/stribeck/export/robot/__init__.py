"""Friction in the robot files of simulators: MJCF and URDF."""
