#!/usr/bin/env python3
"""Writes the simulated KR-270 measurements of kr270/ (standard library only).

    python3 problems/published/make_kr270.py [--out DIR]

This file has its own kinematics, statics and random numbers on purpose: data
that prove the estimator must not come from the function it estimates.
Model: paper 002 eq. (2) with the chain of SOURCES.md; truth: kr270/truth.json.
The same Python writes the same bytes every time.
"""
import argparse
import json
import math
import pathlib
import random

HERE = pathlib.Path(__file__).resolve().parent
MARKERS = ("P1", "P2", "P3")
STATIONS = ("S1", "S2")
ERRORS = ("p_x1", "p_y1", "phi_x1", "dq2", "p_x2", "phi_x2", "phi_z2", "dq3", "p_x3",
          "p_z3", "phi_z3", "dq4", "p_y4", "p_z4", "phi_z4", "dq5", "p_z5", "phi_z5")
CONFIGURATIONS = 18
CANDIDATES = 400
FLOOR_MM = 200.0  # every marker of a chosen configuration is at least this high

# Ranges in which configurations are drawn, deg: inside the limits of robot.yaml,
# away from the stretched arm.
RANGES = ((-120, 120), (-130, -10), (-90, 120), (-170, 170), (-110, 110), (-170, 170))

# Paper 000, Table II (= paper 003, Table 2), deg.
ELASTOSTATIC = (
    (79.20, -0.01, -5.57, 51.00, -97.52, -91.67),
    (63.00, -0.01, -12.22, -56.49, 41.42, 150.55),
    (63.00, -0.01, -47.98, -70.04, -61.55, 177.16),
    (95.00, -25.24, 33.00, 129.69, -98.10, 90.57),
    (95.00, -25.24, -107.01, 109.95, -61.19, 174.21),
    (105.00, -25.24, 14.30, 55.21, 41.26, -152.97),
    (56.60, -56.9, 44.54, -55.11, 41.90, 152.06),
    (56.60, -56.9, 64.73, -129.65, -98.26, -90.55),
    (144.80, -56.9, 104.49, -69.41, 61.67, -6.33),
    (-41.00, -99.85, -91.68, 55.12, 41.53, -152.48),
    (-143.00, -99.85, -32.64, 110.31, -61.47, -6.29),
    (-143.00, -99.85, -72.01, 129.65, -98.09, 90.82),
    (133.00, -140.0, 147.68, 129.64, -97.90, 90.99),
    (-60.00, -140.0, 7.59, -110.09, -61.36, -174.09),
    (-60.00, -140.0, -52.00, -124.89, -41.62, 27.78),
)


class Frame:
    """A rigid frame as x, y, z axes and an origin; turned and moved in itself."""

    def __init__(self):
        self.axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        self.origin = [0.0, 0.0, 0.0]

    def move(self, x, y, z):
        self.origin = self.point((x, y, z))

    def turn(self, axis, angle):
        """Right-handed, about the frame's own axis 0, 1 or 2."""
        cosine, sine = math.cos(angle), math.sin(angle)
        u, v = self.axes[(axis + 1) % 3], self.axes[(axis + 2) % 3]
        self.axes[(axis + 1) % 3] = [cosine * a + sine * b for a, b in zip(u, v)]
        self.axes[(axis + 2) % 3] = [cosine * b - sine * a for a, b in zip(u, v)]

    def point(self, p):
        return [self.origin[i] + sum(p[k] * self.axes[k][i] for k in range(3)) for i in range(3)]


def flange(q_deg, error, deflection=(0.0,) * 6, joints=None):
    """The flange in the base frame, mm; error in mm and rad by name.

    joints: a list that receives (axis, origin) of every joint and the frames right after A1 and A2.
    """
    q = [math.radians(value) + bent for value, bent in zip(q_deg, deflection)]
    x_axis, y_axis, z_axis = 0, 1, 2
    frame = Frame()

    def note(axis):
        if joints is not None:
            joints.append((list(frame.axes[axis]), list(frame.origin), [list(a) for a in frame.axes]))

    frame.move(0, 0, 750)
    frame.turn(z_axis, q[0])
    note(z_axis)
    frame.move(350 + error["p_x1"], error["p_y1"], 0)
    frame.turn(x_axis, error["phi_x1"])
    frame.turn(y_axis, q[1] + error["dq2"])
    note(y_axis)
    frame.move(1250 + error["p_x2"], 0, 0)
    frame.turn(x_axis, error["phi_x2"])
    frame.turn(z_axis, error["phi_z2"])
    frame.turn(y_axis, q[2] + error["dq3"])
    note(y_axis)
    frame.move(1100 + error["p_x3"], 0, -55 + error["p_z3"])
    frame.turn(z_axis, error["phi_z3"])
    frame.turn(x_axis, q[3] + error["dq4"])
    note(x_axis)
    frame.move(0, error["p_y4"], error["p_z4"])
    frame.turn(z_axis, error["phi_z4"])
    frame.turn(y_axis, q[4] + error["dq5"])
    note(y_axis)
    frame.move(0, 0, error["p_z5"])
    frame.turn(z_axis, error["phi_z5"])
    frame.turn(x_axis, q[5])
    note(x_axis)
    frame.move(230, 0, 0)
    return frame


def rotate(vector, p):
    """Rodrigues' formula: p turned by the rotation vector (rad)."""
    angle = math.sqrt(sum(v * v for v in vector))
    if angle == 0.0:
        return list(p)
    n = [v / angle for v in vector]
    cross = [n[1] * p[2] - n[2] * p[1], n[2] * p[0] - n[0] * p[2], n[0] * p[1] - n[1] * p[0]]
    along = sum(a * b for a, b in zip(n, p))
    c, s = math.cos(angle), math.sin(angle)
    return [c * p[i] + s * cross[i] + (1 - c) * along * n[i] for i in range(3)]


class Normal:
    """Standard normal numbers by Box and Muller from random.random() (MT19937)."""

    def __init__(self, seed):
        self.uniform = random.Random(seed).random
        self.spare = None

    def __call__(self):
        if self.spare is not None:
            value, self.spare = self.spare, None
            return value
        radius = math.sqrt(-2.0 * math.log(1.0 - self.uniform()))
        angle = 2.0 * math.pi * self.uniform()
        self.spare = radius * math.sin(angle)
        return radius * math.cos(angle)


def draw_configurations(markers, seed):
    """Random configurations above the floor, each as far as possible from those before."""
    uniform = random.Random(seed).random
    nominal = dict.fromkeys(ERRORS, 0.0)

    def is_high_enough(q):
        return all(flange(q, nominal).point(p)[2] >= FLOOR_MM for p in markers.values())

    def distance(a, b):
        return sum(((x - y) / (high - low)) ** 2 for x, y, (low, high) in zip(a, b, RANGES))

    candidates = []
    while len(candidates) < CANDIDATES:
        q = tuple(round(low + (high - low) * uniform(), 4) for low, high in RANGES)
        if is_high_enough(q):
            candidates.append(q)
    chosen = [candidates[0]]
    while len(chosen) < CONFIGURATIONS:
        chosen.append(max(candidates, key=lambda q: min(distance(q, other) for other in chosen)))
    return chosen[0::2] + chosen[1::2]  # both stations see the whole range


def write(path, comment, header, rows):
    lines = ["# " + line for line in comment] + [",".join(header)] + [",".join(row) for row in rows]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def spring_torque(spring, q):
    """N m on A2: - dU/dq of the spring between (a_x, a_y) and -L (sin q, cos q), mm and N/mm."""
    u = spring["a_x_mm"] + spring["L_mm"] * math.sin(q)
    v = spring["a_y_mm"] + spring["L_mm"] * math.cos(q)
    length = math.hypot(u, v)
    by_q = spring["L_mm"] * (u * math.cos(q) - v * math.sin(q)) / length
    return -spring["Kc_N_per_mm"] * (length - spring["s0_mm"]) * by_q / 1e3


def loaded_arm(q_deg, error, truth, force, point):
    """Flange and joints at equilibrium; force in the base frame, N, at point on the flange, mm."""
    deflection = [0.0] * 6
    while True:
        joints = []
        frame = flange(q_deg, error, deflection, joints)
        at = frame.point(point)
        torque = [dot(axis, cross([(a - o) / 1e3 for a, o in zip(at, origin)], force)) for axis, origin, _ in joints]
        torque[1] += spring_torque(truth["spring"], math.radians(q_deg[1]) + error["dq2"] + deflection[1])
        bent = [k * 1e-6 * tau for k, tau in zip(truth["compliance_urad_per_Nm"], torque)]
        if max(abs(a - b) for a, b in zip(bent, deflection)) < 1e-15:
            return frame, joints
        deflection = bent


def write_loaded(path, configurations, error, markers, geometric, truth):
    """All stages of paper 002 in one file: geometry, hung loads, sideways pulls, markers on the links."""
    normal = Normal(truth["seed"])
    stations = dict(geometric["stations"], S3=truth["stations"]["S3"])
    hung, pulls = (0.0, 0.0, -truth["load_N"]), ((truth["pull_N"], 0.0, 0.0), (0.0, truth["pull_N"], 0.0))
    shots = [("geometry", "C%02d" % (c + 1), STATIONS[c * len(STATIONS) // CONFIGURATIONS], "none", (0.0,) * 3, q,
              markers, geometric["noise"]["sigma_mm"]) for c, q in enumerate(configurations)]
    for c, q in enumerate(ELASTOSTATIC):
        states = [("loads", "none", (0.0,) * 3), ("loads", "V250", hung)]
        if "E%02d" % (c + 1) in truth["pulled"]:
            states += [("pulls", "HX", pulls[0]), ("pulls", "HY", pulls[1])]
        shots += [(stage, "E%02d" % (c + 1), "S3", load, force, q, truth["markers"], truth["sigma_mm"])
                  for stage, load, force in states]
    for c, q2 in enumerate((0, -30, -60, -90, -120, -140)):
        shots.append(("compensator", "G%02d" % (c + 1), "S3", "none", (0.0,) * 3, (15, q2, 90, 0, 30, 0),
                      truth["link_markers"], truth["sigma_mm"]))
    rows = []
    for stage, config, station, load, force, q, seen, sigma in shots:
        turned_by = [value / 1e3 for value in stations[station]["rotvec_mrad"]] if station == "S3" else \
            [math.radians(value) for value in stations[station]["rotvec_deg"]]
        in_base = rotate([-value for value in turned_by], force)
        frame, joints = loaded_arm(q, error, truth, in_base, truth["load_point_mm"])
        for name, point in sorted(seen.items()):
            if stage == "compensator":
                _, origin, axes = joints[point["after_joint"]]
                at = [origin[i] + sum(point["xyz_mm"][k] * axes[k][i] for k in range(3)) for i in range(3)]
            else:
                at = frame.point(point)
            exact = [t + r for t, r in zip(stations[station]["xyz_mm"], rotate(turned_by, at))]
            rows.append([stage, config, name, station, load] + ["%.4f" % value for value in q] +
                        ["%.6f" % (value + sigma * normal()) for value in exact] + ["%g" % sigma] * 3 +
                        ["%.4f" % value for value in force])
    write(path, ["Simulated by make_kr270.py from loaded_truth.json (paper 002's stages); not measured.",
                 "seed %d. See ../SOURCES.md." % truth["seed"]],
          ["stage", "config", "marker", "station", "load"] + ["q%d_deg" % (j + 1) for j in range(6)] +
          ["x_mm", "y_mm", "z_mm", "sigma_x_mm", "sigma_y_mm", "sigma_z_mm", "fx_N", "fy_N", "fz_N"], rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=pathlib.Path, default=HERE / "kr270")
    out = parser.parse_args().out

    truth = json.loads((HERE / "kr270" / "truth.json").read_text(encoding="utf-8"))
    error = {name: entry["value_mm"] if "value_mm" in entry else math.radians(entry["value_deg"])
             for name, entry in ((name, truth["geometry"][name]) for name in ERRORS)}
    markers = {name: truth["markers"][name]["xyz_mm"] for name in MARKERS}
    sigma, seed = truth["noise"]["sigma_mm"], truth["noise"]["seed"]

    columns = ["config", "marker", "station"] + ["q%d_deg" % (j + 1) for j in range(6)]
    commanded, measured = [], []
    normal = Normal(seed)
    for c, q in enumerate(draw_configurations(markers, seed)):
        station = STATIONS[c * len(STATIONS) // CONFIGURATIONS]
        base = truth["stations"][station]
        turned_by = [math.radians(value) for value in base["rotvec_deg"]]
        for name in MARKERS:
            in_base = flange(q, error).point(markers[name])
            exact = [t + r for t, r in zip(base["xyz_mm"], rotate(turned_by, in_base))]
            row = ["C%02d" % (c + 1), name, station] + ["%.4f" % value for value in q]
            commanded.append(row)
            measured.append(row + ["%.6f" % (value + sigma * normal()) for value in exact])

    loaded = json.loads((HERE / "kr270" / "loaded_truth.json").read_text(encoding="utf-8"))
    write_loaded(out / "loaded.csv", draw_configurations(markers, seed), error, markers, truth, loaded)
    simulated = ["Simulated by make_kr270.py from truth.json (paper 002, Tables I-III); not measured.",
                 "sigma %g mm per axis, seed %d. See ../SOURCES.md." % (sigma, seed)]
    write(out / "geometric.csv", simulated, columns + ["x_mm", "y_mm", "z_mm"], measured)
    write(out / "configurations.csv", ["The configurations of geometric.csv, without points (make_kr270.py)."], columns,
          commanded)
    write(out / "elastostatic_configurations.csv",
          ["Paper 000, Table II = paper 003, Table 2: the 15 elastostatic configurations, without points."],
          columns, [["E%02d" % (c + 1), name, "S1"] + ["%.2f" % value for value in q]
                    for c, q in enumerate(ELASTOSTATIC) for name in MARKERS])


if __name__ == "__main__":
    main()
