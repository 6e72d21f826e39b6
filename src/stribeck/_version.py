"""The version of the package, for whatever records it."""

__version__ = "0.1.0"
