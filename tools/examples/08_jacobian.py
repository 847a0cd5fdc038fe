"""The identification Jacobian: which poses would make the parameters most certain together? usage: 08_jacobian.py FOLDER
with experiment.yaml"""
import sys

import numpy as np

import sagitta

SIGMA = 1e-4  # m, of the readings to come
COUNT = 200

estimate = sagitta.calibrate(sagitta.read(sys.argv[1] + "/experiment.yaml"))
own = estimate.linearize(whiten=True)  # the rows that were fitted, in units of their noise
scale = np.linalg.norm(own.jacobian, axis=0)  # parameters are in m and rad
information = (own.jacobian / scale).T @ (own.jacobian / scale)

random = np.random.default_rng(1)
q_deg = np.array([0, -90, 90, 0, 0, 0]) + random.uniform(-60, 60, (COUNT, 6))
candidates = {"config": np.arange(COUNT), "marker": ["P1"] * COUNT, "q_deg": q_deg}
at = estimate.linearize(candidates)  # nothing is measured there: at.residuals are nan
blocks = (at.jacobian / scale / SIGMA).reshape(COUNT, 3, -1)

for _ in range(5):  # det(M + J'J) = det(M) det(1 + J inv(M) J')
    gains = [np.linalg.det(np.eye(3) + j @ np.linalg.solve(information, j.T)) for j in blocks]
    best = int(np.argmax(gains))
    information += blocks[best].T @ blocks[best]
    print("pose %d: %s deg, sigmas together smaller by %.3f" % (
        best, np.round(q_deg[best], 1), gains[best] ** (-0.5 / len(at.names))))
