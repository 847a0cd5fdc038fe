"""From a CSV file to plots. usage: 05_plots.py FOLDER with robot.yaml and geometric.csv; writes two PNG files"""
import sys

import matplotlib

matplotlib.use("Agg")  # to files, without a screen
import matplotlib.pyplot as plt
import numpy as np

import sagitta

folder = sys.argv[1]
estimate = sagitta.calibrate(sagitta.read(folder + "/robot.yaml", folder + "/geometric.csv", sigma_mm=0.1))
rows = estimate.residuals_dataframe()  # residuals.csv: the rows with prediction and residual

figure, (over_joint, histogram) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
for axis in "xyz":
    over_joint.plot(rows["q2_deg"], rows["res_%s_mm" % axis], ".", label=axis)
over_joint.set(xlabel="joint 2 (deg)", ylabel="measured − predicted (mm)")
over_joint.legend()
histogram.hist(estimate.whitened.ravel(), bins=30, density=True)
at = np.linspace(-4, 4, 200)
histogram.plot(at, np.exp(-(at**2) / 2) / np.sqrt(2 * np.pi))
histogram.set(xlabel="residual over its standard deviation", ylabel="density")
figure.savefig("residuals.png", dpi=120)

table = estimate.to_dataframe()
geometry = table[table.index.str.startswith("geometry/") & table["free"] & (table["unit"] == "mm")]
figure, bars = plt.subplots(figsize=(8, 4), layout="constrained")
value, low, high = geometry["value"], geometry["ci95_low"], geometry["ci95_high"]
bars.errorbar(value, geometry.index, xerr=(value - low, high - value), fmt="o", capsize=3)
bars.axvline(0, linewidth=0.5)
bars.set(xlabel="error with 95 % interval (mm)")
figure.savefig("parameters.png", dpi=120)
print(estimate.verdict)
