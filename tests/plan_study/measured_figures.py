"""Figures of measured robots (../shared/data): poses chosen out of those that were measured."""
import random
import re

from program import Program, better_than, quantiles, table, write_table

POSE = ["config", "marker", "station"] + ["q%d_deg" % (i + 1) for i in range(6)]
POINT = ["x_mm", "y_mm", "z_mm"]
HEAD = "schema: sagitta/experiment/1\nrobot: robot.yaml\nmeasurements: [%s]\n"


class Model:
    """What is unknown: geometry, and joint harmonics of the listed orders with priors for both."""

    def __init__(self, robot_text, sigma_mm, geometry=(), orders=(), joints=()):
        self.robot, self.settings = robot_text, "noise: {sigma_mm: %g}\n" % sigma_mm
        terms = [(order, joint) for order in orders for joint in joints]
        if not terms:
            return
        self.robot += "effects:\n" + "".join(
            "  - {effect: joint_harmonic, joint: %s, order: %d, cos_urad: 0, sin_urad: 0}\n" % (joint, order)
            for order, joint in terms)
        self.settings += "priors:\n" + "".join(
            "  effect/joint_harmonic[order=%d]/%s/%s: {value: 0, sigma: 60}\n" % (order, joint, part)
            for order, joint in terms for part in ("cos", "sin"))
        self.settings += "".join("  %s: {value: 0, sigma: %g}\n" % (name, 0.5 if unit == "mm" else 0.05)
                                 for name, unit in geometry)


def models(program, folder, source, rows, sigma_mm, reach_mm):
    """Those that are calibrated, by name, and those that plans know besides: four orders of harmonics stand for what may
    be wrong with the model; the data sheets state a repeatability of 0.1 mm, here at the robot's reach."""
    text = (source / "robot.yaml").read_text()
    joints = re.findall(r"name: (\S+), type", text)
    (folder / "robot.yaml").write_text(text)
    write_table(folder / "all.csv", rows, POSE + POINT)
    (folder / "all.yaml").write_text(HEAD % "all.csv" + "noise: {sigma_mm: %g}\n" % sigma_mm)
    free = [(p["name"], p["unit"]) for p in program.calibrate(folder, "all.yaml")["parameters"]
            if p["free"] and p["name"].startswith("geometry/")]
    calibrated = {"geometry alone": Model(text, sigma_mm),
                  "geometry and joint harmonics of orders 1 and 2, priors 60 urad, 0.5 mm, 0.05 deg":
                      Model(text, sigma_mm, free, (1, 2), joints)}
    flexible, arriving = (Model(text, sigma_mm, free, (1, 2, 3, 4), joints) for _ in range(2))
    arriving.settings += "repeatability_urad: %.0f\n" % (1e6 * 0.1 / reach_mm)
    return calibrated, {"harmonics of orders 1 to 4": flexible,
                        "harmonics of orders 1 to 4 and repeatability": arriving}


def planned(program, folder, campaign, model, poses):
    """Ids of the poses that a plan chooses; campaign.csv are all rows, candidates.csv those to choose from."""
    (folder / "robot.yaml").write_text(model.robot)
    write_table(folder / "campaign.csv", campaign, POSE + POINT + ["set"])
    (folder / "campaign.yaml").write_text(HEAD % "campaign.csv" + model.settings)
    plan, rows = program.plan(folder, "campaign.yaml", "--candidates=candidates.csv", "--poses=%d" % poses)
    return {row["config"] for row in rows}, 100 * (1 / plan["certificate"]["efficiency"] - 1)


def marked(calibration, validation):
    return [dict(row, set="calibration") for row in calibration] + [dict(row, set="validation") for row in validation]


def ur5(folder, options):
    """20 of the 1000 grid poses. Judged on the 20 poses drawn at random, which are in no plan, and on the grid poses that
    were not chosen."""
    program, source = Program(options.build), options.shared.resolve() / "data/ur5_gts3800"
    rows = table(source / "measurements.csv")
    grid, apart = [r for r in rows if r["group"] == "grid"], [r for r in rows if r["group"] == "random"]
    write_table(folder / "candidates.csv", grid, POSE + POINT)

    def judged(model, chosen, tests):
        (folder / "robot.yaml").write_text(model.robot)
        write_table(folder / "rows.csv", marked(chosen, tests), POSE + POINT + ["set"])
        (folder / "rows.yaml").write_text(HEAD % "rows.csv" + model.settings)
        return program.calibrate(folder, "rows.yaml")["validation"]["distance_rms_mm"]

    calibrated, flexible = models(program, folder, source, grid, 0.05, 850)
    for name, model in calibrated.items():
        every = judged(model, grid, apart)
        source_of_sets = random.Random(1)
        sets = [source_of_sets.sample(grid, 20) for _ in range(options.random or 100)]
        others = [judged(model, one, apart) for one in sets]
        others_left = [judged(model, one, [r for r in grid if r not in one]) for one in sets[:30]]
        print("calibrated: %s\n  all 1000: %.4f mm at the 20 random poses" % (name, every))
        print("  %d random 20s: least, 5 %%, median, 95 %%, largest: %s mm; 30 at the grid poses left: %s mm" % (
            len(others), quantiles(others), quantiles(others_left)))
        for known, planning in {"the same model": model, **flexible}.items():
            ids, gap = planned(program, folder, marked(grid, apart), planning, 20)
            chosen, left = [r for r in grid if r["config"] in ids], [r for r in grid if r["config"] not in ids]
            own, own_left = judged(model, chosen, apart), judged(model, chosen, left)
            print("  planned with %s (within %.1f %%): %.4f mm, ratio %.3f, better than %.0f %%; at the grid poses left "
                  "%.4f mm, better than %.0f %%" % (known, gap, own, own / every, 100 * better_than(own, others), own_left,
                                                    100 * better_than(own_left, others_left)))


def ur10(folder, options):
    """40 of the 1495 poses of series B for the poses of C and D as test poses. Judged by fitting base and marker alone to
    C and to D with the robot that the 40 gave."""
    program, source = Program(options.build), options.shared.resolve() / "data/ur10_leica"
    series = {name: table(source / ("series_%s.csv" % name)) for name in "BCD"}
    write_table(folder / "candidates.csv", series["B"], POSE + POINT)

    def judged(model, chosen):
        (folder / "robot.yaml").write_text(model.robot)
        write_table(folder / "rows.csv", chosen, POSE + POINT)
        (folder / "rows.yaml").write_text(HEAD % "rows.csv" + model.settings + "validation: none\n")
        program.calibrate(folder, "rows.yaml")
        (folder / "robot.yaml").write_text((folder / "calibrated/robot.calibrated.yaml").read_text())
        off = []
        for name in "CD":
            write_table(folder / "rows.csv", series[name], POSE + POINT)
            (folder / "rows.yaml").write_text(
                HEAD % "rows.csv" + "noise: {sigma_mm: 0.2}\nestimate: {geometry: none, effects: none}\nvalidation: none\n")
            off.append(program.calibrate(folder, "rows.yaml")["fit"]["distance_rms_mm"])
        count = [len(series[name]) for name in "CD"]
        return off + [(sum(n * value ** 2 for n, value in zip(count, off)) / sum(count)) ** 0.5]

    calibrated, flexible = models(program, folder, source, series["B"], 0.2, 1300)
    for name, model in calibrated.items():
        source_of_sets = random.Random(2)
        others = [judged(model, source_of_sets.sample(series["B"], 40)) for _ in range(options.random or 100)]
        print("calibrated: %s" % name)
        for known, planning in {"the same model": model, **flexible}.items():
            ids, gap = planned(program, folder, marked(series["B"], series["C"] + series["D"]), planning, 40)
            own = judged(model, [row for row in series["B"] if row["config"] in ids])
            print("  planned with %s (within %.1f %%)" % (known, gap))
            for k, what in enumerate(("C", "D", "C and D")):
                values = [other[k] for other in others]
                print("    series %s: %.3f mm; %d random 40s %s mm; better than %.0f %%" % (
                    what, own[k], len(values), quantiles(values), 100 * better_than(own[k], values)))
