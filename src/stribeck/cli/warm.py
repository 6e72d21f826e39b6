"""The command that compiles beforehand."""

from __future__ import annotations

import typer

from ..errors import InputError


def warm() -> None:
    """Compile everything, for an image or CI; else each command compiles what it needs, once."""
    from ..compensate import closed_loop
    from ..compile_cache import tally
    from ..data import segmentation
    from ..friction import LAWS
    from ..identify.balance import variable_projection
    from ..rig import RIGS, balanced
    from ..rig.motion import force_imbalance

    # Modules compile as they are imported, laws and rigs as they are taken.
    del closed_loop, segmentation, variable_projection, balanced, force_imbalance
    list(LAWS.values()), list(RIGS.values())
    if not tally.compiled:
        typer.echo(f"all {tally.loaded} functions are compiled, in {tally.path}")
    elif tally.kept:
        every = tally.compiled + tally.loaded
        typer.echo(
            f"{tally.compiled} of {every} functions compiled in {tally.seconds:.1f} s, "
            f"into {tally.path}"
        )
    else:
        raise InputError(f"nothing was kept: {tally.path} cannot be written")
