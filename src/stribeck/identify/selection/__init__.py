"""Which law the data support: nested laws fitted alike, compared on held-out data.

`select.select` compares laws; its result has a `candidate` a law, and their `paired_test`;
`nesting` has one law's answer as a point of another's, `laws_asked` what is refused before a log is
read, and `free_curve` what the recommended law is held against.
"""
