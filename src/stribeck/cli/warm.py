"""The command that compiles beforehand."""

from __future__ import annotations

import typer

from ..errors import InputError
from .inputs import Json


def warm(json: Json = False) -> None:
    """Compile everything, for an image or CI; else each command compiles what it needs, once."""
    from ..compensate import closed_loop, limit_cycle
    from ..compile_cache import tally
    from ..data import motion_path, segmentation
    from ..friction import LAWS
    from ..identify.balance import variable_projection
    from ..rig import RIGS, balanced
    from ..rig.motion import coupled_motions, force_imbalance, spring_motion, stiff_slide
    from ..rig.twin import TestBed

    # Modules compile as they are imported, laws and rigs as they are taken, the test bed as it runs.
    del closed_loop, limit_cycle, motion_path, segmentation, variable_projection
    del balanced, coupled_motions, force_imbalance, spring_motion, stiff_slide
    list(LAWS.values()), list(RIGS.values())
    TestBed(loop="sensors", speed=1.0).run("up")
    if tally.compiled and not tally.kept:
        raise InputError(f"nothing was kept: {tally.path} cannot be written")
    if json:
        from ..report.format import json_text

        entries = {"compiled": tally.compiled, "loaded": tally.loaded, "seconds": tally.seconds}
        typer.echo(json_text({**entries, "folder": str(tally.path)}), nl=False)
    elif not tally.compiled:
        typer.echo(f"all {tally.loaded} functions are compiled, in {tally.path}")
    else:
        every = tally.compiled + tally.loaded
        typer.echo(
            f"{tally.compiled} of {every} functions compiled in {tally.seconds:.1f} s, "
            f"into {tally.path}"
        )
