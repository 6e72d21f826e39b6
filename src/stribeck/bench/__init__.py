"""Comparisons of search methods: problems, campaigns, statistics, tables and figures."""
