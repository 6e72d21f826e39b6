"""Which experiment next: proposals ranked by the information that they would add.

`plan.plan` ranks the experiments that the rig of a card can do.
"""
