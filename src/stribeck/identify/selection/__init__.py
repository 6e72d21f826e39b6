"""Which law the data support: nested laws fitted alike, compared on held-out data."""
