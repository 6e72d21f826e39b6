"""From data to parameters: search or force balance, validation, cards."""
