#!/usr/bin/env python3
"""What results of import sagitta hold: each against the program, against numbers of NumPy, or against itself.

usage: results_test.py PROGRAM      (with the module on PYTHONPATH)
"""
import json
import os
import sys
import unittest

import numpy as np
import pandas

import module_test
import sagitta
from module_test import KR270, FolderTest

JOINTS = ["q%d_deg" % j for j in range(1, 7)]


class Plans(unittest.TestCase):
    def assert_rows_are_the_plan(self, plan):
        stated, rows = plan.to_dataframe(), plan.rows.to_dataframe()
        pandas.testing.assert_frame_equal(rows[stated.columns], stated)
        self.assertEqual(plan.rows.configurations, list(stated["config"].unique()))
        np.testing.assert_allclose(np.degrees(plan.rows.joint_values), stated.drop_duplicates("config")[JOINTS],
                                   rtol=1e-14, atol=1e-12)
        self.assertTrue(np.isnan(plan.rows.points_m).all())  # nothing is measured yet

    def test_rows_are_those_of_the_plan(self):
        experiment = sagitta.read(KR270 / "experiment.yaml")
        estimate = sagitta.calibrate(experiment)
        for options in ({"pool": 60}, {"pool": 60, "augment": True}, {"candidates": experiment}):
            plan = sagitta.plan(experiment, poses=6, **options)
            self.assert_rows_are_the_plan(plan)
            again = sagitta.read(KR270 / "robot.yaml", plan.rows, points_required=False, sigma_mm=0.1)
            self.assertEqual(again.configurations, plan.rows.configurations)
            np.testing.assert_array_equal(sagitta.predict(estimate, plan.rows).points_m,
                                          sagitta.predict(estimate, plan.to_dataframe()).points_m)
            self.assertEqual(sagitta.simulate(again, estimate).configurations, plan.rows.configurations)
            with self.assertRaises(sagitta.InputError):
                sagitta.validate(estimate, plan.rows)

    def test_poses_that_are_measured_more_than_once(self):
        frame = sagitta.read(KR270 / "experiment.yaml").to_dataframe()
        later = frame.assign(x_mm=frame["x_mm"] + 0.01)
        for first, second in (({"visit": "a"}, {"visit": "b"}), ({"repeat": "1"}, {"repeat": "2"}), ({}, {})):
            rows = pandas.concat([frame.assign(**first), later.assign(**second)])
            plan = sagitta.plan(sagitta.read(KR270 / "robot.yaml", rows, sigma_mm=0.1), poses=6, pool=60)
            self.assert_rows_are_the_plan(plan)
            self.assertEqual(len(plan.rows), 6 * 6)


class Diagnoses(FolderTest):
    def test_predictions_are_those_of_the_programs_estimate(self):
        """The readings have an encoder's wave that no model may have: rest and model error are there."""
        frame = sagitta.read(KR270 / "experiment.yaml").to_dataframe()
        for axis, phase in zip("xyz", (0.0, 0.7, 1.9)):
            frame["%s_mm" % axis] += 0.3 * np.sin(5 * np.radians(frame["q1_deg"]) + phase)
        frame.to_csv(self.folder / "rows.csv", index=False)
        (self.folder / "experiment.yaml").write_text(
            "schema: sagitta/experiment/1\nrobot: %s\nmeasurements: [rows.csv]\nnoise: {sigma_mm: 0.02}\n"
            % (KR270 / "robot.yaml"))
        module_test.run("diagnose", self.folder / "experiment.yaml", "--out=%s" % self.folder, "--quiet")
        diagnosis, theirs = sagitta.diagnose(sagitta.read(self.folder / "experiment.yaml")), self.folder / "estimate.json"
        self.assertGreater(json.loads(theirs.read_text())["model_error"]["rest_mm"], 0.05)
        ours, written = [sagitta.predict(known, frame) for known in (diagnosis, theirs)]
        np.testing.assert_array_equal(ours.covariance_m2, written.covariance_m2)
        self.assertEqual(len(ours.warnings), len(written.warnings))
        ours, written = [sagitta.validate(known, frame).after for known in (diagnosis, theirs)]
        self.assertEqual(ours, written)
        changed = [sagitta.changed(known, theirs).to_dict() for known in (diagnosis, theirs)]
        self.assertEqual(*map(module_test.without_circumstances, changed))


class Programs(FolderTest):
    KRL = b"DEF P( )\r\nPTP {A1 5,A2 -90,A3 95,A4 0,A5 10,A6 -3.5}\r\nEND\r\n"

    def corrected(self, name, text, estimate=None, **scene):
        path = self.folder / name
        path.write_bytes(text)
        estimate = estimate or sagitta.calibrate(sagitta.read(KR270 / "experiment.yaml"))
        return sagitta.compensate_program(estimate, path, **scene)

    def test_the_program_itself_is_kept(self):
        corrected = self.corrected("p.src", self.KRL)
        (self.folder / "link.src").symlink_to(self.folder / "p.src")
        os.link(self.folder / "p.src", self.folder / "same.src")
        for name in ("p.src", "link.src", "same.src"):
            with self.assertRaises(sagitta.InputError) as raised:
                corrected.write(self.folder / name)
            self.assertEqual(raised.exception.key, "path")
            self.assertEqual((self.folder / name).read_bytes(), self.KRL)
        corrected.write(self.folder / "new.src")
        self.assertNotEqual((self.folder / "new.src").read_bytes(), self.KRL)


if __name__ == "__main__":
    module_test.PROGRAM = sys.argv.pop(1)
    unittest.main()
