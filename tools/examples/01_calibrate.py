"""From files to a calibrated robot. usage: 01_calibrate.py FOLDER with experiment.yaml"""
import sys

import sagitta

try:
    experiment = sagitta.read(sys.argv[1] + "/experiment.yaml", holdout=0.3)
    estimate = sagitta.calibrate(experiment, progress=print)
except sagitta.InputError as error:
    sys.exit("%s:%d: %s\nhint: %s" % (error.file, error.line, error, error.hint))

print(estimate.verdict)
print("on poses it has not seen: %.3f mm RMS, before %.3f mm" % (
    estimate.validation["distance_rms_mm"], estimate.validation["before"]["distance_rms_mm"]))
print(estimate["geometry/p_x1"])  # value with its unit, and its standard deviation
print(estimate.to_dataframe()[["value", "sigma", "unit"]].head())
estimate.write("results")  # estimate.json, robot.calibrated.yaml, residuals.csv, report.html
