"""Simulated motion: the compiled integrators, and the tracks that they run over.

`event_driven` is the slide bed's, `stiff_slide` that of one that creeps, by `stiff_step`s;
`implicit` steps everything else under one of its `drives`: `passage` from one sample to the next,
by the `drive_force` and the `velocity` that balances it, or by an `explicit_step`. A drive of parts
is one function that an `axis_row` names, made of those of its parts (`part_call`).
`spring_motion` is the exact motion of a mass that a force pushes on Maxwell elements.
`coupled_motions` are those of two masses, from a `coupled_start` by the `coupled_passage` of events
and steps, explicit or `coupled_implicit`, under the `coupled_rates` and the play of their
`coupling`.
`held_slip` is a slip of the slide bed under what its controller is known to have read;
`sampled_loop` is the loop of the test bed, with its sensors; `reference` is plain steps to compare
with, `force_imbalance` what a measured motion leaves of the equation of motion. They run over a
`track`, made of a log and its `command`, or for a search over one of fewer samples (`thinning`),
and deal their rows out over the `row_pool`.
"""
