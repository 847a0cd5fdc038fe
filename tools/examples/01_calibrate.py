"""From files to a calibrated robot. usage: 01_calibrate.py FOLDER with experiment.yaml"""
import sys

import sagitta

try:
    experiment = sagitta.read(sys.argv[1] + "/experiment.yaml", holdout=0.3)
    estimate = sagitta.calibrate(experiment, progress=print)
except sagitta.InputError as error:
    sys.exit(str(error))  # with the place and a hint

print(estimate.verdict)
unseen = estimate.validation or estimate.cross_validation  # without holdout= the cross-validation alone
print("on poses it has not seen: %.3f mm RMS, before %.3f mm" % (
    unseen["distance_rms_mm"], unseen["before"]["distance_rms_mm"]))
print(estimate["geometry/p_x1"])  # value with its unit, and its standard deviation
print(estimate.to_dataframe()[["value", "sigma", "unit"]].head())
estimate.write("results")  # estimate.json, robot.calibrated.yaml, residuals.csv, report.html
