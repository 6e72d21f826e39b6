"""A fit as data: what its page and its figures show, and the file of it, `report.json`."""
