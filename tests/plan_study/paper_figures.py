"""Paper 002, Fig. 7, Tables IX and XIII: optimal poses against heuristic ones, with and without the gravity compensator.

The paper changes two things at once, its poses and its model, and prints neither the heuristic poses nor the validation
ones. Here both are changed one at a time, on a KR 270 whose k2 is that of paper 000, Table IV (one value per level of
q2, straight between them): what the compensator does to the equivalent compliance of axis 2.
"""
import json
import math
import random

from kr270_figures import PUBLISHED, drawn, rigid_robot
from program import Program, table, write_poses, write_table

SIGMA_MM, DRAWS = 0.03, 5


def chain(q_deg):
    """base_from_flange of the nominal KR 270, mm, and of each joint its axis and a point on it, base frame."""
    import numpy as np  # pylint: disable=import-outside-toplevel

    def turn(axis, angle):
        c, s = math.cos(angle), math.sin(angle)
        i, k = (axis + 1) % 3, (axis + 2) % 3
        matrix = np.eye(4)
        matrix[i, i], matrix[i, k], matrix[k, i], matrix[k, k] = c, -s, s, c
        return matrix

    def shift(x, y, z):
        matrix = np.eye(4)
        matrix[:3, 3] = x, y, z
        return matrix
    steps = [(shift(0, 0, 750), 2), (shift(350, 0, 0), 1), (shift(1250, 0, 0), 1), (shift(1100, 0, -55), 0),
             (shift(0, 0, 0), 1), (shift(0, 0, 0), 0)]
    here, axes = np.eye(4), []
    for (step, axis), q in zip(steps, q_deg):
        here = here @ step
        axes.append((here[:3, axis].copy(), here[:3, 3].copy()))
        here = here @ turn(axis, math.radians(q))
    return here @ shift(230, 0, 0), axes


def dexterity(q_deg):
    """Inverse condition number of the flange's Jacobian, lengths in units of 1.25 m: a kinematic performance measure."""
    import numpy as np  # pylint: disable=import-outside-toplevel
    flange, axes = chain(q_deg)
    columns = [np.concatenate([np.cross(axis, flange[:3, 3] - origin) / 1250, axis]) for axis, origin in axes]
    values = np.linalg.svd(np.array(columns).T, compute_uv=False)
    return values[-1] / values[0]


def heuristic(count):
    """The most dexterous of 3000 random poses, above the floor, no two nearer than 40 deg in their farthest joint."""
    poses = [q for q in drawn(3000, 7, "H").values() if chain(q)[0][2, 3] > 200]
    poses.sort(key=dexterity, reverse=True)
    chosen = []
    for q in poses:
        if all(max(abs(a - b) for a, b in zip(q, other)) > 40 for other in chosen):
            chosen.append(q)
        if len(chosen) == count:
            return {"H%d" % k: q for k, q in enumerate(chosen)}
    raise SystemExit("too few dexterous poses")


class Arm:
    def __init__(self, folder):
        published = json.loads((PUBLISHED / "published.json").read_text())
        self.folder, self.scene, self.k = folder, published["scene"], published["compliance"]
        self.table_ix, self.xiii = published["002-IX"], published["002-XIII"]
        self.levels = self.k["q2_deg"]
        truth = dict(zip(["A2", "A3", "A4", "A5", "A6"], [self.k["wls"][:5]] + self.k["wls"][5:]))
        flat = dict(truth, A2=[0.3])
        self.robots = {"truth": truth, "with": dict(truth, A2=[0.3] * 5), "without": flat,
                       "previous": dict(zip(["A2", "A3", "A4", "A5", "A6"],
                                            [[self.table_ix["previous_work"][1]]] + self.table_ix["previous_work"][2:])),
                       "this": dict(zip(["A2", "A3", "A4", "A5", "A6"],
                                        [[self.table_ix["this_work"][1]]] + self.table_ix["this_work"][2:]))}
        for name, values in self.robots.items():
            self.write_robot(name, values)

    def write_robot(self, name, values):
        k2 = values["A2"]
        nodes = ", ".join("{q_deg: %g, k_urad_per_Nm: %.12g}" % pair for pair in sorted(zip(self.levels, k2)))
        own = "{table: [%s]}" % nodes if len(k2) > 1 else "{k_urad_per_Nm: %.12g}" % k2[0]
        others = "".join("  %s: {k_urad_per_Nm: %.12g}\n" % (joint, values[joint]) for joint in ("A3", "A4", "A5", "A6"))
        (self.folder / (name + ".yaml")).write_text(rigid_robot() + "compliance:\n  A2: %s\n%s" % (own, others))

    def experiment(self, robot, rows):
        markers = ", ".join("P%d: {xyz_mm: %s}" % (i + 1, m) for i, m in enumerate(self.scene["markers_mm"]))
        centroid = [sum(marker[i] for marker in self.scene["markers_mm"]) / 3 for i in range(3)]
        path = self.folder / ("%s_%s.yaml" % (robot, rows))
        path.write_text(
            "schema: sagitta/experiment/1\nrobot: %s.yaml\nmeasurements: [%s.csv]\nload_point_mm: %s\n"
            "loads: {V250: {mass_kg: %g}}\nmarkers: {%s}\nstations: {S1: {xyz_mm: %s, rotvec_mrad: %s}}\n"
            "noise: {sigma_mm: %g}\nestimate: {base: false, markers: false, geometry: none, "
            "compliance: [A2, A3, A4, A5, A6]}\nvalidation: none\n" % (
                robot, rows, centroid, self.scene["load_kg"], markers, self.scene["base_xyz_mm"],
                self.scene["base_rotvec_mrad"], SIGMA_MM))
        return path


def of_axes(off):
    """max and RMS per axis and of distances, mm."""
    import numpy as np  # pylint: disable=import-outside-toplevel
    off = np.vstack(off)
    lengths = np.linalg.norm(off, axis=1)
    return [(np.abs(off[:, i]).max(), np.sqrt(np.mean(off[:, i] ** 2))) for i in range(3)] + [
        (lengths.max(), np.sqrt(np.mean(lengths ** 2)))]


def line(name, after, before):
    print("  %-52s" % name + "  ".join("%5.2f %5.2f (%4.1f %4.1f)" % (
        a[0], a[1], b[0] / a[0], b[1] / a[1]) for a, b in zip(after, before)))


def fig7(folder, options):
    """Errors at 100 random validation poses under 250 kg before and after compensation, readings of 0.03 mm."""
    import sagitta  # pylint: disable=import-outside-toplevel
    arm, program = Arm(folder), Program(options.build)
    (folder / "cell.yaml").write_text("schema: sagitta/cell/1\nfloor_mm: 200\njoints: {A2: {levels_deg: %s}}\n" % arm.levels)
    validation = {name: q for name, q in drawn(300, 1, "T").items() if chain(q)[0][2, 3] > 200}
    validation = dict(list(validation.items())[:100])
    write_poses(folder / "tests.csv", validation, station="S1", load="V250")
    write_poses(folder / "unloaded.csv", validation, station="S1", load="none")
    published = {row["config"]: [float(row["q%d_deg" % (i + 1)]) for i in range(6)]
                 for row in table(PUBLISHED / "elastostatic_configurations.csv")}
    source = random.Random(3)
    write_poses(folder / "published.csv", published, station="S1", load="V250")
    write_poses(folder / "heuristic.csv", heuristic(15), station="S1", load="V250")
    on_levels = {name: q[:1] + [source.choice(arm.levels)] + q[2:] for name, q in heuristic(15).items()}
    write_poses(folder / "levels.csv", on_levels, station="S1", load="V250")
    program.plan(folder, arm.experiment("with", "published").name, "--cell=cell.yaml", "--pool=300", "--poses=15",
                 "--tests=tests.csv")
    (folder / "planned/plan.csv").replace(folder / "optimal.csv")

    def simulated(robot, rows, sigma, seed):
        read = sagitta.read(str(arm.experiment(robot, rows)), points_required=False)
        return sagitta.simulate(read, sigma_mm=sigma, seed=seed).to_dataframe()[["x_mm", "y_mm", "z_mm"]].to_numpy()

    seen = [simulated("truth", "tests", SIGMA_MM, 100 + k) for k in range(DRAWS)]
    before = of_axes([one - simulated("truth", "unloaded", 1e-9, 1) for one in seen])
    print("max and RMS in mm (improvement factors) of x, y, z and distance")
    line("before compensation", before, before)
    xiii = arm.xiii
    for k, name in enumerate(xiii["columns"]):
        values = [(xiii[axis + "_max_mm"][k], xiii[axis + "_rms_mm"][k]) for axis in ("x", "y", "z", "distance")]
        line("paper 002, Table XIII: " + name.split(" (")[0], values,
             [(xiii[axis + "_max_mm"][0], xiii[axis + "_rms_mm"][0]) for axis in ("x", "y", "z", "distance")])
    for robot, name in (("previous", "Table IX, previous work, at these poses"), ("this", "Table IX, this work, k2 0.29")):
        off = simulated(robot, "tests", 1e-9, 1)
        line(name, of_axes([one - off for one in seen]), before)
    for rows, poses in (("heuristic", "heuristic"), ("levels", "heuristic, q2 on the five levels"),
                        ("published", "published optimal"), ("optimal", "planned")):
        for model in ("without", "with"):
            off, k2 = [], []
            for k in range(DRAWS):
                rows_of = table(folder / (rows + ".csv"))
                for row, point in zip(rows_of, simulated("truth", rows, SIGMA_MM, 1000 + k)):
                    row.update(zip(("x_mm", "y_mm", "z_mm"), ("%.6f" % value for value in point)))
                write_table(folder / ("read_%s.csv" % rows), rows_of)
                estimate = sagitta.calibrate(sagitta.read(str(arm.experiment(model, "read_" + rows))))
                off.append(seen[k] - 1e3 * estimate.known.predict(str(folder / "tests.csv")).points_m)
                k2.append([p["value"] for p in estimate.to_dict()["parameters"] if p["name"].startswith("compliance/A2")])
            line("%s, %s compensator" % (poses, model), of_axes(off), before)
            if model == "without":
                print("      k2 %.3f urad/Nm" % (sum(one[0] for one in k2) / len(k2)))
