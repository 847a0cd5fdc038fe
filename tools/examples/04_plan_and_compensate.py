"""Which poses to measure next, and corrected joint values for targets. usage: 04_plan_and_compensate.py FOLDER"""
import sys

import numpy as np

import sagitta

folder = sys.argv[1]
experiment = sagitta.read(folder + "/experiment.yaml")
plan = sagitta.plan(experiment, poses=6, augment=True, pool=100)
plan.to_csv("plan.csv")  # a measurement file without x, y, z
print("poses to measure next:", ", ".join(plan.rows.configurations))

estimate = sagitta.calibrate(experiment)
targets = {"target": ["home", "weld"], "q_deg": np.array([[0, -90, 90, 0, 20, 0], [35, -60, 70, 10, 40, -15]])}
corrected = sagitta.compensate(estimate, targets)
frame = corrected.to_dataframe()
frame.to_csv("corrected.csv", index=False)
print(frame[["target", "status", "before_mm", "u95_mm"]])
print(np.degrees(corrected.joint_values))
assert corrected.status == ["ok", "ok"]
