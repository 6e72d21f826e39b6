"""From recordings to a fitted law: by output error, or by force balance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ..constant import Stated
from ..data.alignment import Delay, checked_delay
from ..data.log_list import Columns, Logs
from ..friction import Law
from ..rig import Rig
from ..rig.lookup import rig_and_law
from .data_split import data_split, steady_tables
from .loss import Breakaway, Loss
from .output_error import solve_output_error
from .parameters import partition
from .request import checked_request
from .result import Fit
from .search_repeats import Progress
from .uncertainty.posterior import posterior as draw_posterior
from .uncertainty.posterior import sampler

if TYPE_CHECKING:
    from ..data.ranges import Range
    from .balance.velocity_source import VelocitySource


def identify(
    logs: Logs,
    *,
    rig: str | Rig,
    law: str | Law | None = None,
    units: Mapping[str, str] | None = None,
    columns: Columns = None,
    subtract: str | None = None,
    constants: Mapping[str, Stated] | None = None,
    exact: bool = False,
    method: str | None = None,
    train: Sequence[Range | str] | Range | str | None = None,
    holdout: Sequence[Range | str] | Range | str | None = None,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    tie: Mapping[str, str] | None = None,
    seed: int | None = None,
    budget: int | None = None,
    repeats: int | None = None,
    target: float | None = None,
    polishing: bool | None = None,
    settings: Mapping[str, Any] | None = None,
    loss: Loss = "squares",
    restart: bool = False,
    delay: Delay = "auto",
    velocity: VelocitySource = "auto",
    breakaway: Breakaway = "auto",
    bootstrap: int = 0,
    posterior: int = 0,
    progress: Progress | None = None,
) -> Fit:
    """Identify the friction of an axis.

    On a rig that is simulated (`slide-bed`) repeats of a search run in lockstep on the output
    error J (4.5), and least squares polishes each answer of a method that does not do so itself.
    On a rig with a measured force (`emps`, `forced`) the force balance is solved by least
    squares, which leaves nothing to search: `method`, `seed`, `budget`, `repeats` and `target` do
    not apply there.

    Args:
        logs: One or several logs of the axis: recordings, paths of files, frames of polars or
            pandas, or dicts of columns.
        rig: A rig or its name; `RIGS` lists them, and `check` says what a log is good enough for.
        law: A law or its name; by default the rig's first.
        units: Unit by column, as in `{"t": "s", "x": "mm"}`, where the heads of files and frames
            do not say it.
        columns: Column by channel, as in `{"position": "x"}`, where the heads do not say it.
        subtract: The column of a known force, a rigid-body torque say, that is taken off the
            measured one.
        constants: Constants of the rig that are this axis's, in the units the rig shows: a number
            is exact, `(20, 5)` has a tolerance, as `Rig.set` takes them.
        exact: Whether the other constants are this axis's, too, without a tolerance.
        method: A search method; `mbts` by default. It ends by itself once it has settled.
        train: Ranges to train on; everything by default.
        holdout: Ranges to validate on.
        fixed: Parameters to hold, in the units the rig shows.
        bounds: Search ranges that replace the rig's, in the units the rig shows.
        tie: Parameters that equal others, as in `{"F_V-": "F_V+"}`.
        seed: Seed of all repeats; 0 by default.
        budget: Evaluations of the cost for each repeat, polishing included; 8,000 by default.
            `mbts` settles sooner, as a rule; on a smooth motion it spends as many before on the
            richest law of ten parameters and more that the law contains.
        repeats: Independent searches; 3 by default.
        target: Stop a search at this J, in the unit in which the rig shows positions.
        polishing: Whether least squares polishes what a search found; by default it does, but for
            `mbts`, which does that itself.
        settings: Settings of the search method.
        loss: `squares` of the position errors, or their `absolute` size; see `Objective`.
        restart: Whether the simulation starts anew at every rest; see `Objective`.
        delay: Of the force (the command, where the motion is commanded) after the motion in the
            logs, s, negative where it is ahead. On a rig with a measured force, `auto` looks for
            one and moves the force where it is certain, and `off` tells it alone; elsewhere it is
            told. A number moves it, exactly; of a pair the second is the tolerance. Intervals hold
            what it may be: half a sample where nothing is said.
        velocity: `recorded`, of the `position`, or `auto`: of force balances, where a log has a
            velocity, the one that leaves less of the force.
        breakaway: `common` to all slips, `scattered` from slip to slip, or `auto`, as the log
            shows it; see `Objective`.
        bootstrap: Data sets of a block bootstrap of the residuals, whose intervals then stand
            beside those of the profiles; none by default, 200 are usual.
        posterior: Samples of the posterior, which then stands beside them; none by default,
            20,000 are usual. It needs the extra `posterior`.
        progress: Called with the searches after every step.

    Raises:
        InputError: something asked for cannot be done with these recordings.
    """
    rig, law = rig_and_law(rig, law, constants, exact=exact)
    search = {
        "method": method, "seed": seed, "budget": budget, "repeats": repeats, "target": target,
        "polishing": polishing, "settings": settings or None,
    }  # fmt: skip
    objective, searching = checked_request(
        rig, law, search=search, fixed=fixed, bounds=bounds, tie=tie, loss=loss, restart=restart,
        delay=delay, velocity=velocity, breakaway=breakaway, bootstrap=bootstrap,
        posterior=posterior,
    )  # fmt: skip
    data = data_split(logs, train, holdout, rig, units=units, columns=columns, subtract=subtract)
    rig = rig.behind(data.recordings)
    if posterior:
        sampler()  # says at once if it is not there
    parameters = partition(rig, law, fixed=fixed, bounds=bounds, tied=tie, objective=objective)
    if rig.approach == "force_balance":
        # Compiled code that others need not load.
        from .balance.force_balance import solve_balance  # noqa: PLC0415
        from .balance.run_balance import solve_runs  # noqa: PLC0415

        if steady_tables(data.recordings, data.ranges, delay, velocity):
            fit = solve_runs(parameters, data, draws=bootstrap)
        else:
            fit = solve_balance(parameters, data, draws=bootstrap, delay=delay, velocity=velocity)
    else:
        said = checked_delay(delay)
        if not isinstance(said, str):
            seconds, known = said
            data = replace(data.advanced(rig, seconds), delay_known=known)
        fit = solve_output_error(parameters, data, searching, draws=bootstrap, progress=progress)
    return _sampled(fit, posterior, 0 if seed is None else seed)


def _sampled(fit: Fit, samples: int, seed: int) -> Fit:
    """The fit with the posterior about it, if samples are wanted and nobody has interrupted."""
    if not samples or fit.search.ended == "interrupted":
        return fit
    try:
        drawn = draw_posterior(fit.residuals, fit.uncertainty.x, samples=samples, seed=seed)
    except KeyboardInterrupt:
        note = "interrupted: the posterior was not sampled"
        search = replace(fit.search, ended="interrupted")
        return replace(fit, search=search, warnings=(note, *fit.warnings))
    unsettled = "the posterior's walkers have not settled: ask for more samples"
    warnings = fit.warnings if drawn.settled else (*fit.warnings, unsettled)
    return replace(fit, posterior=drawn, warnings=warnings)
