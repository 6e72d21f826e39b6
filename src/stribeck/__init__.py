"""From a motion log to a friction model you can trust."""

__version__ = "0.1.0"
