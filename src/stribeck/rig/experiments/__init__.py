"""Experiments that rigs can do: descriptions that a plan ranks.

An experiment is an `offer`. A rig offers those that it can do: `ramps`, `pushes`, `servo_goals`,
`commanded_strokes` and, where the force is measured, `imposed_motions`.
"""
