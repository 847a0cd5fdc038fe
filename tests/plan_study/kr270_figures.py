"""Figures of the KR 270 of papers 000, 002 and 003 (problems/published)."""
import json
import pathlib
import random
import re
import resource
import time

from program import Program, quantiles, table, write_poses

PUBLISHED = pathlib.Path(__file__).resolve().parents[2] / "problems/published/kr270"
LIMITS = [(-185, 185), (-146, 0), (-119, 155), (-350, 350), (-125, 125), (-350, 350)]


def drawn(count, seed, prefix):
    source = random.Random(seed)
    return {"%s%d" % (prefix, k): [source.uniform(*limit) for limit in LIMITS] for k in range(count)}


def rigid_robot():
    return re.sub(r"(?m)^compliance:.*\n", "", (PUBLISHED / "robot.yaml").read_text())


def elastostatic(folder, options):
    """Compliances alone unknown, as the papers have it: base, tool and geometry are known from the step before. k2 has a
    value of its own at each of the five q2; compliances are the published ones, 250 kg hang at the markers' centroid."""
    published = json.loads((PUBLISHED / "published.json").read_text())
    scene, levels = published["scene"], published["compliance"]["q2_deg"]
    k = published["compliance"]["wls"]
    nodes = ", ".join("{q_deg: %g, k_urad_per_Nm: %g}" % pair for pair in sorted(zip(levels, k)))
    others = "".join("  A%d: {k_urad_per_Nm: %g}\n" % (j, k[2 + j]) for j in (3, 4, 5, 6))
    (folder / "robot.yaml").write_text(rigid_robot() + "compliance:\n  A2: {table: [%s]}\n%s" % (nodes, others))
    centroid = [sum(marker[i] for marker in scene["markers_mm"]) / 3 for i in range(3)]
    markers = ", ".join("P%d: {xyz_mm: %s}" % (i + 1, m) for i, m in enumerate(scene["markers_mm"]))
    (folder / "experiment.yaml").write_text(
        "schema: sagitta/experiment/1\nrobot: robot.yaml\nmeasurements: [published.csv]\nload_point_mm: %s\n"
        "loads: {V250: {mass_kg: %g}}\nmarkers: {%s}\nstations: {S1: {xyz_mm: %s, rotvec_mrad: %s}}\n"
        "noise: {sigma_mm: 0.03}\n"
        "estimate: {base: false, markers: false, geometry: none, compliance: [A2, A3, A4, A5, A6]}\nvalidation: none\n"
        % (centroid, scene["load_kg"], markers, scene["base_xyz_mm"], scene["base_rotvec_mrad"]))
    (folder / "cell.yaml").write_text(
        "schema: sagitta/cell/1\nfloor_mm: 200\njoints: {A2: {levels_deg: %s}}\n" % levels)
    fifteen = {row["config"]: [float(row["q%d_deg" % (i + 1)]) for i in range(6)]
               for row in table(PUBLISHED / "elastostatic_configurations.csv")}
    write_poses(folder / "published.csv", fifteen, station="S1", load="V250")
    write_poses(folder / "tests.csv", drawn(100, 1, "T"), station="S1", load="V250")
    program = Program(options.build)
    for name, tests in (("the published 15 themselves", []), ("100 random poses", ["--tests=tests.csv"])):
        theirs, _ = program.plan(folder, "experiment.yaml", "--candidates=published.csv", "--poses=15", *tests)
        ours, rows = program.plan(folder, "experiment.yaml", "--cell=cell.yaml", "--pool=1000", "--poses=15", *tests)
        print("test poses: %s" % name)
        print("  predicted RMS: published %.4f mm, planned %.4f mm; gap of the certificate %.1f %% of the variance" % (
            theirs["predicted"]["position_rms_mm"], ours["predicted"]["position_rms_mm"],
            100 * (1 / ours["certificate"]["efficiency"] - 1)))
        values = [float(row["q2_deg"]) for row in rows]
        print("  configurations on q2 =", ", ".join(
            "%g: %d" % (level, sum(abs(value - level) < 1e-6 for value in values) / 3) for level in levels))
        for before, after in zip(theirs["parameters"], ours["parameters"]):
            print("  sigma of %-22s published %.4g, planned %.4g urad/Nm" % (
                before["name"], before["sigma"], after["sigma"]))


def geometric(folder, options):
    """18 configurations, nine from each of two stations, of paper 002's geometric calibration; test poses: the 18 of
    problems/published/kr270/geometric.csv."""
    program, experiment = Program(options.build), PUBLISHED / "experiment.yaml"
    plan, _ = program.plan(folder, experiment, "--poses=18", "--pool=1000")
    predicted = plan["predicted"]["position_rms_mm"]
    print("planned: %.4f mm predicted at the test poses; %s" % (predicted, plan["certificate"]["words"]))
    (folder / "planned/plan.csv").replace(folder / "rows.csv")
    sets = []
    for seed in range(options.random or 1000):
        write_poses(folder / "random.csv", drawn(18, seed, "R"), station=lambda number: "S%d" % (1 + number % 2))
        one, _ = program.plan(folder, experiment, "--candidates=random.csv", "--poses=18")
        sets.append(one["predicted"]["position_rms_mm"])
    print("%d random sets: least, 5 %%, median, 95 %%, largest: %s mm" % (len(sets), quantiles(sets)))
    simulated(folder, predicted)


def simulated(folder, predicted, trials=1000):
    import numpy as np  # pylint: disable=import-outside-toplevel
    import sagitta  # pylint: disable=import-outside-toplevel
    truth = sagitta.calibrate(sagitta.read(str(PUBLISHED / "experiment.yaml")))
    tests = str(PUBLISHED / "configurations.csv")
    exact = truth.known.predict(tests).points_m
    noise = {"sigma_mm": 0.1}
    rows = sagitta.read(str(PUBLISHED / "robot.yaml"), str(folder / "rows.csv"), points_required=False, noise=noise)
    squares = []
    for seed in range(trials):
        drawn_rows = sagitta.simulate(rows, truth, sigma_mm=0.1, seed=seed)
        estimate = sagitta.calibrate(
            sagitta.read(str(PUBLISHED / "robot.yaml"), drawn_rows.to_dataframe(), noise=noise))
        off = estimate.known.predict(tests).points_m - exact
        squares.append(np.mean(np.sum(off ** 2, axis=1)))
    rmse = 1e3 * np.sqrt(np.mean(squares))
    spread = np.std(squares) / np.mean(squares) / 2 / np.sqrt(trials)
    print("%d simulated calibrations: RMSE at the test poses %.4f mm, %+.1f %% from the prediction (+-%.1f %%, 1 sigma)" % (
        trials, rmse, 100 * (rmse / predicted - 1), 100 * spread))


def speed(folder, options):
    """50000 poses from two stations, 39 unknowns of the KR 270 and 22 of joint harmonics."""
    harmonics = [(1, j) for j in range(1, 7)] + [(2, j) for j in range(1, 6)]
    effects = "".join("  - {effect: joint_harmonic, joint: A%d, order: %d, cos_urad: 0, sin_urad: 0}\n" % (j, order)
                      for order, j in harmonics)
    (folder / "robot.yaml").write_text(rigid_robot() + "effects:\n" + effects)
    text = (PUBLISHED / "experiment.yaml").read_text()
    (folder / "experiment.yaml").write_text(text.replace("[geometric.csv]", "[%s]" % (PUBLISHED / "geometric.csv")))
    begun, before = time.time(), resource.getrusage(resource.RUSAGE_CHILDREN)
    plan, _ = Program(options.build).plan(folder, "experiment.yaml", "--poses=50", "--pool=50000")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    print("%d candidates, %d parameters, %d poses: %.1f s, %.1f s of processor time; %s" % (
        plan["candidates"], len(plan["parameters"]), plan["poses"], time.time() - begun,
        after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, plan["certificate"]["words"]))
