"""Which experiment next: proposals ranked by the information that they would add."""
