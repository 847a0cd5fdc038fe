"""What is missing in the model? usage: 03_diagnose.py FOLDER with experiment.yaml and truth in it"""
import sys

import numpy as np
import pandas

import sagitta

folder = sys.argv[1]
rows = pandas.read_csv(folder + "/geometric.csv", comment="#")
truth = sagitta.calibrate(sagitta.read(folder + "/experiment.yaml"))

# An encoder of joint 3 that is 0.4 mrad off once per turn: poses are measured where the arm is, not where it says.
actual = rows.copy()
actual["q3_deg"] += np.degrees(4e-4) * np.cos(np.radians(rows["q3_deg"]))
measured = sagitta.simulate(sagitta.read(folder + "/robot.yaml", actual), truth, sigma_mm=0.02, seed=3).to_dataframe()
rows[["x_mm", "y_mm", "z_mm"]] = measured[["x_mm", "y_mm", "z_mm"]]

experiment = sagitta.read(folder + "/robot.yaml", rows, sigma_mm=0.02)
diagnosis = sagitta.diagnose(experiment)
print(diagnosis.verdict)
print(diagnosis.words)
print(diagnosis.to_dataframe())
