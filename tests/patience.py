"""The longest wait of a test for an event that must come."""

#: Seconds, on a machine however loaded.
PATIENCE = 600.0
