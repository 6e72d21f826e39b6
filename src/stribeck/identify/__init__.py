"""From data to parameters: search or force balance, validation, cards.

`stribeck.identify` is the function of that name in `fit`; what is in this package is imported from
it, as in `from stribeck.identify.fit import identify`.
"""
