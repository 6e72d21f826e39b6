"""The EMPS slide identified by six lines of NumPy and SciPy, as one writes it without a tool."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat
from scipy.signal import butter, decimate, filtfilt

LOG = Path(__file__).parents[2] / "shared" / "data" / "emps" / "DATA_EMPS.mat"


def fitted() -> dict[str, Any]:
    """Mass, viscous and Coulomb friction and offset, SI, their standard errors, and the misfit."""
    begun = time.process_time()
    log = loadmat(LOG, squeeze_me=True)
    q = filtfilt(*butter(4, 0.2), log["qm"])  # 100 Hz at 1 kHz
    v, a = np.gradient(q, 1e-3), np.gradient(np.gradient(q, 1e-3), 1e-3)
    columns = a, v, np.sign(v), np.ones_like(v), log["gtau"] * log["vir"]
    *W, force = (decimate(c, 10) for c in columns)
    x, squares, *_ = np.linalg.lstsq(np.column_stack(W), force)
    seconds = time.process_time() - begun
    covariance = np.linalg.inv(np.column_stack(W).T @ np.column_stack(W))
    errors = np.sqrt(squares / (len(force) - len(x)) * np.diag(covariance))
    return {
        "values": x.tolist(),
        "errors": errors.tolist(),
        "misfit": 100 * float(np.sqrt(squares[0]) / np.linalg.norm(force)),
        "processor_seconds": seconds,
    }
