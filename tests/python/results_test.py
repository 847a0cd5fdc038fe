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
import yaml

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
        diagnosis = sagitta.diagnose(sagitta.read(self.folder / "experiment.yaml"))
        theirs = self.folder / "estimate.json"
        self.assertGreater(json.loads(theirs.read_text())["model_error"]["rest_mm"], 0.05)
        ours, written = [sagitta.predict(known, frame) for known in (diagnosis, theirs)]
        np.testing.assert_array_equal(ours.covariance_m2, written.covariance_m2)
        self.assertEqual(len(ours.warnings), len(written.warnings))
        ours, written = [sagitta.validate(known, frame).after for known in (diagnosis, theirs)]
        self.assertEqual(ours, written)
        changed = [module_test.without_circumstances(sagitta.changed(known, theirs).to_dict())
                   for known in (diagnosis, theirs)]
        self.assertEqual(*[json.dumps(one).replace(str(theirs), "diagnosis") for one in changed])


def two_links(q, marker, length=350):
    """Rotation and point (mm) of a marker on an arm of two joints: about z, then, 350 mm further, about y."""
    (a, b), eye = q, np.eye(3)
    about_z = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], eye[2]])
    rotation = about_z @ np.array([[np.cos(b), 0, np.sin(b)], eye[1], [-np.sin(b), 0, np.cos(b)]])
    return rotation, about_z @ (length, 0, 0) + rotation @ (np.array([1250, 0, 0]) + marker)


def rotation_vector(rotation):
    angle = np.arccos((np.trace(rotation) - 1) / 2)
    return angle / (2 * np.sin(angle)) * np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0],
                                                   rotation[1, 0] - rotation[0, 1]])


def poses_and_points():
    """An experiment, and its rows: a target P that is read with its rotation, a marker M without."""
    robot = {"schema": "sagitta/robot/1", "joints": [{"name": name, "type": "revolute"} for name in ("A1", "A2")],
             "kinematics": {"chain": [{"Rz": "A1"}, {"Tx_mm": 350, "error": "l"}, {"Ry": "A2"}, {"Tx_mm": 1250}]}}
    random, rows = np.random.default_rng(1), []
    for config, q in enumerate(random.uniform(-1.2, 1.2, (30, 2))):
        for marker, place in (("P", (60, 20, 30)), ("M", (-30, 50, 0))):
            rotation, point = two_links(q, np.array(place))
            turned = 1e3 * rotation_vector(rotation) if marker == "P" else np.full(3, np.nan)
            noise = random.standard_normal((2, 3))
            rows.append([config, marker, *q, *point + 0.02 * noise[0], *turned + 0.05 * noise[1]])
    rows = pandas.DataFrame(rows, columns=["config", "marker", "q1_rad", "q2_rad", "x_mm", "y_mm", "z_mm",
                                           "rx_mrad", "ry_mrad", "rz_mrad"])
    return sagitta.read(robot, {**rows, "sigma_r_mrad": 0.05, "sigma_mm": 0.02}), rows


class Leverage(unittest.TestCase):
    def test_of_poses_and_points(self):
        """Over all axes leverages add to the number of what was estimated: the trace of a projection."""
        experiment, rows = poses_and_points()
        estimate = sagitta.calibrate(experiment)
        axes = np.where(rows["marker"] == "P", 6, 3)
        self.assertAlmostEqual((axes * estimate.leverage).sum(), len(estimate.estimated), delta=1e-6)
        np.testing.assert_allclose(estimate.leverage, estimate.residuals_dataframe()["leverage"], rtol=1e-12)


def change(value):
    """Everything in it is another thing afterwards."""
    for key in list(value) if isinstance(value, dict) else range(len(value)):
        if isinstance(value[key], (dict, list)):
            change(value[key])
        else:
            value[key] = "changed"
    value.clear()


class Copies(unittest.TestCase):
    def test_what_is_handed_out_is_a_copy(self):
        experiment = sagitta.read(KR270 / "experiment.yaml", holdout=0.3)
        estimate = sagitta.calibrate(experiment)
        targets = {"target": ["a"], "q_deg": np.full((1, 6), 170.0)}
        for result in (experiment, estimate, sagitta.inspect(experiment),
                       sagitta.changed(estimate, estimate), sagitta.plan(experiment, poses=8, pool=60),
                       estimate.validate(KR270 / "geometric.csv"), estimate.compensate(targets)):
            names = [name for name in dir(type(result)) if isinstance(getattr(type(result), name), property)]
            names = [name for name in names if isinstance(getattr(result, name), (dict, list)) and name[0] != "_"]
            self.assertTrue(names or isinstance(result, sagitta.Plan), result)
            for name in names:
                before = repr(getattr(result, name))
                change(getattr(result, name))
                self.assertEqual(repr(getattr(result, name)), before, (result, name))
            if hasattr(result, "to_dict"):
                before = json.dumps(result.to_dict())
                change(result.to_dict())
                self.assertEqual(json.dumps(result.to_dict()), before)
        self.assertEqual(len(estimate.to_dataframe()), len(estimate.parameters))

    def test_a_plan_is_made_of_what_was_estimated(self):
        experiment = sagitta.read(KR270 / "experiment.yaml")
        estimate = sagitta.calibrate(experiment)
        plan = sagitta.plan(experiment, poses=8, pool=60, move=False, model_error=estimate).to_dict()
        estimate.to_dict()["model_error"]["factor"] = 5.0
        self.assertEqual(sagitta.plan(experiment, poses=8, pool=60, move=False, model_error=estimate).to_dict(), plan)


class OwnColumns(FolderTest):
    TEXTS = ["01", "1", "1e5", "100000.0", "True", "", "+1", "0x1", "1.10", "1.1", "nan", "1_0", "=1+1",
             "12345678901234567890"]

    def test_texts_are_those_of_the_file(self):
        frame = sagitta.read(KR270 / "experiment.yaml").to_dataframe()
        texts = np.resize(np.array(self.TEXTS, dtype=object), len(frame))
        frame.assign(group=texts).to_csv(self.folder / "rows.csv", index=False)
        for rows in (self.folder / "rows.csv", frame.assign(group=texts)):
            for _ in range(2):  # once more from the rows that were read, and from their frame
                rows = sagitta.read(KR270 / "robot.yaml", rows)
                read = rows.to_dataframe()["group"]
                self.assertEqual(list(read.fillna("")), list(texts))

    def test_numbers_are_numbers(self):
        frame = sagitta.read(KR270 / "experiment.yaml").to_dataframe()
        random = np.random.default_rng(3)
        values = {"whole": np.arange(len(frame)) - 7, "tiny": random.standard_normal(len(frame)) * 1e-17,
                  "large": random.standard_normal(len(frame)) * 1e200, "lost": np.where(frame.index % 5, 0.1, np.nan)}
        read = sagitta.read(KR270 / "robot.yaml", frame.assign(**values)).to_dataframe()
        for name, numbers in values.items():
            self.assertEqual(read[name].dtype.kind, "i" if name == "whole" else "f")
            np.testing.assert_array_equal(read[name], numbers)
        residuals = sagitta.calibrate(sagitta.read(KR270 / "robot.yaml", frame, sigma_mm=0.1)).residuals_dataframe()
        self.assertEqual({residuals[name].dtype.kind for name in ("leverage", "whitened_x", "x_mm")}, {"f"})

    def test_what_is_held_out_is_that_of_the_file(self):
        frame = sagitta.read(KR270 / "experiment.yaml").to_dataframe()
        number = frame["config"].str[1:].astype(int) % 4
        frame = frame.assign(group=number.map({0: "01", 1: "1", 2: "2", 3: "3"}))
        frame.to_csv(self.folder / "rows.csv", index=False)
        rows = sagitta.read(KR270 / "robot.yaml", self.folder / "rows.csv")
        for table in (self.folder / "rows.csv", frame, rows, rows.to_dataframe()):
            experiment = sagitta.read(KR270 / "robot.yaml", table, sigma_mm=0.1,
                                      validation={"column": "group", "values": ["1"]})
            self.assertEqual(sagitta.calibrate(experiment).validation["observations"], (number == 1).sum())

    def test_rows_that_are_handed_on_have_their_numbers(self):
        rows = sagitta.read(KR270 / "experiment.yaml")
        two_links = {"schema": "sagitta/robot/1", "joints": [{"name": "A1", "type": "revolute"}],
                     "kinematics": {"chain": [{"Rz": "A1"}, {"Tx_mm": 350}]}}
        with self.assertRaises(sagitta.InputError) as raised:
            sagitta.read(two_links, rows)
        self.assertEqual(raised.exception.file, "measurements")


class Programs(FolderTest):
    KRL = b"DEF P( )\r\nPTP {A1 5,A2 -90,A3 95,A4 0,A5 10,A6 -3.5}\r\nEND\r\n"

    def corrected(self, name, text, estimate=None, **scene):
        path = self.folder / name
        path.write_bytes(text)
        estimate = estimate or sagitta.calibrate(sagitta.read(KR270 / "experiment.yaml"))
        return sagitta.compensate_program(estimate, path, **scene)

    def test_warnings_are_those_that_are_printed(self):
        robot = yaml.safe_load((KR270 / "robot.yaml").read_text())
        robot["effects"] = [{"effect": "hysteresis", "width_deg": 10, "joint": "A3", "amplitude_urad": 0}]
        rows = sagitta.read(KR270 / "experiment.yaml").to_dataframe()
        estimate = sagitta.calibrate(sagitta.read(robot, rows, sigma_mm=0.03))
        estimate.write(self.folder)
        known = sagitta.load(self.folder / "estimate.json")
        program = self.corrected("p.src", self.KRL, known)
        targets = self.folder / "targets.csv"
        targets.write_text("target,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\na,10,-80,90,5,20,3\n")
        for warnings, arguments in (
                (known.compensate(targets).warnings, [targets, "--out=%s" % (self.folder / "c.csv")]),
                (program.warnings, ["--program=%s" % (self.folder / "p.src"),
                                    "--program_out=%s" % (self.folder / "new.src")])):
            printed = module_test.run("compensate", self.folder / "estimate.json", *arguments).splitlines()
            self.assertIn("depends on the way to a target", warnings[0])
            self.assertEqual(["Warning: " + warnings[0]], [line for line in printed if line.startswith("Warning: ")])
            self.assertEqual(warnings[1:], [line for line in printed if "Standard deviations carry" in line or
                                            "No point is said to be" in line])

    def test_names_in_any_encoding(self):
        joints = "CONST jointtarget %s:=[[10,-80,90,5,20,3],[9E9,9E9,9E9,9E9,9E9,9E9]];\r\n"
        moves = "MoveAbsJ jH\xf6he,v100,fine,tool0;\r\nMoveL Offs(pGr\xfcn,0,0,10),v100,fine,tGrei\xdfer;\r\n"
        module = "MODULE M\r\n" + joints % "jH\xf6he" + "PROC main()\r\n" + moves + "ENDPROC\r\nENDMODULE\r\n"
        for encoding in ("latin-1", "utf-8"):
            corrected = self.corrected("m.mod", module.encode(encoding))
            self.assertEqual(list(corrected.to_dataframe()["target"]), ["jH\xf6he"])
            self.assertIn("pGr\xfcn", corrected.summary)
            self.assertTrue(any("pGr\xfcn" in point["name"] for point in corrected.untouched), corrected.untouched)
            self.assertIn("1 of 2 points", repr(corrected))
            self.assertIn(moves.encode(encoding), corrected.text)
            pose = module.replace(moves, "MoveL [[500,117,432],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,"
                                         "tGrei\xdfer;\r\n")
            with self.assertRaisesRegex(sagitta.InputError, "(?i)tgrei\xdfer"):
                self.corrected("t.mod", pose.encode(encoding))

    def test_where_the_arm_starts_is_somewhere(self):
        estimate = sagitta.calibrate(sagitta.read(KR270 / "experiment.yaml"))
        for wrong in (float("nan"), float("inf"), 1e300):
            with self.assertRaises(sagitta.InputError) as raised:
                self.corrected("p.src", self.KRL, estimate, start_deg=[0, wrong, 0, 0, 0, 0])
            self.assertEqual(raised.exception.key, "start_deg")
        with self.assertRaisesRegex(sagitta.InputError, "start_deg: 6 joint values"):
            self.corrected("p.src", self.KRL, estimate, start_deg=[0, 0])
        self.corrected("p.src", self.KRL, estimate, start_deg=[0, -90, 90, 0, 0, 0])

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


class Arguments(FolderTest):
    def setUp(self):
        super().setUp()
        self.experiment = sagitta.read(KR270 / "experiment.yaml")

    def caught(self, error, words, call, *arguments, **options):
        with self.assertRaisesRegex(error, words) as raised:
            call(*arguments, **options)
        return raised.exception

    def test_paths_that_are_not_utf8(self):
        folder = os.fsencode(self.folder) + b"/d\xe4"
        os.mkdir(folder)
        (self.folder / "p.src").write_bytes(Programs.KRL)
        for name in ("robot.yaml", "geometric.csv", "experiment.yaml"):
            with open(folder + b"/" + name.encode(), "wb") as file:
                file.write((KR270 / name).read_bytes())
        folder = os.fsdecode(folder)
        estimate = sagitta.calibrate(self.experiment)
        estimate.write(self.folder)
        program = sagitta.compensate_program(estimate, self.folder / "p.src")
        for key, call in (("robot", lambda: sagitta.read(folder + "/experiment.yaml")),
                          ("robot", lambda: sagitta.read(folder + "/robot.yaml", KR270 / "geometric.csv")),
                          ("measurements", lambda: sagitta.read(KR270 / "robot.yaml", folder + "/geometric.csv")),
                          ("rows", lambda: estimate.predict(folder + "/geometric.csv")),
                          ("targets", lambda: estimate.compensate(folder + "/t.csv")),
                          ("path", lambda: sagitta.load(folder + "/estimate.json")),
                          ("folder", lambda: estimate.write(folder)),
                          ("path", lambda: program.write(folder + "/p.src")),
                          ("program", lambda: sagitta.compensate_program(estimate, folder + "/p.src")),
                          ("model_error",
                           lambda: sagitta.plan(self.experiment, poses=8, model_error=folder + "/e.json"))):
            self.assertEqual(self.caught(sagitta.InputError, "not in UTF-8", call).key, key)
        (self.folder / "experiment.yaml").write_bytes(b"schema: sagitta/experiment/1\nrobot: d\xe4/robot.yaml\n")
        self.caught(sagitta.InputError, "", sagitta.read, self.folder / "experiment.yaml")

    def test_texts_that_are_not_utf8(self):
        columns = module_test.columns_of(KR270 / "geometric.csv")
        markers = columns["marker"]
        for wrong in ("P\udce4", b"P\xe4"):
            error = self.caught(sagitta.InputError, "UTF-8", sagitta.read, KR270 / "robot.yaml",
                                {**columns, "marker": markers[:3] + [wrong] + markers[4:]})
            self.assertEqual(error.key, "marker")
            self.assertIn(error.line, (4, 0))
        self.caught(sagitta.InputError, "UTF-8", sagitta.read, KR270 / "robot.yaml", {**columns, "\udce4": markers})

    def test_arguments_are_named(self):
        estimate = sagitta.calibrate(self.experiment)
        program = self.folder / "p.src"
        program.write_bytes(Programs.KRL)
        read = lambda **options: sagitta.read(KR270 / "experiment.yaml", **options)
        plan = lambda **options: sagitta.plan(self.experiment, poses=8, pool=60, **options)
        calibrate = lambda **options: sagitta.calibrate(self.experiment, **options)
        correct = lambda **options: sagitta.compensate_program(estimate, program, **options)
        for call, options in ((plan, {"criterion": None}), (plan, {"augment": "no"}), (plan, {"move": "no"}),
                              (plan, {"model_error": estimate.known}), (plan, {"progress": 1}),
                              (calibrate, {"method": None}), (calibrate, {"force": "no"}), (calibrate, {"progress": 1}),
                              (read, {"holdout": "x"}), (read, {"sigma_mm": "x"}), (read, {"points_required": "no"}),
                              (correct, {"tools_mm_deg": 3}), (correct, {"frames_mm_deg": {"world": 3}}),
                              (correct, {"load": None}), (correct, {"start_deg": 3}),
                              (correct, {"start_deg": ["x"] * 6}), (correct, {"turn_joints": [None]})):
            self.caught(TypeError, "^%s: " % next(iter(options)), call, **options)
        self.caught(TypeError, "^accuracy_mm: ", sagitta.plan, self.experiment, accuracy_mm="x")
        self.caught(TypeError, "^sigma_mm: ", sagitta.simulate, self.experiment, estimate, sigma_mm="x")
        self.assertEqual(calibrate(force=np.True_).status, "converged")
        self.assertEqual(correct(tools_mm_deg="flange=same").text, correct(tools_mm_deg={"flange": "same"}).text)

    def test_messages_have_the_names_of_python(self):
        program = self.folder / "p.src"
        program.write_bytes(b"LIN {X 1500,Y 0,Z 1500,A 0,B 90,C 0}\n")
        estimate = sagitta.calibrate(self.experiment)
        fixed, free = [lambda flag=flag: sagitta.calibrate(sagitta.read(KR270 / "experiment.yaml", **{flag: ["nope"]}))
                       for flag in ("fixed", "free")]
        for key, call in (("fixed", fixed), ("free", free),
                          ("poses", lambda: sagitta.plan(self.experiment, poses=3, pool=60)),
                          ("tools_mm_deg", lambda: sagitta.compensate_program(estimate, program))):
            error = self.caught(sagitta.InputError, "%s: " % key, call)
            self.assertEqual(error.key, key)
            self.assertNotIn("--", str(error))
        error = self.caught(sagitta.InputError, "no parameter|not", sagitta.calibrate, sagitta.read(
            KR270 / "experiment.yaml", fixed=["--fixed"]))
        self.assertIn("'--fixed'", str(error))  # a name of the user's own

    def test_names_of_an_estimate(self):
        estimate = sagitta.calibrate(self.experiment)
        self.assertEqual(list(estimate), list(estimate.parameters))
        self.assertEqual(len(estimate), len(estimate.parameters))
        self.assertIn("geometry/p_x1", estimate)
        self.assertNotIn("geometry/p_x9", estimate)
        self.assertNotIn(0, estimate)

    def test_texts_of_one_line(self):
        robot = {"schema": "sagitta/robot/1", "name": "one link", "joints": [{"name": "A1", "type": "revolute"}],
                 "kinematics": {"chain": [{"Rz": "A1"}, {"Tx_mm": 350}]}}
        rows = {"config": ["c"], "marker": ["m"], "q1_deg": [10.0], "x_mm": [1.0], "y_mm": [2.0], "z_mm": [3.0]}
        self.assertEqual(sagitta.read(json.dumps(robot), rows).robot_name, "one link")
        urdf = ("<robot name='of URDF'><link name='a'/><link name='b'/><joint name='A1' type='continuous'>"
                "<parent link='a'/><child link='b'/><axis xyz='0 0 1'/></joint></robot>")
        self.assertEqual(sagitta.read(urdf, rows).robot_name, "of URDF")
        self.caught(sagitta.InputError, "measurements are missing", sagitta.read, json.dumps(robot))

    def test_a_seed_of_nothing(self):
        rows = self.experiment.to_dataframe().assign(set="calibration")
        for call in (lambda: sagitta.read(KR270 / "experiment.yaml", seed=5),
                     lambda: sagitta.read(KR270 / "robot.yaml", rows, seed=5),
                     lambda: sagitta.read(KR270 / "robot.yaml", rows, seed=5,
                                          validation={"column": "config", "values": ["C01"]})):
            error = self.caught(sagitta.InputError, "^seed: no rows are held out at random", call)
            self.assertEqual((error.key, error.hint[:7]), ("seed", "holdout"))
        self.assertEqual(len(sagitta.read(KR270 / "experiment.yaml", seed=5, holdout=0.3)), len(self.experiment))


if __name__ == "__main__":
    module_test.PROGRAM = sys.argv.pop(1)
    unittest.main()
