#!/usr/bin/env python3
"""import sagitta against the program: the same numbers to the last digit; and what only Python can get wrong.

usage: module_test.py PROGRAM      (with the module on PYTHONPATH)
"""
import csv
import gc
import json
import os
import pathlib
import pickle
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np
import pandas

import sagitta

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
KR270 = ROOT / "problems" / "published" / "kr270"
PROGRAM = ""
# What says when and how a result was made, not what it is.
CIRCUMSTANCES = ("command", "seconds", "inputs", "run")


def run(*arguments):
    done = subprocess.run([PROGRAM] + [str(a) for a in arguments], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def without_circumstances(result):
    return {key: value for key, value in result.items() if key not in CIRCUMSTANCES}


def without_run(text):
    return "".join(line for line in text.splitlines(keepends=True) if not line.startswith("# run: "))


def without_command(html):
    """A page without what says when, how, and in how many seconds it was made."""
    html = re.sub(r"\d+\.\d+ s\b", "", html)
    lines = [line for line in html.splitlines() if "sagitta " not in line and "sagitta." not in line]
    assert len(lines) > 50, html[:500]
    return lines


def columns_of(path):
    with open(path, encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {name: [row[name] for row in rows] for name in rows[0]}


class FolderTest(unittest.TestCase):
    maxDiff = 2000

    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self._folder.name)

    def tearDown(self):
        self._folder.cleanup()


class SameAsTheProgram(FolderTest):
    def assert_same_pictures(self, page, path):
        """The numbers that the pictures of two pages draw."""
        pictures = [re.findall(r'<script type="application/json">(.*?)</script>', text, re.S)
                    for text in (page, path.read_text())]
        self.assertTrue(pictures[0])
        self.assertEqual(*pictures)

    def test_calibrate_and_write(self):
        run("calibrate", KR270 / "experiment.yaml", "--out=%s" % (self.folder / "program"), "--quiet")
        estimate = sagitta.calibrate(sagitta.read(KR270 / "experiment.yaml"))
        estimate.write(self.folder / "python")
        ours, theirs = [json.loads((self.folder / who / "estimate.json").read_text()) for who in ("python", "program")]
        self.assertEqual(without_circumstances(ours), without_circumstances(theirs))
        self.assertEqual([i["sha256"] for i in ours["inputs"]], [i["sha256"] for i in theirs["inputs"]])
        for name in ("residuals.csv", "robot.calibrated.yaml"):
            ours, other = [(self.folder / who / name).read_text() for who in ("python", "program")]
            self.assertEqual(without_run(ours), without_run(other))
        self.assertEqual(without_circumstances(estimate.to_dict()), without_circumstances(theirs))
        first = theirs["parameters"][0]
        self.assertEqual(estimate[first["name"]].value, first["value"])
        frame = estimate.to_dataframe()
        self.assertEqual(list(frame["value"]), [row["value"] for row in theirs["parameters"]])
        residuals = estimate.residuals_dataframe()
        written = columns_of(self.folder / "program" / "residuals.csv")
        self.assertEqual(list(residuals["res_x_mm"]), [float(cell) for cell in written["res_x_mm"]])

    def test_nothing_held_out_is_no_perfect_robot(self):
        estimate = sagitta.calibrate(sagitta.read(KR270 / "experiment.yaml"))
        self.assertIsNone(estimate.validation)
        self.assertEqual(estimate.to_dict()["validation"]["observations"], 0)
        self.assertGreater(estimate.cross_validation["before"]["distance_rms_mm"],
                           estimate.cross_validation["distance_rms_mm"])
        held_out = sagitta.calibrate(sagitta.read(KR270 / "experiment.yaml", holdout=0.3))
        self.assertEqual(held_out.validation, held_out.to_dict()["validation"])
        self.assertGreater(held_out.validation["distance_rms_mm"], 0.0)

    def test_joint_values_are_those_of_configurations(self):
        experiment = sagitta.read(KR270 / "experiment.yaml")
        self.assertEqual(len(experiment.joint_values), len(experiment.configurations))
        self.assertEqual(len(experiment.points_m), len(experiment))

    def test_an_estimate_says_what_it_lacks(self):
        estimate = sagitta.calibrate(sagitta.read(KR270 / "experiment.yaml"))
        name = estimate.estimated[0]
        with self.assertRaisesRegex(KeyError, "did you mean .*%s" % name):
            estimate[name + "x"]
        with self.assertRaisesRegex(TypeError, "sagitta.load"):
            pickle.dumps(estimate)

    def test_flags(self):
        run("calibrate", KR270 / "robot.yaml", KR270 / "geometric.csv", "--sigma_mm=0.1", "--holdout=0.3", "--seed=5",
            "--fixed=geometry/p_x1", "--out=%s" % (self.folder / "program"), "--quiet")
        theirs = json.loads((self.folder / "program" / "estimate.json").read_text())
        experiment = sagitta.read(KR270 / "robot.yaml", KR270 / "geometric.csv", sigma_mm=0.1, holdout=0.3, seed=5,
                                  fixed=["geometry/p_x1"])
        self.assertEqual(without_circumstances(sagitta.calibrate(experiment, seed=5).to_dict()),
                         without_circumstances(theirs))
        self.assertGreater(theirs["validation"]["observations"], 0)

    def test_the_seed_is_that_of_the_experiments_own_holdout(self):
        text = (KR270 / "experiment.yaml").read_text()
        text = re.sub(r"(?m)^(robot: |measurements: \[)", lambda line: line[0] + "%s/" % KR270, text)
        path = self.folder / "experiment.yaml"
        path.write_text(re.sub(r"(?m)^validation:.*\n", "", text) + "validation: {fraction: 0.3, seed: 1}\n")
        held = []
        for seed in (None, 7):
            flags = [] if seed is None else ["--seed=%d" % seed]
            run("calibrate", path, "--out=%s" % (self.folder / "program"), "--quiet", *flags)
            theirs = json.loads((self.folder / "program" / "estimate.json").read_text())["validation"]
            ours = sagitta.calibrate(sagitta.read(path, seed=seed), seed=seed or 1).validation
            self.assertEqual(ours["distance_rms_mm"], theirs["distance_rms_mm"])
            held.append(ours["distance_rms_mm"])
        self.assertNotEqual(*held)

    def test_predict_validate_simulate_compensate(self):
        out = self.folder / "program"
        run("calibrate", KR270 / "experiment.yaml", "--out=%s" % out, "--quiet")
        estimate = sagitta.calibrate(sagitta.read(KR270 / "experiment.yaml"))
        run("predict", out / "estimate.json", KR270 / "geometric.csv", "--out=%s" % (out / "predicted.csv"))
        run("validate", out / "estimate.json", KR270 / "geometric.csv", "--out=%s" % (out / "validation"))
        run("simulate", KR270 / "robot.yaml", KR270 / "geometric.csv", "--truth=%s" % (out / "estimate.json"),
            "--sigma_mm=0.02", "--seed=9", "--out=%s" % (out / "simulated.csv"))
        targets = {"target": ["a", "b"], "q_deg": np.array([[10.0, -80, 90, 5, 20, 3], [-30.0, -60, 60, 0, 45, 0]])}
        (self.folder / "targets.csv").write_text(
            "target,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\na,10,-80,90,5,20,3\nb,-30,-60,60,0,45,0\n")
        run("compensate", out / "estimate.json", self.folder / "targets.csv", "--out=%s" % (out / "corrected.csv"))
        for known in (estimate, sagitta.load(out / "estimate.json"), out / "estimate.json"):
            prediction = sagitta.predict(known, KR270 / "geometric.csv")
            written = columns_of(out / "predicted.csv")
            frame = prediction.to_dataframe()
            for name in ("pred_x_mm", "psig_z_mm", "pcov_xy_mm2"):
                self.assertEqual(list(frame[name]), [float(cell) for cell in written[name]])
            np.testing.assert_allclose(1e3 * prediction.points_m[:, 0], frame["pred_x_mm"], rtol=1e-15)
            np.testing.assert_allclose(1e3 * np.sqrt(prediction.covariance_m2[:, 2, 2]), frame["psig_z_mm"], rtol=1e-12)
            corrected = sagitta.compensate(known, targets)
            written = columns_of(out / "corrected.csv")
            frame = corrected.to_dataframe()
            for name in ("q1_cmd_deg", "q6_cmd_deg", "x_cmd_mm", "u95_mm"):
                self.assertEqual(list(frame[name]), [float(cell) for cell in written[name]])
            self.assertEqual(corrected.status, written["status"])
            np.testing.assert_allclose(np.degrees(corrected.joint_values[:, 0]), frame["q1_cmd_deg"], rtol=1e-14)
        validation = json.loads((out / "validation" / "validation.json").read_text())
        ours = sagitta.validate(estimate, KR270 / "geometric.csv")
        self.assertEqual(ours.after, validation["validation"])
        self.assert_same_pictures(sagitta.validate(out / "estimate.json", KR270 / "geometric.csv").report_html,
                                  out / "validation" / "report.html")
        self.assertIn('class="picture"', ours.report_html)
        rows = sagitta.simulate(sagitta.read(KR270 / "robot.yaml", KR270 / "geometric.csv"), estimate, sigma_mm=0.02,
                                seed=9)
        rows.to_csv(self.folder / "simulated.csv")
        self.assertEqual((self.folder / "simulated.csv").read_text(), (out / "simulated.csv").read_text())

    def test_warnings(self):
        """What a command prints next to its figures is in `warnings`, and nothing else is."""
        out = self.folder / "program"
        run("calibrate", KR270 / "robot.yaml", KR270 / "geometric.csv", "--sigma_mm=0.02", "--out=%s" % out, "--quiet")
        known = json.loads((out / "estimate.json").read_text())
        known["model_error"]["factor"] = max(1.5, known["model_error"]["factor"])  # so that there is something to say
        estimate = self.folder / "estimate.json"
        estimate.write_text(json.dumps(known))
        beyond = {"q1_deg": [10.0, 170.0], "q2_deg": [-80.0, -20.0], "q3_deg": [90.0, 150.0], "q4_deg": [5.0, 300.0],
                  "q5_deg": [20.0, 110.0], "q6_deg": [3.0, 10.0]}
        for name, labels in (("poses", {"config": ["a", "b"], "marker": ["P1", "P1"]}), ("targets", {"target": ["a", "b"]})):
            pandas.DataFrame({**labels, **beyond}).to_csv(self.folder / (name + ".csv"), index=False)
        simulated = sagitta.simulate(sagitta.read(KR270 / "robot.yaml", self.folder / "poses.csv", points_required=False),
                                     estimate, sigma_mm=0.02, seed=3)
        simulated.to_csv(self.folder / "rows.csv")

        def assert_printed(warnings, printed):
            printed = " ".join(printed.split())
            for words in warnings:
                self.assertIn(words, printed)
            for words in ("outside the measured joint ranges", "carry the model error"):
                self.assertTrue(any(words in warning for warning in warnings), warnings)

        prediction = sagitta.predict(estimate, self.folder / "poses.csv")
        printed = run("predict", estimate, self.folder / "poses.csv", "--out=%s" % (out / "p.csv"))
        assert_printed(prediction.warnings, printed)
        self.assertEqual(["Warning: " + words for words in prediction.warnings[:-1]],
                         [line for line in printed.splitlines() if line.startswith("Warning: ")])
        self.assertEqual(sagitta.predict(out / "estimate.json", KR270 / "geometric.csv").warnings[:-1], [])
        assert_printed(sagitta.validate(estimate, self.folder / "rows.csv").warnings,
                       run("validate", estimate, self.folder / "rows.csv"))
        corrected = sagitta.compensate(estimate, self.folder / "targets.csv")
        assert_printed(corrected.warnings,
                       run("compensate", estimate, self.folder / "targets.csv", "--out=%s" % (out / "c.csv")))
        words = corrected.to_dataframe()["words"].fillna("")
        self.assertEqual(list(words), columns_of(out / "c.csv")["words"])
        self.assertIn("outside the measured joint ranges: A1 by ", words[1])

    def test_report(self):
        out = self.folder / "program"
        run("calibrate", KR270 / "experiment.yaml", "--out=%s" % out, "--quiet")
        estimate = sagitta.calibrate(sagitta.read(KR270 / "experiment.yaml"))
        estimate.write(self.folder / "python")
        ours = (self.folder / "python" / "report.html").read_text()
        self.assertEqual(without_command(ours), without_command((out / "report.html").read_text()))
        self.assertEqual(without_command(estimate.report_html), without_command(ours))

    def test_inspect(self):
        out = self.folder / "program"
        run("inspect", KR270 / "experiment.yaml", "--out=%s" % out, "--quiet")
        inspection = sagitta.inspect(sagitta.read(KR270 / "experiment.yaml"))
        theirs = json.loads((out / "inspect.json").read_text())
        self.assertEqual(without_circumstances(inspection.to_dict()), without_circumstances(theirs))
        self.assertEqual(inspection.serious, theirs["serious"])
        self.assertEqual(list(inspection.to_dataframe().index), [row["name"] for row in theirs["parameters"]])
        inspection.write(self.folder / "python")
        ours = (self.folder / "python" / "report.html").read_text()
        self.assertEqual(without_command(ours), without_command((out / "report.html").read_text()))

    def test_changed(self):
        estimates = []
        for name, shift in (("old", 0.0), ("new", 0.4e-3)):
            columns = columns_of(KR270 / "geometric.csv")
            # The zero of joint 3 has slipped: the arm stands where it says, plus 0.4 mrad.
            columns["q3_deg"] = np.array(columns["q3_deg"], dtype=float) - np.degrees(shift)
            estimates.append(sagitta.calibrate(sagitta.read(KR270 / "robot.yaml", columns, sigma_mm=0.05)))
            estimates[-1].write(self.folder / name)
        paths = [self.folder / name / "estimate.json" for name in ("old", "new")]
        run("changed", *paths, "--out=%s" % (self.folder / "changed"))
        theirs = json.loads((self.folder / "changed" / "changed.json").read_text())
        for old, new in (estimates, paths):
            self.assertEqual(without_circumstances(sagitta.changed(old, new).to_dict()), without_circumstances(theirs))
        changed = sagitta.changed(*estimates)
        self.assertEqual(changed.to_dataframe()["target"].tolist(), [change["target"] for change in theirs["changes"]])
        self.assertEqual([change["target"] for change in changed.changes], ["A3"], changed.words)
        self.assertAlmostEqual(changed.changes[0]["value"], 0.4, delta=0.02)

    def test_programs(self):
        out = self.folder / "program"
        run("calibrate", KR270 / "experiment.yaml", "--out=%s" % out, "--quiet")
        program = self.folder / "p.src"
        program.write_bytes(b"DEF P( )\r\nPTP {A1 5,A2 -90,A3 95,A4 0,A5 10,A6 -3.5} ; home \xe9\r\n"
                            b"LIN {X 1500,Y 0,Z 1500,A 0,B 90,C 0}\r\nPTP_REL {A1 1}\r\nEND\r\n")
        run("compensate", out / "estimate.json", "--program=%s" % program, "--program_out=%s" % (out / "p.src"),
            "--tools_mm_deg=default=0,0,100,0,0,90;flange=same", "--frames_mm_deg=world=same;default=same")
        scene = {"tools_mm_deg": {"default": (0, 0, 100, 0, 0, 90), "flange": "same"},
                 "frames_mm_deg": {"world": "same", "default": "same"}}
        corrected = sagitta.compensate_program(out / "estimate.json", program, **scene)
        self.assertEqual(corrected.text, (out / "p.src").read_bytes())
        corrected.write(self.folder / "new.src")
        self.assertEqual((self.folder / "new.src").read_bytes(), corrected.text)
        self.assertIn("points corrected", corrected.summary)
        self.assertEqual([point["line"] for point in corrected.untouched], [4])
        # A mass beyond what the arm carries: it bends an arm with compliances alone, and this one has none.
        loaded = sagitta.compensate_program(out / "estimate.json", program, loads_kg_mm={"default": (250, 0, 0, 90)},
                                            **scene)
        self.assertEqual(loaded.text, corrected.text)
        with self.assertRaises(sagitta.InputError):
            sagitta.compensate_program(out / "estimate.json", program, loads_kg_mm={"default": (250, 0)}, **scene)
        for joints, why in (((1, 4), "three joints"), ((1, 1, 6), "each once"), ((1, 4, 6), "FANUC")):
            with self.assertRaisesRegex(sagitta.InputError, why):
                sagitta.compensate_program(out / "estimate.json", program, turn_joints=joints, **scene)
        with self.assertRaises(sagitta.InputError) as raised:
            sagitta.compensate_program(out / "estimate.json", program)
        self.assertIn("world", str(raised.exception))
        with self.assertRaises(sagitta.InputError) as raised:
            sagitta.compensate_program(out / "estimate.json", program, load="V9", **scene)
        self.assertEqual(raised.exception.key, "load")

    def test_plan_and_diagnose(self):
        out = self.folder / "program"
        run("plan", KR270 / "experiment.yaml", "--poses=8", "--pool=60", "--out=%s" % out, "--quiet")
        plan = sagitta.plan(sagitta.read(KR270 / "experiment.yaml", points_required=False), poses=8, pool=60)
        plan.to_csv(self.folder / "plan.csv")
        self.assertEqual((self.folder / "plan.csv").read_text(), (out / "plan.csv").read_text())
        theirs = json.loads((out / "plan.json").read_text())
        self.assertEqual(plan.to_dict(), {k: v for k, v in theirs.items() if k not in ("version", "command")})
        self.assert_same_pictures(plan.report_html, out / "report.html")
        cell, former = self.folder / "cell.yaml", self.folder / "former.json"
        cell.write_text("schema: sagitta/cell/1\nfloor_mm: 900\n")
        estimate = sagitta.calibrate(sagitta.read(KR270 / "experiment.yaml"))
        former.write_text(json.dumps(dict(estimate.to_dict(), cross_validation={"rms_mm": 0.3, "predicted_rms_mm": 0.1})))
        run("plan", KR270 / "experiment.yaml", "--poses=8", "--pool=60", "--out=%s" % out, "--quiet", "--nomove",
            "--cell=%s" % cell, "--model_error=%s" % former)
        theirs = json.loads((out / "plan.json").read_text())
        self.assertGreater(theirs["predicted"]["model_field"]["urad"], 0)
        for known, error in ((cell, former), ({"schema": "sagitta/cell/1", "floor_mm": 900}, former)):
            plan = sagitta.plan(sagitta.read(KR270 / "experiment.yaml", points_required=False), poses=8, pool=60,
                                move=False, cell=known, model_error=error)
            self.assertEqual(plan.to_dict(), {k: v for k, v in theirs.items() if k not in ("version", "command")})
        plan = sagitta.plan(sagitta.read(KR270 / "experiment.yaml", points_required=False), poses=8, pool=60, move=False,
                            model_error=estimate)
        self.assertEqual(plan.to_dict()["predicted"]["model_error"], max(1.0, estimate.to_dict()["model_error"]["factor"]))
        with self.assertRaises(sagitta.InputError):
            sagitta.plan(sagitta.read(KR270 / "experiment.yaml"), poses=8, cell={"flor_mm": 1})
        run("diagnose", KR270 / "experiment.yaml", "--out=%s" % out, "--quiet")
        said = []
        diagnosis = sagitta.diagnose(sagitta.read(KR270 / "experiment.yaml"), progress=said.append)
        theirs = json.loads((out / "diagnosis.json").read_text())
        self.assertEqual(without_circumstances(diagnosis.to_dict()), without_circumstances(theirs))
        self.assert_same_pictures(diagnosis.report_html, out / "report.html")
        self.assertEqual(diagnosis.robot_yaml, without_run((out / "robot.extended.yaml").read_text()))
        self.assertIsNone(diagnosis.next_robot_yaml)
        self.assertEqual(len(diagnosis.to_dataframe()), sum(len(step["parameters"]) for step in diagnosis.steps))

    def test_a_joint_that_slipped_in_the_next_campaign(self):
        columns = columns_of(KR270 / "geometric.csv")
        columns["time_s"] = ["%d" % (60 * i) for i in range(len(columns["config"]))]
        robot, rows, out = self.folder / "robot.yaml", self.folder / "rows.csv", self.folder / "out"
        robot.write_text((KR270 / "robot.yaml").read_text() + "effects: [{effect: joint_slip, joint: A3, after_s: 900}]\n")
        rows.write_text("\n".join(",".join(row) for row in zip(*([name] + column for name, column in columns.items()))))
        run("diagnose", robot, rows, "--sigma_mm=0.1", "--out=%s" % out, "--quiet")
        diagnosis = sagitta.diagnose(sagitta.read(robot, rows, sigma_mm=0.1))
        self.assertIn("joint_slip", diagnosis.robot_yaml)
        self.assertNotIn("joint_slip", diagnosis.next_robot_yaml)
        self.assertEqual(diagnosis.next_robot_yaml, without_run((out / "robot.next.yaml").read_text()))


class TablesInMemory(FolderTest):
    def setUp(self):
        super().setUp()
        self.columns = columns_of(KR270 / "geometric.csv")
        self.reference = sagitta.calibrate(sagitta.read(KR270 / "robot.yaml", KR270 / "geometric.csv", sigma_mm=0.1))

    def same_as_the_file(self, *tables, **options):
        estimate = sagitta.calibrate(sagitta.read(KR270 / "robot.yaml", *tables, sigma_mm=0.1, **options))
        self.assertEqual(estimate.to_dict()["parameters"], self.reference.to_dict()["parameters"])
        return estimate

    def test_frames_arrays_and_columns(self):
        frame = pandas.read_csv(KR270 / "geometric.csv", comment="#", float_precision="round_trip")
        self.same_as_the_file(frame)
        half = len(frame) // 2
        self.same_as_the_file(frame[:half], frame[half:])
        columns = dict(self.columns)
        q = np.array([columns.pop("q%d_deg" % j) for j in range(1, 7)], dtype=float).T.copy()
        points = np.array([columns.pop("%s_mm" % a) for a in "xyz"], dtype=float).T.copy()
        self.same_as_the_file({**columns, "q_deg": q, "xyz_mm": points})
        self.same_as_the_file({**columns, "q_deg": np.asfortranarray(q), "xyz_mm": points[::1]})

    def test_robot_as_dictionary(self):
        robot = {"schema": "sagitta/robot/1", "name": "two links", "joints": [{"name": "A1", "type": "revolute"}],
                 "kinematics": {"dh": {"convention": "standard", "links": [
                     {"joint": "A1", "a_mm": np.float64(350), "alpha_deg": -90, "d_mm": 750, "theta_deg": 0}]}}}
        rows = {"config": [1, 2], "marker": ["M", "M"], "q1_deg": np.array([0.0, 90.0]), "x_mm": [400.0, 0.0],
                "y_mm": [0.0, 400.0], "z_mm": [750.0, 750.0]}
        experiment = sagitta.read(robot, rows, noise={"sigma_mm": np.float64(0.1)})
        self.assertEqual((experiment.robot_name, len(experiment), experiment.joints), ("two links", 2, ["A1"]))
        np.testing.assert_allclose(experiment.joint_values, [[0.0], [np.pi / 2]], rtol=1e-15)
        np.testing.assert_allclose(experiment.points_m[0], [0.4, 0.0, 0.75], rtol=1e-15)

    def test_one_value_for_all_rows_and_one_sigma_for_all_axes(self):
        frame = pandas.read_csv(KR270 / "geometric.csv", comment="#", float_precision="round_trip")
        columns = {**frame, "marker": "P1", "station": "S1", "temperature_degC": 21}
        rows = sagitta.read(KR270 / "robot.yaml", columns)
        self.assertEqual((rows.markers, rows.stations), (["P1"], ["S1"]))
        self.assertEqual(set(rows.to_dataframe()["temperature_degC"]), {21.0})
        self.assertEqual(sagitta.read(KR270 / "robot.yaml", {**frame, "station": np.ma.masked}).stations, ["S1"])
        sigma = np.linspace(0.02, 0.04, len(frame))
        of_each = sagitta.read(KR270 / "robot.yaml", {**frame, "sigma_mm": np.repeat(sigma[:, None], 3, axis=1)})
        for values in (sigma, list(sigma), sigma[:, None], pandas.Series(sigma)):
            of_all = sagitta.read(KR270 / "robot.yaml", {**frame, "sigma_mm": values})
            pandas.testing.assert_frame_equal(of_all.to_dataframe(), of_each.to_dataframe())
        one = sagitta.read(KR270 / "robot.yaml", {**frame, "sigma_mm": 0.03}).to_dataframe()
        self.assertEqual(set(one["sigma_y_mm"]), {0.03})

    def test_names_are_those_of_the_file_to_the_last_digit(self):
        visits = 1764321000000000001 + np.arange(len(self.columns["config"]), dtype=np.int64)  # stamps, ns
        rows = sagitta.read(KR270 / "robot.yaml", {**self.columns, "visit": visits}).to_dataframe()
        self.assertEqual(list(rows["visit"].astype(str)), [str(visit) for visit in visits])
        markers = np.array(self.columns["marker"], dtype="S8")
        self.assertEqual(sagitta.read(KR270 / "robot.yaml", {**self.columns, "marker": markers}).markers,
                         sagitta.read(KR270 / "robot.yaml", self.columns).markers)

    def test_nullable_columns_of_pandas(self):
        frame = pandas.read_csv(KR270 / "geometric.csv", comment="#", float_precision="round_trip")
        points = frame[["x_mm", "y_mm", "z_mm"]].astype("Float64")
        points.loc[3] = pandas.NA
        others = frame.drop(columns=["x_mm", "y_mm", "z_mm"])
        for table in (pandas.concat([others, points], axis=1), {**others, "xyz_mm": points}):
            experiment = sagitta.read(KR270 / "robot.yaml", table)
            self.assertEqual(len(experiment), len(frame) - 1)
            self.assertIn("lost", experiment.warnings[0])
        frame["config"] = pandas.array([pandas.NA, *range(1, len(frame))], dtype="Int64")
        with self.assertRaisesRegex(sagitta.InputError, "measurements:1: config: the cell is empty"):
            sagitta.read(KR270 / "robot.yaml", frame)

    def test_lost_readings_are_counted(self):
        frame = pandas.read_csv(KR270 / "geometric.csv", comment="#")
        frame.loc[3, ["x_mm", "y_mm", "z_mm"]] = np.nan
        experiment = sagitta.read(KR270 / "robot.yaml", frame)
        self.assertEqual(len(experiment), len(frame) - 1)
        self.assertIn("lost", experiment.warnings[0])

    def test_masked_values_are_not_stated(self):
        frame = pandas.read_csv(KR270 / "geometric.csv", comment="#", float_precision="round_trip")
        wrong = frame[["x_mm", "y_mm", "z_mm"]].to_numpy()
        wrong[3] += 5.0
        masked = np.ma.array(wrong, mask=np.arange(len(frame))[:, None] == [3, 3, 3])
        others = dict(frame.drop(columns=["x_mm", "y_mm", "z_mm"]))
        for points in ({"xyz_mm": masked}, {"%s_mm" % axis: masked[:, a] for a, axis in enumerate("xyz")},
                       {"xyz_mm": masked.filled(np.nan)}):
            experiment = sagitta.read(KR270 / "robot.yaml", {**others, **points})
            self.assertEqual(len(experiment), len(frame) - 1)
            self.assertIn("lost", experiment.warnings[0])
        # Numbers, whole numbers, texts and cells of any kind: what must be stated is missing by its row and name.
        for name, values in (("q2_deg", others["q2_deg"].to_numpy()), ("config", np.arange(len(frame))),
                             ("marker", np.array(["P1"] * len(frame))), ("marker", ["P1"] * 3 + [np.ma.masked] +
                                                                         ["P1"] * (len(frame) - 4))):
            if isinstance(values, np.ndarray):
                values = np.ma.array(values, mask=np.arange(len(frame)) == 3)
            else:
                values = np.array(values, dtype=object)
            with self.assertRaises(sagitta.InputError) as raised:
                sagitta.read(KR270 / "robot.yaml", {**frame, name: values})
            self.assertEqual((raised.exception.line, raised.exception.key), (4, name))
            self.assertIn("empty", str(raised.exception))


class Held(unittest.TestCase):
    def test_deviations_that_allow_for_what_was_held(self):
        """Two parallel axes: the height of the marker trades with that of the base."""
        robot = {"schema": "sagitta/robot/1",
                 "joints": [{"name": "A1", "type": "revolute"}, {"name": "A2", "type": "revolute"}],
                 "kinematics": {"chain": [{"Rz": "A1"}, {"Tx_mm": 400, "error": "a1"}, {"Rz": "A2"}, {"Tx_mm": 250}]}}
        random = np.random.default_rng(2)
        q = random.uniform(-1.5, 1.5, (30, 2))
        turned = q.sum(axis=1)
        points = np.array([400 * np.cos(q[:, 0]) + 300 * np.cos(turned), 400 * np.sin(q[:, 0]) + 300 * np.sin(turned),
                           np.full(30, 20.0)]).T + 0.02 * random.standard_normal((30, 3))
        estimate = sagitta.calibrate(sagitta.read(robot, {"config": np.arange(30), "marker": ["M"] * 30, "q_rad": q,
                                                          "xyz_mm": points}, sigma_mm=0.02))
        frame = estimate.to_dataframe()
        wider = []
        for row in estimate.to_dict()["parameters"]:
            parameter, shown = estimate[row["name"]], frame.loc[row["name"]]
            if "unconditional" in row and (row["sigma"] is None or row["unconditional"]["sigma"] > row["sigma"]):
                wider.append(row["name"])
                self.assertEqual(parameter.unconditional, row["unconditional"]["sigma"])
                self.assertEqual(list(parameter.unconditional_ci95), row["unconditional"]["ci95"])
                self.assertEqual(shown["unconditional"], row["unconditional"]["sigma"])
                self.assertEqual([shown["unconditional_low"], shown["unconditional_high"]], row["unconditional"]["ci95"])
                self.assertIn("sigma %.3g with what was held" % parameter.unconditional, repr(parameter))
            else:
                self.assertIsNone(parameter.unconditional)
                self.assertIsNone(parameter.unconditional_ci95)
                self.assertTrue(np.isnan(shown["unconditional"]))
                self.assertNotIn("held", repr(parameter))
        self.assertIn("base/S1/z", wider)  # it moves with the marker's height
        self.assertIn("marker/M/z", wider)  # held
        self.assertNotIn("base/S1/rx", wider)

    def test_nothing_is_held(self):
        frame = sagitta.calibrate(sagitta.read(KR270 / "experiment.yaml", sigma_mm=0.1)).to_dataframe()
        self.assertTrue(frame[["unconditional", "unconditional_low", "unconditional_high"]].isna().all(axis=None))


class Errors(FolderTest):
    def caught(self, function, *arguments, **options):
        with self.assertRaises(sagitta.InputError) as raised:
            function(*arguments, **options)
        self.assertIsInstance(raised.exception, ValueError)
        return raised.exception

    def test_file_line_key_hint(self):
        path = self.folder / "m.csv"
        path.write_text((KR270 / "geometric.csv").read_text().replace("q3_deg", "q3_dge"))
        error = self.caught(sagitta.read, KR270 / "robot.yaml", path)
        self.assertEqual((error.file, error.key), (str(path), "q3_dge"))
        self.assertGreater(error.line, 0)
        self.assertIn("q3_deg", error.hint)
        frame = pandas.read_csv(KR270 / "geometric.csv", comment="#")
        frame["x_mm"] = frame["x_mm"].astype(object)
        frame.loc[6, "x_mm"] = "fast"
        error = self.caught(sagitta.read, KR270 / "robot.yaml", frame)
        self.assertEqual((error.file, error.line, error.key), ("measurements", 7, "x_mm"))
        error = self.caught(sagitta.read, KR270 / "robot.yaml", frame.drop(columns="x_mm"), nois={"sigma_mm": 1})
        self.assertIn("noise", error.hint)
        self.caught(sagitta.read, KR270 / "robot.yaml", 17)
        self.caught(sagitta.read, KR270 / "robot.yaml", {"config": [1, 2], "marker": ["M"]})
        self.caught(sagitta.read, KR270 / "experiment.yaml", noise={"sigma_mm": 1})
        self.caught(sagitta.calibrate, sagitta.read(KR270 / "experiment.yaml"), method="guess")

    # Hints are those of the program, whose flags are arguments here.
    def test_no_flags(self):
        frame = pandas.read_csv(KR270 / "geometric.csv", comment="#")
        frame["load"], frame["fz_N"] = "heavy", -100.0
        error = self.caught(lambda: sagitta.calibrate(sagitta.read(KR270 / "robot.yaml", frame, sigma_mm=0.1)))
        self.assertIn("or load_point_mm=", error.hint)

    def test_one_name_is_a_list_of_one(self):
        files = (KR270 / "robot.yaml", KR270 / "geometric.csv")
        error = self.caught(lambda: sagitta.calibrate(sagitta.read(*files, sigma_mm="0.1", free="geometry/p_x9")))
        self.assertIn("'geometry/p_x9'", str(error))
        fixed = sagitta.calibrate(sagitta.read(*files, sigma_mm=0.1, fixed="geometry/p_x1,geometry/p_y1"))
        self.assertFalse(fixed["geometry/p_x1"].free or fixed["geometry/p_y1"].free)
        error = self.caught(sagitta.plan, sagitta.read(KR270 / "experiment.yaml"), poses=3, discriminate="backlsh/A3")
        self.assertIn("backlsh", str(error))

    def test_names_are_any_iterable_of_texts(self):
        files = (KR270 / "robot.yaml", KR270 / "geometric.csv")
        names = ["geometry/p_x1", "geometry/p_y1"]
        for some in (np.array(names), pandas.Series(names), set(names), (name for name in names), dict.fromkeys(names)):
            fixed = sagitta.calibrate(sagitta.read(*files, sigma_mm=0.1, fixed=some))
            self.assertFalse(fixed["geometry/p_x1"].free or fixed["geometry/p_y1"].free, some)
        for nothing in (None, "", [], np.array([])):
            self.assertEqual(len(sagitta.read(*files, free=nothing)), 54)
        for wrong in (7, [7], np.array([names])):
            for flag in ("free", "fixed"):
                with self.assertRaisesRegex(TypeError, "^%s: " % flag):
                    sagitta.read(*files, **{flag: wrong})
        with self.assertRaisesRegex(TypeError, "^discriminate: "):
            sagitta.plan(sagitta.read(KR270 / "experiment.yaml"), poses=3, discriminate=[1])

    def test_settings_that_no_file_can_hold(self):
        files = (KR270 / "robot.yaml", KR270 / "geometric.csv")
        error = self.caught(sagitta.read, *files, estimate={"geometry": {"p_x1"}})
        self.assertEqual(error.key, "estimate.geometry")
        self.assertIn("estimate.geometry", str(error))
        self.assertEqual(self.caught(sagitta.read, *files, markers={"P1": {"xyz_mm": [1, 2, object()]}}).key,
                         "markers.P1.xyz_mm[2]")
        robot = {"schema": "sagitta/robot/1", "joints": [{"name": "A1", "type": {"revolute"}}]}
        self.assertEqual(self.caught(sagitta.read, robot, files[1]).key, "joints[0].type")

    def test_rows_of_a_result_are_measurements(self):
        experiment = sagitta.read(KR270 / "experiment.yaml")
        rows = sagitta.simulate(experiment, sagitta.calibrate(experiment), sigma_mm=0.02)
        again = sagitta.read(KR270 / "robot.yaml", rows, sigma_mm=0.02)
        np.testing.assert_array_equal(again.to_dataframe()["x_mm"], rows.to_dataframe()["x_mm"])
        self.assertEqual(sagitta.calibrate(again).status, "converged")

    def test_names_with_two_settings_are_one(self):
        name = "effect/backlash[by=torque,width_Nm=30]/A3"
        files = (KR270 / "robot.yaml", KR270 / "geometric.csv")
        for flag in ("free", "fixed"):
            error = self.caught(lambda: sagitta.calibrate(sagitta.read(*files, sigma_mm=0.1, **{flag: name})))
            self.assertIn("'%s'" % name, str(error))

    def test_tables_have_the_limits_of_files(self):
        columns = {**columns_of(KR270 / "geometric.csv")}
        columns["config"] = ["C\x1b[2J" + config for config in columns["config"]]
        error = self.caught(sagitta.read, KR270 / "robot.yaml", columns)
        self.assertEqual((error.line, error.key), (1, "config"))
        self.assertIn("U+001B", str(error))

    def test_what_is_no_number_and_no_table(self):
        columns = columns_of(KR270 / "geometric.csv")
        columns["xyz_mm"] = np.array([columns.pop("%s_mm" % a) for a in "xyz"], dtype=float).T + 1j
        self.assertEqual(self.caught(sagitta.read, KR270 / "robot.yaml", columns).key, "xyz_mm")
        self.assertIn("measurements", str(self.caught(sagitta.read, {"schema": "sagitta/robot/1"})))

    def test_shapes_that_cannot_be_columns(self):
        frame = pandas.read_csv(KR270 / "geometric.csv", comment="#")
        rows = len(frame)
        for name, array, words in (("xyz_mm", np.zeros((3, rows)), "transposed.*xyz_mm.T"),
                                   ("q_deg", np.zeros((6, rows)), "transposed.*q_deg.T"),
                                   ("xyz_mm", np.zeros((rows, 4)), "4 columns .3 columns are expected: x_mm, y_mm, z_mm"),
                                   ("sigma_mm", np.zeros((3, rows)), "transposed"),
                                   ("marker", (name for name in ["P1"] * rows), "generator .*one value per row"),
                                   ("xyz_mm", [[1.0, 2.0]] + [[1.0]] * (rows - 1), "'xyz_mm' is no array"),
                                   ("xyz_mm", np.zeros((rows, 3, 1)), "3 dimensions")):
            columns = dict(frame.drop(columns=["x_mm", "y_mm", "z_mm"] if name == "xyz_mm" else []))
            error = self.caught(sagitta.read, KR270 / "robot.yaml", {**columns, name: array})
            self.assertRegex(str(error), words)
            self.assertEqual(error.key, name)
        self.assertIn("how many rows", str(self.caught(sagitta.read, KR270 / "robot.yaml", {"marker": "P1"})))

    def test_arguments_of_another_type(self):
        for arguments in ((None,), (None, KR270 / "geometric.csv"), ([1], KR270 / "geometric.csv")):
            with self.assertRaisesRegex(TypeError, "robot: a path, its text or a dictionary"):
                sagitta.read(*arguments)
        with self.assertRaisesRegex(TypeError, "cell: a path"):
            sagitta.plan(sagitta.read(KR270 / "experiment.yaml"), poses=3, cell=17)
        experiment = sagitta.read(KR270 / "experiment.yaml")
        estimate = sagitta.calibrate(experiment)
        for call in (sagitta.calibrate, sagitta.diagnose, sagitta.inspect, sagitta.simulate):
            with self.assertRaisesRegex(TypeError, "sagitta.read"):
                call(estimate)
        with self.assertRaisesRegex(TypeError, "sagitta.read"):
            sagitta.plan(KR270 / "experiment.yaml", poses=3)
        with self.assertRaises(TypeError):
            sagitta.plan(experiment, poses="3")
        with self.assertRaisesRegex(TypeError, "sagitta.calibrate"):
            sagitta.predict(experiment, KR270 / "geometric.csv")

    def test_arguments_out_of_range_have_their_own_names(self):
        experiment = sagitta.read(KR270 / "experiment.yaml")
        estimate = sagitta.calibrate(experiment)
        targets = {"target": ["a"], "q_deg": np.zeros((1, 6))}
        for call, arguments, options in (
                (sagitta.plan, (experiment,), {"poses": -3}), (sagitta.plan, (experiment,), {"poses": 0}),
                (sagitta.plan, (experiment,), {"poses": 2**40}), (sagitta.plan, (experiment,), {"accuracy_mm": -1}),
                (sagitta.plan, (experiment,), {"accuracy_mm": 0}),
                (sagitta.plan, (experiment,), {"accuracy_mm": float("nan")}),
                (sagitta.plan, (experiment,), {"pool": 0, "poses": 6}),
                (sagitta.plan, (experiment,), {"seed": -1, "poses": 6}),
                (sagitta.plan, (experiment,), {"criterion": "Q", "poses": 6}),
                (sagitta.calibrate, (experiment,), {"threads": 0}), (sagitta.calibrate, (experiment,), {"seed": -1}),
                (sagitta.calibrate, (experiment,), {"seed": 2**64}),
                (sagitta.calibrate, (experiment,), {"method": "joynt"}),
                (sagitta.diagnose, (experiment,), {"threads": 0}), (sagitta.diagnose, (experiment,), {"threads": -1}),
                (sagitta.compensate, (estimate, targets), {"threads": 0}),
                (sagitta.simulate, (experiment, estimate), {"sigma_mm": -1}),
                (sagitta.simulate, (experiment, estimate), {"seed": -1})):
            error = self.caught(call, *arguments, **options)
            name = next(iter(options))
            self.assertEqual(error.key, name)
            self.assertTrue(str(error).startswith(name + ": "), error)
        for options in ({"poses": 2.5}, {"poses": 6, "pool": 1.5}, {"poses": 6, "seed": "one"}):
            with self.assertRaisesRegex(TypeError, list(options)[-1] + ": a whole number is expected"):
                sagitta.plan(experiment, **options)

    def test_readings_of_another_robot(self):
        frame = pandas.read_csv(KR270 / "geometric.csv", comment="#")
        frame["q2_deg"] = -frame["q2_deg"]
        experiment = sagitta.read(KR270 / "robot.yaml", frame)
        self.assertIn("force=True", self.caught(sagitta.calibrate, experiment).hint)
        estimate = sagitta.calibrate(sagitta.read(KR270 / "experiment.yaml"))
        for command in (sagitta.predict, sagitta.validate):
            self.assertIn("force=True", self.caught(command, estimate, frame).hint)
            command(estimate, frame, force=True)

    def test_nothing_to_predict(self):
        estimate = sagitta.calibrate(sagitta.read(KR270 / "experiment.yaml"))
        frame = pandas.read_csv(KR270 / "geometric.csv", comment="#")
        frame["marker"] = "unknown"
        self.assertIn("unknown", str(self.caught(estimate.predict, frame)))


class Arrays(unittest.TestCase):
    def test_views_are_row_major_read_only_and_outlive_the_estimate(self):
        estimate = sagitta.calibrate(sagitta.read(KR270 / "experiment.yaml"))
        views = [estimate.predicted_m, estimate.covariance_si, estimate.leverage]
        before = [view.copy() for view in views]
        for view in views:
            self.assertEqual(view.dtype, np.float64)
            self.assertTrue(view.flags.c_contiguous)
            self.assertFalse(view.flags.owndata)
            self.assertFalse(view.flags.writeable)
        self.assertEqual(estimate.predicted_m.ctypes.data, views[0].ctypes.data)
        np.testing.assert_allclose(1e3 * estimate.residuals_m[:, 1], estimate.residuals_dataframe()["res_y_mm"], atol=1e-12)
        sigma = np.sqrt(np.diag(estimate.covariance_si))
        i = estimate.estimated.index("marker/P1/x")
        self.assertAlmostEqual(1e3 * sigma[i], estimate[estimate.estimated[i]].sigma, places=12)
        np.testing.assert_allclose(estimate.covariance_si / np.outer(sigma, sigma), estimate.correlation, atol=1e-12)
        del estimate
        gc.collect()
        for view, copy in zip(views, before):
            np.testing.assert_array_equal(view, copy)

    def test_all_arrays_are_read_only(self):
        experiment = sagitta.read(KR270 / "experiment.yaml")
        estimate = sagitta.calibrate(experiment)
        results = {experiment: ("points_m", "joint_values"),
                   estimate: ("measured_m", "predicted_m", "residuals_m", "whitened", "leverage", "correlation",
                              "covariance_si"),
                   sagitta.predict(estimate, KR270 / "geometric.csv"): ("points_m", "covariance_m2"),
                   sagitta.validate(estimate, KR270 / "geometric.csv"): ("predicted_m",),
                   sagitta.compensate(estimate, {"target": ["a"], "q_deg": np.full((1, 6), 10.0)}): ("joint_values",),
                   sagitta.simulate(experiment, estimate): ("points_m", "joint_values")}
        for result, names in results.items():
            for name in names:
                with self.assertRaises(ValueError, msg=name):
                    getattr(result, name)[0] = 1.0

    def test_dates_are_no_seconds(self):
        rows = {"config": ["a", "b"], "q_deg": np.zeros((2, 6)), "xyz_mm": np.ones((2, 3)),
                "time_s": np.array(["2024-01-01T00:00", "2024-01-01T00:01"], dtype="datetime64[s]")}
        robot = KR270 / "robot.yaml"
        for times, how in ((rows["time_s"], r"times - times.min\(\)"), (rows["time_s"] - rows["time_s"][0], r"\(times\) /")):
            with self.assertRaisesRegex(sagitta.InputError, "time_s.*not seconds.*" + how):
                sagitta.read(robot, {**rows, "time_s": times})

    def test_estimates_are_written_and_loaded_instead_of_pickled(self):
        experiment = sagitta.read(KR270 / "experiment.yaml")
        estimate = sagitta.calibrate(experiment)
        with self.assertRaises(TypeError):
            pickle.dumps(estimate)
        with self.assertRaisesRegex(TypeError, "arguments of sagitta.read"):
            pickle.dumps(experiment)
        with tempfile.TemporaryDirectory() as folder:
            estimate.write(folder)
            with self.assertRaisesRegex(TypeError, "path of its estimate.json"):
                pickle.dumps(sagitta.load(folder + "/estimate.json"))
        parameter = pickle.loads(pickle.dumps(estimate["geometry/p_x1"]))
        self.assertEqual(repr(parameter), repr(estimate["geometry/p_x1"]))

    def test_numbers_go_in_by_their_bits(self):
        rows = {"config": ["c"], "marker": ["m"], "q1_deg": [0.1], "x_mm": [1 / 3], "y_mm": [np.nextafter(1.0, 2)],
                "z_mm": [1e-17]}
        robot = ("schema: sagitta/robot/1\njoints: [{name: A, type: revolute}]\n"
                 "kinematics: {chain: [{Rz: A}, {Tx_mm: 100}]}\n")
        frame = sagitta.read(robot, rows).to_dataframe()
        self.assertEqual([frame[name][0] for name in ("x_mm", "y_mm", "z_mm")], [1 / 3, np.nextafter(1.0, 2), 1e-17])


def slow_experiment():
    return sagitta.read(KR270 / "robot.yaml", KR270 / "geometric.csv", noise={"sigma_mm": 0.1}, covariance="bootstrap",
                        bootstrap={"kind": "parametric", "replicates": 100000, "seed": 1})


class LongCalls(unittest.TestCase):
    def test_ctrl_c_ends_it(self):
        experiment = slow_experiment()
        threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT)).start()
        start = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            sagitta.calibrate(experiment, threads=2)
        self.assertLess(time.monotonic() - start, 5.0)

    def test_an_exception_of_the_callback_ends_it(self):
        def stop(_):
            raise KeyError("enough")
        with self.assertRaises(KeyError):
            sagitta.calibrate(slow_experiment(), progress=stop)

    def test_other_threads_run_meanwhile(self):
        counted, ended = [0], threading.Event()

        def count():
            while not ended.is_set():
                counted[0] += 1
                time.sleep(1e-3)
        counter = threading.Thread(target=count)
        counter.start()
        said = []
        try:
            with self.assertRaises(KeyboardInterrupt):
                threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT)).start()
                sagitta.calibrate(slow_experiment(), progress=said.append)
        finally:
            ended.set()
            counter.join()
        self.assertGreater(counted[0], 100)
        self.assertTrue(any("bootstrap" in what for what in said))


class TheEndOfTheInterpreter(unittest.TestCase):
    """What runs in daemon threads then is asked to end, and waited for; the process does not abort."""
    SCRIPT = """
import sys, threading, time
import sagitta
robot, rows, work = sys.argv[1:4]
options = {"covariance": "bootstrap", "bootstrap": {"kind": "parametric", "replicates": 100000, "seed": 1}}
experiment = sagitta.read(robot, rows, noise={"sigma_mm": 0.1}, **options)
estimate = sagitta.calibrate(sagitta.read(robot, rows))
calls = {"calibrate": lambda: sagitta.calibrate(experiment), "predict": lambda: estimate.predict(rows)}
def again_and_again():
    while True:
        try:
            calls[work]()
        except Exception as error:
            print(type(error).__name__)
for _ in range(2):
    threading.Thread(target=again_and_again, daemon=True).start()
time.sleep(float(sys.argv[4]))
print("main ends")
"""

    def test_daemon_threads_inside_long_and_short_calls(self):
        for work in ("calibrate", "predict"):
            for trial in range(6):
                start = time.monotonic()
                done = subprocess.run([sys.executable, "-c", self.SCRIPT, KR270 / "robot.yaml", KR270 / "geometric.csv",
                                       work, str(0.2 + 0.013 * trial)], capture_output=True, text=True, check=False)
                self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "main ends\n", ""), work)
                self.assertLess(time.monotonic() - start, 9.0)

    def test_a_child_does_not_wait_for_the_threads_of_its_parent(self):
        script = self.SCRIPT.replace('print("main ends")', """
child = os.fork()
if child == 0:
    sys.exit()
print(os.waitpid(child, 0)[1])
""").replace("import sys,", "import os, sys,")
        start = time.monotonic()
        done = subprocess.run([sys.executable, "-c", script, KR270 / "robot.yaml", KR270 / "geometric.csv", "calibrate",
                               "0.2"], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "0\n", ""))
        self.assertLess(time.monotonic() - start, 9.0)


if __name__ == "__main__":
    PROGRAM = sys.argv.pop(1)
    unittest.main()
