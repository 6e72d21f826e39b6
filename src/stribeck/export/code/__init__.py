"""Law and compensator as source code: one translation from Python, one file a language.

`law_program` has the functions that every language prints, by the `translation` of Python
functions, each a `function_source`; a language is a `Dialect` (how expressions and statements are
written) and a function of a model that makes its files, listed in `export/targets.py`. By `c` any
functions become C: co-simulation units have the stepper of `rig.motion` by it.
"""
