"""From data to parameters: search or force balance, validation, cards.

The package can be called: `stribeck.identify(recordings, ...)` is the function of that name in
`fit`. Python would otherwise find the one or the other, depending on what was imported first.
"""

import inspect
import sys
from types import ModuleType
from typing import Any


class _Package(ModuleType):
    """A package that is called like the function it is named after."""

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        from .fit import identify  # noqa: PLC0415 - the package must not import itself whole

        return identify(*args, **kwargs)

    @property
    def __signature__(self) -> inspect.Signature:
        from .fit import identify  # noqa: PLC0415 - the same

        return inspect.signature(identify)


sys.modules[__name__].__class__ = _Package
