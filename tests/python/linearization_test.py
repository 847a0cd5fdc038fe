#!/usr/bin/env python3
"""The identification Jacobian of import sagitta, and rotations of targets, against models that are written here.

usage: linearization_test.py      (with the module on PYTHONPATH)
"""
import json
import unittest

import numpy as np

import sagitta
from module_test import KR270, FolderTest
from results_test import poses_and_points, rotation_vector, two_links


def rotation_vector_of_small(rotation):
    return np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0],
                     rotation[1, 0] - rotation[0, 1]]) / 2


def rotation_of(vector):
    """exp of a rotation vector."""
    angle = np.linalg.norm(vector)
    x, y, z = vector / angle if angle > 0 else (0.0, 0.0, 0.0)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


class Linearizations(FolderTest):
    """Against differences of a model that is written here, of the module's predictions, and its covariance."""

    def setUp(self):
        super().setUp()
        experiment, self.rows = poses_and_points()
        self.estimate = sagitta.calibrate(experiment)
        self.file = self.estimate.to_dict()

    def by_hand(self, row, name, step):
        """Point (m) and rotation of a row in the station, one parameter of the estimate moved by a step in SI."""
        def moved(kind):
            return np.array([step if name == "%s/%s" % (kind, axis) else 0.0 for axis in ("x", "y", "z")])

        def turned(kind):
            return rotation_of(np.array([step if name == "%s/r%s" % (kind, axis) else 0.0 for axis in "xyz"]))

        marker, base = self.file["markers"][row["marker"]], self.file["stations"]["S1"]
        of_marker, length = "marker/" + row["marker"], 350 + self.estimate["geometry/l"].value
        rotation, point = two_links((row["q1_rad"], row["q2_rad"]),
                                    np.array(marker["xyz_mm"]) + 1e3 * moved(of_marker),
                                    length + (1e3 * step if name == "geometry/l" else 0.0))
        of_base = turned("base/S1") @ rotation_of(1e-3 * np.array(base["rotvec_mrad"]))
        place = 1e-3 * (np.array(base["xyz_mm"]) + of_base @ point) + moved("base/S1")
        if "rotvec_mrad" not in marker:
            return place, None
        return place, of_base @ rotation @ turned(of_marker) @ rotation_of(1e-3 * np.array(marker["rotvec_mrad"]))

    def slopes_by_hand(self, names):
        """M x K."""
        step, columns = 1e-6, []
        for name in names:
            column = []
            for _, row in self.rows.iterrows():
                (low, low_turn), (high, high_turn) = (self.by_hand(row, name, sign * step) for sign in (-1, 1))
                column += list((high - low) / (2 * step))
                if low_turn is not None:
                    column += list(rotation_vector_of_small(high_turn @ low_turn.T) / (2 * step))
            columns.append(column)
        return np.array(columns).T

    def test_differences_of_a_model_by_hand(self):
        found = self.estimate.linearize()
        self.assertEqual(found.names, self.estimate.estimated)
        self.assertEqual(found.jacobian.shape, (30 * 9, len(found.names)))
        self.assertIn("geometry/l", found.names)
        self.assertIn("marker/P/rx", found.names)
        places = np.array([self.by_hand(row, "", 0.0)[0] for _, row in self.rows.iterrows()])
        np.testing.assert_allclose(self.estimate.predicted_m, places, atol=1e-9)
        np.testing.assert_allclose(found.jacobian, self.slopes_by_hand(found.names), atol=2e-4)
        points = ~found.turns
        np.testing.assert_array_equal(found.turns[:9], [False] * 3 + [True] * 3 + [False] * 3)
        np.testing.assert_allclose(found.residuals[points].reshape(-1, 3), self.estimate.residuals_m, atol=1e-15)
        np.testing.assert_array_equal(found.rows[points], np.repeat(np.arange(60), 3))
        with self.assertRaises(ValueError):
            found.jacobian[0, 0] = 1.0

    def test_differences_of_the_modules_predictions(self):
        rows = self.rows[["config", "marker", "q1_rad", "q2_rad"]].iloc[:8]
        found, step = self.estimate.linearize(rows), 1e-3
        at = self.estimate.linearize().jacobian
        self.assertTrue(np.isnan(found.residuals).all())
        points = ~found.turns
        np.testing.assert_allclose(found.jacobian[points], at[:len(points)][points], atol=1e-9)
        # Of rotations it is that of the residual: where one is measured, at what was measured.
        np.testing.assert_allclose(found.jacobian, at[:len(points)], atol=2e-4)
        for k, axis in enumerate("xyz"):
            points = []
            for sign in (-1, 1):
                changed = json.loads(json.dumps(self.file))
                changed["markers"]["M"]["xyz_mm"][k] += sign * step
                (self.folder / "moved.json").write_text(json.dumps(changed))
                points.append(sagitta.predict(self.folder / "moved.json", rows).points_m)
            slope = (points[1] - points[0]).ravel() / (2e-3 * step)
            column = found.jacobian[~found.turns, found.names.index("marker/M/" + axis)]
            np.testing.assert_allclose(column, slope, atol=1e-6)
        self.assertEqual(self.estimate.known.linearize(rows).names, found.names)
        one = self.estimate.linearize(rows[rows["marker"] == "P"])
        self.assertFalse(one.jacobian[:, found.names.index("marker/M/x")].any())

    def test_whitened_rows_are_the_covariance(self):
        # Noise that is stated, stated four times too small, and not stated.
        files, noises = (KR270 / "robot.yaml", KR270 / "geometric.csv"), ({"sigma_mm": 0.1}, {"sigma_mm": 0.025}, {})
        for experiment in [poses_and_points()[0], sagitta.read(KR270 / "experiment.yaml", holdout=0.3)] + [
                sagitta.read(*files, **noise) for noise in noises]:
            estimate = sagitta.calibrate(experiment)
            found = estimate.linearize(whiten=True)
            scale = np.linalg.norm(found.jacobian, axis=0)
            scaled = found.jacobian / scale
            ratio = estimate.covariance_si * np.outer(scale, scale) @ (scaled.T @ scaled)
            np.testing.assert_allclose(ratio, np.eye(len(scale)), atol=1e-5)
        with self.assertRaisesRegex(sagitta.InputError, "^whiten: ") as caught:
            estimate.linearize(experiment, whiten=True)
        self.assertEqual(caught.exception.key, "whiten")


class Targets(unittest.TestCase):
    """Rotations of targets in every form are one rotation, and the mirrored target has the form of its list."""

    def test_forms_of_one_rotation(self):
        estimate = sagitta.calibrate(sagitta.read(KR270 / "experiment.yaml"))
        a, b, c = np.radians([40.0, 25.0, 170.0])
        right = rotation_of(np.array([0, 0, a])) @ rotation_of(np.array([0, b, 0])) @ rotation_of(np.array([c, 0, 0]))
        vector = rotation_vector(right)
        half = np.linalg.norm(vector) / 2
        quaternion = [np.cos(half), *np.sin(half) * vector / (2 * half)]
        place = {"target": ["t"], "x_mm": [1500.0], "y_mm": [300.0], "z_mm": [1400.0]}
        forms = {"r%s_mrad": dict(zip("xyz", 1e3 * vector)), "o%s": dict(zip("wxyz", quaternion)),
                 "%s_deg": dict(zip("abc", np.degrees([a, b, c])))}
        turns, joints = [], []
        for pattern, numbers in forms.items():
            found = sagitta.compensate(estimate, {**place, **{pattern % key: [n] for key, n in numbers.items()}})
            joints.append(found.joint_values[0])
            row = found.to_dataframe().iloc[0]
            stem, bar, unit = pattern.partition("_")
            cmd = [row[stem % key + "_cmd" + bar + unit] for key in numbers]
            turns.append(cmd)
        np.testing.assert_allclose(joints, [joints[0]] * 3, atol=1e-9)
        a, b, c = np.radians(turns[2])
        by_angles = (rotation_of(np.array([0, 0, a])) @ rotation_of(np.array([0, b, 0]))
                     @ rotation_of(np.array([c, 0, 0])))
        by_vector = rotation_of(1e-3 * np.array(turns[0]))
        half = np.arccos(turns[1][0])
        by_quaternion = rotation_of(2 * half / np.sin(half) * np.array(turns[1][1:]))
        np.testing.assert_allclose(by_angles, by_vector, atol=1e-9)
        np.testing.assert_allclose(by_quaternion, by_vector, atol=1e-9)

    def test_vectors_in_degrees_are_warned_of(self):
        estimate = sagitta.calibrate(sagitta.read(KR270 / "experiment.yaml"))
        rows = {"target": ["t"], "x_mm": [1500.0], "y_mm": [300.0], "z_mm": [1400.0],
                "rz_deg": [40.0], "ry_deg": [25.0], "rx_deg": [170.0]}
        words = [w for w in sagitta.compensate(estimate, rows).warnings if "read as a rotation vector" in w]
        self.assertEqual(len(words), 1)


if __name__ == "__main__":
    unittest.main()
