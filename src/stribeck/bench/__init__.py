"""Which is better: problems and comparisons of search methods."""
