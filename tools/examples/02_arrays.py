"""Measurements as NumPy arrays: a two-link arm that is made up here, measured here, and found again."""
import numpy as np
import numpy.typing as npt

import sagitta

ROBOT = {
    "schema": "sagitta/robot/1",
    "joints": [{"name": "A1", "type": "revolute"}, {"name": "A2", "type": "revolute"}],
    "kinematics": {"chain": [{"Rz": "A1"}, {"Tx_mm": 350, "error": "length1"}, {"Ry": "A2"}, {"Tx_mm": 1250}]},
}
SIGMA = 0.02  # mm
Floats = npt.NDArray[np.float64]


def marker_at(q: Floats, length: float, marker: Floats) -> Floats:
    """Where the marker is, mm."""
    tilt = q[1]
    radius = length + np.cos(tilt) * (1250 + marker[0]) + np.sin(tilt) * marker[2]
    height = -np.sin(tilt) * (1250 + marker[0]) + np.cos(tilt) * marker[2]
    c, s = np.cos(q[0]), np.sin(q[0])
    return np.array([c * radius - s * marker[1], s * radius + c * marker[1], height])


random = np.random.default_rng(1)
q = random.uniform(-1.2, 1.2, (40, 2))  # rad
points = np.array([marker_at(row, 350.4, np.array([60.0, 20.0, 30.0])) for row in q])
points += SIGMA * random.standard_normal(points.shape)

experiment = sagitta.read(
    ROBOT,
    {"config": np.arange(40), "marker": ["M1"] * 40, "q_rad": q, "xyz_mm": points},
    noise={"sigma_mm": SIGMA},
    estimate={"geometry": ["length1"]},
)
estimate = sagitta.calibrate(experiment)
length = estimate["geometry/length1"]
print(length)  # 0.4 mm longer than the robot file says

residuals = 1e3 * estimate.residuals_m  # mm, one row per reading; the arrays of an estimate are in SI
print("RMS %.4f mm" % np.sqrt(np.mean(residuals**2)))
assert abs(residuals).max() < 6 * SIGMA
assert length.sigma is not None and abs(length.value - 0.4) < 4 * length.sigma
