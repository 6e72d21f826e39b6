"""Friction compensation in a closed loop: compensator, simulation, the scale it may have."""
