"""`python -m stribeck` is the command line."""

from .cli import main

main()
