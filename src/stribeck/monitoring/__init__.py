"""Statistical process control of a quantity that is estimated again and again.

`innovations` standardises what each new estimate differs by from those before it, `run_length` says
how long charts of such differences run until they raise an alarm, `control_chart` runs a CUSUM and
an EWMA whose limits are set by that, and `change` says by how much the quantity has changed.
"""
