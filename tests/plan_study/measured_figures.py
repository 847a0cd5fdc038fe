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


def models(program, folder, source, rows, sigma_mm):
    """Those that are calibrated, by name."""
    text = (source / "robot.yaml").read_text()
    joints = re.findall(r"name: (\S+), type", text)
    (folder / "robot.yaml").write_text(text)
    write_table(folder / "all.csv", rows, POSE + POINT)
    (folder / "all.yaml").write_text(HEAD % "all.csv" + "noise: {sigma_mm: %g}\n" % sigma_mm)
    free = [(p["name"], p["unit"]) for p in program.calibrate(folder, "all.yaml")["parameters"]
            if p["free"] and p["name"].startswith("geometry/")]
    return {"geometry alone": Model(text, sigma_mm),
            "geometry and joint harmonics of orders 1 and 2, priors 60 urad, 0.5 mm, 0.05 deg":
                Model(text, sigma_mm, free, (1, 2), joints)}


def former(program, folder, model, rows):
    """estimate.json of these rows: what a plan knows of the model error."""
    (folder / "robot.yaml").write_text(model.robot)
    write_table(folder / "former.csv", rows, POSE + POINT)
    (folder / "former.yaml").write_text(HEAD % "former.csv" + model.settings + "validation: none\n")
    estimate = program.calibrate(folder, "former.yaml")
    (folder / "calibrated/estimate.json").replace(folder / "former.json")
    return estimate["cross_validation"]


def planned(program, folder, campaign, model, poses, knows_error):
    """Ids of the poses that a plan chooses, and plan.json; campaign.csv are all rows, candidates.csv those to choose
    from."""
    (folder / "robot.yaml").write_text(model.robot)
    write_table(folder / "campaign.csv", campaign, POSE + POINT + ["set"])
    (folder / "campaign.yaml").write_text(HEAD % "campaign.csv" + model.settings)
    more = ["--model_error=former.json"] if knows_error else []
    plan, rows = program.plan(folder, "campaign.yaml", "--candidates=candidates.csv", "--poses=%d" % poses, *more)
    return {row["config"] for row in rows}, plan


KNOWN = {"as if the model were true": False, "with the former estimate's model error": True}


def marked(calibration, validation):
    return [dict(row, set="calibration") for row in calibration] + [dict(row, set="validation") for row in validation]


def ur5(folder, options):
    """20 of the 1000 grid poses. Judged on the 20 poses drawn at random, which are in no plan, and on the grid poses that
    were not chosen; then 20 times from 300 of the grid poses, drawn at random, for how much plans differ. The former
    estimate is that of all grid poses: it gives the plan one number, the model error."""
    program, source = Program(options.build), options.shared.resolve() / "data/ur5_gts3800"
    rows = table(source / "measurements.csv")
    grid, apart = [r for r in rows if r["group"] == "grid"], [r for r in rows if r["group"] == "random"]

    def judged(model, chosen, tests):
        (folder / "robot.yaml").write_text(model.robot)
        write_table(folder / "rows.csv", marked(chosen, tests), POSE + POINT + ["set"])
        (folder / "rows.yaml").write_text(HEAD % "rows.csv" + model.settings)
        return program.calibrate(folder, "rows.yaml")["validation"]["distance_rms_mm"]

    def chosen_from(pool, model, knows_error):
        write_table(folder / "candidates.csv", pool, POSE + POINT)
        ids, plan = planned(program, folder, marked(grid, apart), model, 20, knows_error)
        return [r for r in grid if r["config"] in ids], [r for r in grid if r["config"] not in ids], plan

    for name, model in models(program, folder, source, grid, 0.05).items():
        seen = former(program, folder, model, grid)
        every = judged(model, grid, apart)
        source_of_sets = random.Random(1)
        sets = [source_of_sets.sample(grid, 20) for _ in range(options.random or 100)]
        others = [judged(model, one, apart) for one in sets]
        others_left = [judged(model, one, [r for r in grid if r not in one]) for one in sets[:30]]
        print("calibrated: %s\n  all 1000: %.4f mm at the 20 random poses; cross-validation %.4f mm per coordinate where "
              "%.4f mm were predicted" % (name, every, seen["rms_mm"], seen["predicted_rms_mm"]))
        print("  %d random 20s, ratio: least, 5 %%, median, 95 %%, largest: %s; %d at the grid poses left: %s mm" % (
            len(others), quantiles([o / every for o in others]), len(others_left), quantiles(others_left)), flush=True)
        for known, knows_error in KNOWN.items():
            chosen, left, plan = chosen_from(grid, model, knows_error)
            own, own_left = judged(model, chosen, apart), judged(model, chosen, left)
            alone = plan["predicted"]["position_rms_mm"]
            print("  planned %s: gap %.1f %%, ratio %.3f, better than %.0f %%; at the grid poses left %.4f mm, better than "
                  "%.0f %%" % (known, 100 * (1 / plan["certificate"]["efficiency"] - 1), own / every,
                               100 * better_than(own, others), own_left, 100 * better_than(own_left, others_left)))
            print("    readings' noise alone leaves %.4f mm: a ratio of %.3f were the model true" % (
                alone, (1 + (alone / every) ** 2) ** 0.5))
            pools = [source_of_sets.sample(grid, 300) for _ in range(20)]
            ratios = [judged(model, chosen_from(pool, model, knows_error)[0], apart) / every for pool in pools]
            print("    from 300 of them, 20 times: ratio %s; at most 1.10 in %d" % (
                quantiles(ratios), sum(ratio <= 1.10 for ratio in ratios)), flush=True)


def ur10(folder, options):
    """40 of the 1495 poses of series B for the poses of C and D as test poses. Judged by fitting base and marker alone to
    C and to D with the robot that the 40 gave. The former estimate is that of all of series B."""
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

    for name, model in models(program, folder, source, series["B"], 0.2).items():
        seen = former(program, folder, model, series["B"])
        source_of_sets = random.Random(2)
        others = [judged(model, source_of_sets.sample(series["B"], 40)) for _ in range(options.random or 100)]
        print("calibrated: %s; cross-validation of series B %.3f mm per coordinate where %.3f mm were predicted" % (
            name, seen["rms_mm"], seen["predicted_rms_mm"]), flush=True)
        for known, knows_error in KNOWN.items():
            ids, plan = planned(program, folder, marked(series["B"], series["C"] + series["D"]), model, 40, knows_error)
            own = judged(model, [row for row in series["B"] if row["config"] in ids])
            print("  planned %s (gap %.1f %%)" % (known, 100 * (1 / plan["certificate"]["efficiency"] - 1)))
            for k, what in enumerate(("C", "D", "C and D")):
                values = [other[k] for other in others]
                print("    series %s: %.3f mm; %d random 40s %s mm; better than %.0f %%" % (
                    what, own[k], len(values), quantiles(values), 100 * better_than(own[k], values)), flush=True)
