"""Figures of measured robots (../shared/data): poses chosen out of those that were measured."""
import random
import re

from program import Program, better_than, quantiles, table, write_table

POSE = ["config", "marker", "station"] + ["q%d_deg" % (i + 1) for i in range(6)]
POINT = ["x_mm", "y_mm", "z_mm"]
HEAD = "schema: sagitta/experiment/1\nrobot: robot.yaml\nmeasurements: [%s]\n"


class Model:
    """What is unknown: geometry alone, or with joint harmonics of order 1 and 2 and priors for both."""

    def __init__(self, robot_text, geometry, with_harmonics, joints):
        self.robot, self.settings = robot_text, "noise: {sigma_mm: %g}\n"
        if not with_harmonics:
            return
        terms = [(order, joint) for order in (1, 2) for joint in joints]
        self.robot += "effects:\n" + "".join(
            "  - {effect: joint_harmonic, joint: %s, order: %d, cos_urad: 0, sin_urad: 0}\n" % (joint, order)
            for order, joint in terms)
        self.settings += "priors:\n" + "".join(
            "  effect/joint_harmonic[order=%d]/%s/%s: {value: 0, sigma: 60}\n" % (order, joint, part)
            for order, joint in terms for part in ("cos", "sin"))
        self.settings += "".join("  %s: {value: 0, sigma: %g}\n" % (name, 0.5 if unit == "mm" else 0.05)
                                 for name, unit in geometry)


def models(program, folder, source, rows, sigma):
    """Both models, by name; the second's priors are for the parameters that are free by default."""
    text = (source / "robot.yaml").read_text()
    joints = re.findall(r"name: (\S+), type", text)
    (folder / "robot.yaml").write_text(text)
    write_table(folder / "all.csv", rows, POSE + POINT)
    (folder / "all.yaml").write_text(HEAD % "all.csv" + "noise: {sigma_mm: %g}\n" % sigma)
    free = [(p["name"], p["unit"]) for p in program.calibrate(folder, "all.yaml")["parameters"]
            if p["free"] and p["name"].startswith("geometry/")]
    made = {"geometry alone": Model(text, free, False, joints),
            "with joint harmonics, priors 60 urad, 0.5 mm, 0.05 deg": Model(text, free, True, joints)}
    for model in made.values():
        model.settings = model.settings % sigma if "%g" in model.settings else model.settings
    return made


def ur5(folder, options):
    """20 of the 1000 grid poses. Judged on the 20 poses drawn at random, which are in no plan, and on the grid poses that
    were not chosen."""
    program, source = Program(options.build), options.shared.resolve() / "data/ur5_gts3800"
    rows = table(source / "measurements.csv")
    grid, apart = [r for r in rows if r["group"] == "grid"], [r for r in rows if r["group"] == "random"]
    write_table(folder / "grid.csv", grid, POSE + POINT)

    def judged(model, chosen, tests):
        marked = [dict(row, set="calibration") for row in chosen] + [dict(row, set="validation") for row in tests]
        write_table(folder / "rows.csv", marked, POSE + POINT + ["set"])
        (folder / "rows.yaml").write_text(HEAD % "rows.csv" + model.settings)
        return program.calibrate(folder, "rows.yaml")["validation"]["distance_rms_mm"]

    for name, model in models(program, folder, source, grid, 0.05).items():
        (folder / "robot.yaml").write_text(model.robot)
        every = judged(model, grid, apart)
        marked = [dict(row, set="calibration") for row in grid] + [dict(row, set="validation") for row in apart]
        write_table(folder / "campaign.csv", marked, POSE + POINT + ["set"])
        (folder / "campaign.yaml").write_text(HEAD % "campaign.csv" + model.settings)
        plan, planned = program.plan(folder, "campaign.yaml", "--candidates=grid.csv", "--poses=20")
        ids = {row["config"] for row in planned}
        chosen, left = [r for r in grid if r["config"] in ids], [r for r in grid if r["config"] not in ids]
        own, own_left = judged(model, chosen, apart), judged(model, chosen, left)
        source_of_sets = random.Random(1)
        sets = [source_of_sets.sample(grid, 20) for _ in range(options.random or 100)]
        others = [judged(model, one, apart) for one in sets]
        print("%s\n  all 1000: %.4f mm at the 20 random poses; planned 20: %.4f mm, ratio %.3f; certificate within %.1f %%" % (
            name, every, own, own / every, 100 * (1 / plan["certificate"]["efficiency"] - 1)))
        print("  %d random 20s: least, 5 %%, median, 95 %%, largest: %s mm; the plan is better than %.0f %%" % (
            len(others), quantiles(others), 100 * better_than(own, others)))
        others_left = [judged(model, one, [r for r in grid if r not in one]) for one in sets[:30]]
        print("  at the grid poses left: planned %.4f mm; 30 random 20s: %s mm" % (own_left, quantiles(others_left)))


def ur10(folder, options):
    """40 of the 1495 poses of series B for the poses of C and D as test poses. Judged by fitting base and marker alone to
    C and to D with the robot that the 40 gave."""
    program, source = Program(options.build), options.shared.resolve() / "data/ur10_leica"
    series = {name: [dict(row, config=row["config"]) for row in table(source / ("series_%s.csv" % name))] for name in "BCD"}
    write_table(folder / "candidates.csv", series["B"], POSE + POINT)
    everything = [dict(row, set="calibration" if name == "B" else "validation")
                  for name in "BCD" for row in series[name]]
    write_table(folder / "campaign.csv", everything, POSE + POINT + ["set"])

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
        both = (sum(n * value ** 2 for n, value in zip(count, off)) / sum(count)) ** 0.5
        return off + [both]

    for name, model in models(program, folder, source, series["B"], 0.2).items():
        (folder / "robot.yaml").write_text(model.robot)
        (folder / "campaign.yaml").write_text(HEAD % "campaign.csv" + model.settings)
        plan, planned = program.plan(folder, "campaign.yaml", "--candidates=candidates.csv", "--poses=40")
        ids = {row["config"] for row in planned}
        own = judged(model, [row for row in series["B"] if row["config"] in ids])
        source_of_sets = random.Random(2)
        others = [judged(model, source_of_sets.sample(series["B"], 40)) for _ in range(options.random or 100)]
        print("%s\n  certificate within %.1f %%; predicted %.3f mm" % (
            name, 100 * (1 / plan["certificate"]["efficiency"] - 1), plan["predicted"]["position_rms_mm"]))
        for k, what in enumerate(("series C", "series D", "C and D")):
            values = [other[k] for other in others]
            print("  %s: planned 40 %.3f mm; %d random 40s %s mm; better than %.0f %%" % (
                what, own[k], len(values), quantiles(values), 100 * better_than(own[k], values)))
