"""How long tests wait for an event that must come."""

#: Seconds after which it is missed, on a machine however loaded.
PATIENCE = 600.0
