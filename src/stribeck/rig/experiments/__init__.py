"""Experiments that rigs can do: descriptions that a plan ranks."""
