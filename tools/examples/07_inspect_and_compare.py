"""Look at the data, calibrate twice, and ask what changed. usage: 07_inspect_and_compare.py FOLDER with robot.yaml and
geometric.csv"""
import sys

import numpy as np
import pandas

import sagitta

folder = sys.argv[1]
robot = folder + "/robot.yaml"
rows = pandas.read_csv(folder + "/geometric.csv", comment="#")

inspection = sagitta.inspect(sagitta.read(robot, rows, sigma_mm=0.05))
for finding in inspection.findings:
    print(finding["severity"], finding["words"])
print(inspection.to_dataframe()[["expected_sigma", "unit", "identifiable"]].head())

before = sagitta.calibrate(sagitta.read(robot, rows, sigma_mm=0.05))
before.write("before")  # with report.html

# The zero of joint 3 slips by 0.4 mrad: the arm stands where it stood, and the controller says another angle.
rows["q3_deg"] -= np.degrees(4e-4)
after = sagitta.calibrate(sagitta.read(robot, rows, sigma_mm=0.05))
changed = sagitta.changed(before, after)
print(changed.words)
print(changed.to_dataframe())
assert [change["target"] for change in changed.changes] == ["A3"]
