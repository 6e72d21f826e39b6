"""From data to parameters: search or force balance, validation, cards.

`stribeck.identify` is this package and, as the public name, also the function in `fit`: which of
the two Python finds depends on what was imported first, so the package can be called too.
"""

import sys
from types import ModuleType
from typing import Any


class _Package(ModuleType):
    """A package that can be called like the function it is named after."""

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        from .fit import identify  # noqa: PLC0415 - the package must not import itself whole

        return identify(*args, **kwargs)


sys.modules[__name__].__class__ = _Package
