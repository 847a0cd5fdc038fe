#!/usr/bin/env python3
"""What results of import sagitta hold: each against the program, against numbers of NumPy, or against itself.

usage: results_test.py PROGRAM      (with the module on PYTHONPATH)
"""
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


if __name__ == "__main__":
    module_test.PROGRAM = sys.argv.pop(1)
    unittest.main()
