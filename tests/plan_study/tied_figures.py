"""Ten pairs of explanations that share the probability because of how was measured, and six poses that decide."""
import csv
import io
import math
import random

from kr270_figures import LIMITS, PUBLISHED, rigid_robot
from program import MARKERS, Program, quantiles, table, write_table

SIGMA_MM = 0.05
POSES, MORE = 30, 6
DECIDED = 0.9
TIED = (0.1, 0.9)  # probability of the truth before
COMPLIANCE = ("compliance: {A2: {k_urad_per_Nm: 0.3}, A3: {k_urad_per_Nm: 0.42}, A4: {k_urad_per_Nm: 2.8}, "
              "A5: {k_urad_per_Nm: 3.5}, A6: {k_urad_per_Nm: 2.1}}\n")


def window(joints):
    """Poses over the whole limits, but for these joints, which stay near a value: {joint: (middle, half width)}, deg."""
    def draw(source):
        q = [source.uniform(0.8 * low + 0.1 * (low + high), 0.8 * high + 0.1 * (low + high)) for low, high in LIMITS]
        for joint, (middle, half) in joints.items():
            q[joint - 1] = source.uniform(middle - half, middle + half)
        return q
    return draw


def line(follower, driver, slope, at):
    """One joint follows another: q_follower = at + slope q_driver within 0.5 deg."""
    def draw(source):
        q = window({driver: (-70, 40)})(source)
        q[follower - 1] = at + slope * q[driver - 1] + source.uniform(-0.5, 0.5)
        return q
    return draw


# name: truth with its values, rival, how was measured, load. Geometry is known from a calibration before.
PAIRS = {
    "harmonic or gain, A3": (("joint_harmonic, joint: A3, order: 1", "cos_urad: 95, sin_urad: -300"),
                             ("encoder_gain, joint: A3", "gain_ppm: 0"), window({3: (30, 8)}), None),
    "gain or harmonic, A2": (("encoder_gain, joint: A2", "gain_ppm: 300"),
                             ("joint_harmonic, joint: A2, order: 1", "cos_urad: 0, sin_urad: 0"),
                             window({2: (-60, 10)}), None),
    "first or second harmonic, A4": (("joint_harmonic, joint: A4, order: 1", "cos_urad: 900, sin_urad: -900"),
                                     ("joint_harmonic, joint: A4, order: 2", "cos_urad: 0, sin_urad: 0"),
                                     window({4: (40, 10)}), None),
    "second or first harmonic, A5": (("joint_harmonic, joint: A5, order: 2", "cos_urad: 600, sin_urad: 600"),
                                     ("joint_harmonic, joint: A5, order: 1", "cos_urad: 0, sin_urad: 0"),
                                     window({5: (40, 10)}), None),
    "coupling or gain, A3": (("joint_coupling, joint: A3, driver: A2", "ratio_ppm: -120"),
                             ("encoder_gain, joint: A3", "gain_ppm: 0"), line(3, 2, -1.0, 18), None),
    "gain or coupling, A3": (("encoder_gain, joint: A3", "gain_ppm: 120"),
                             ("joint_coupling, joint: A3, driver: A2", "ratio_ppm: 0"), line(3, 2, -1.0, 18), None),
    "transverse, A2 or A3": (("transverse_compliance, joint: A2", "ku_urad_per_Nm: 0.04, kv_urad_per_Nm: 0.04"),
                             ("transverse_compliance, joint: A3", "ku_urad_per_Nm: 0, kv_urad_per_Nm: 0"),
                             window({3: (5, 3)}), "V250"),
    "foot or transverse, A1": (("base_compliance", "kx_urad_per_Nm: 0.006, ky_urad_per_Nm: 0.006"),
                               ("transverse_compliance, joint: A1", "ku_urad_per_Nm: 0, kv_urad_per_Nm: 0"),
                               window({1: (10, 3)}), "V250"),
    "transverse or foot, A1": (("transverse_compliance, joint: A1", "ku_urad_per_Nm: 0.006, kv_urad_per_Nm: 0.006"),
                               ("base_compliance", "kx_urad_per_Nm: 0, ky_urad_per_Nm: 0"),
                               window({1: (10, 3)}), "V250"),
    "hardening, A2 or A3": (("compliance_hardening, joint: A2", "k3_urad_per_kNm3: 0.35"),
                            ("compliance_hardening, joint: A3", "k3_urad_per_kNm3: 0"),
                            window({3: (3, 2), 4: (0, 5), 5: (3, 3)}), "V250"),
}


def entry(effect, values):
    return "effects: [{effect: %s, %s}]\n" % (effect, values)


def path_of(effect):
    """As results name it."""
    name, *pairs = effect.split(", ")
    cells = dict(pair.split(": ") for pair in pairs)
    target = cells.pop("joint", None) or cells.pop("load", None) or "base"
    settings = ",".join("%s=%s" % pair for pair in cells.items())
    return "%s%s/%s" % (name, "[%s]" % settings if settings else "", target)


def rows_of(poses, load):
    rows = []
    for name, q in poses.items():
        for marker in MARKERS:
            row = {"config": name, "marker": marker, "station": "S1", "load": load or "none"}
            row.update({"q%d_deg" % (i + 1): "%.6f" % value for i, value in enumerate(q)})
            rows.append(row)
    return rows


class Campaign:
    """Poses, what is measured there, and what two explanations make of it."""

    def __init__(self, folder, program, pair):
        import sagitta  # pylint: disable=import-outside-toplevel
        self.sagitta, self.folder, self.program = sagitta, folder, program
        self.truth, self.rival, self.draw, self.load = PAIRS[pair]
        loaded = COMPLIANCE if self.load else ""
        for name, text in (("truth", entry(*self.truth)), ("first", entry(self.truth[0], zero(self.truth[1]))),
                           ("second", entry(*self.rival)), ("robot", "")):
            (folder / (name + ".yaml")).write_text(rigid_robot() + loaded + text)

    def experiment(self, robot, rows, file, placed=True):
        write_table(self.folder / file, rows)
        scene = "" if not placed else (
            "stations: {S1: {xyz_mm: [-34.4, -31.9, -97.8], rotvec_mrad: [2.8, 2.2, -15.6]}}\nmarkers: "
            "{P1: {xyz_mm: [279.2, -16.4, -91.9]}, P2: {xyz_mm: [279.2, -25.2, 96.1]}, P3: {xyz_mm: [281.8, 130.5, 5.6]}}\n")
        loads = "loads: {V250: {mass_kg: 250}}\nload_point_mm: [280, 0, 0]\n" if self.load else ""
        path = self.folder / (robot + "_experiment.yaml")
        path.write_text("schema: sagitta/experiment/1\nrobot: %s.yaml\nmeasurements: [%s]\n%s%snoise: {sigma_mm: %g}\n"
                        "estimate: {geometry: none, compliance: none, effects: all}\nvalidation: none\n" % (
                            robot, file, scene, loads, SIGMA_MM))
        return path

    def measured(self, poses, seed):
        rows = rows_of(poses, self.load)
        asked = self.sagitta.read(str(self.experiment("truth", rows, "asked.csv")), points_required=False)
        read = self.sagitta.simulate(asked, sigma_mm=SIGMA_MM, seed=seed).to_dataframe()
        for row, x, y, z in zip(rows, read["x_mm"], read["y_mm"], read["z_mm"]):
            row.update({"x_mm": "%.6f" % x, "y_mm": "%.6f" % y, "z_mm": "%.6f" % z})
        return rows

    def weighed(self, rows):
        """Probability of the truth against its rival and the lead of the truth over neither: Schwarz' criterion."""
        merit = {}
        for robot in ("first", "second", "robot"):
            estimate = self.sagitta.calibrate(self.sagitta.read(str(self.experiment(robot, rows, robot + ".csv", False))))
            fit = estimate.to_dict()["fit"]
            free = sum(p["free"] and p["name"].startswith("effect/") for p in estimate.to_dict()["parameters"])
            merit[robot] = -0.5 * fit["chi2"] - 0.5 * free * math.log(3 * len(rows))
        lead = max(-500.0, min(500.0, merit["second"] - merit["first"]))
        return 1 / (1 + math.exp(lead)), merit["first"] - merit["robot"]

    def planned(self, rows):
        experiment = self.experiment("robot", rows, "robot.csv", False)
        plan, planned = self.program.plan(
            self.folder, experiment.name, "--augment", "--poses=%d" % MORE, "--pool=300",
            "--discriminate=%s,%s" % (path_of(self.truth[0]), path_of(self.rival[0])))
        poses = {"M%s" % row["config"]: [float(row["q%d_deg" % (i + 1)]) for i in range(6)] for row in planned}
        return poses, plan["separation"]["decides"]


def zero(values):
    return ", ".join(pair.split(": ")[0] + ": 0" for pair in values.split(", "))


def discriminate(folder, options):
    """Per pair: campaigns whose rows leave the truth a probability between 0.1 and 0.9; then six planned poses and, apart
    from them, six uniform in the joint limits, each with the campaign's rows."""
    program = Program(options.build)
    wanted = options.random or 5
    decided = {"planned": [], "random": []}
    for pair in PAIRS:
        campaign = Campaign(folder, program, pair)
        found = []
        for seed in range(8 * wanted):
            source = random.Random("%s:%d" % (pair, seed))
            own = {"c%d" % k: campaign.draw(source) for k in range(POSES)}
            rows = campaign.measured(own, 1000 + seed)
            before, lead = campaign.weighed(rows)
            if not TIED[0] <= before <= TIED[1] or lead < 10:
                continue
            poses, promised = campaign.planned(rows)
            anyhow = {"r%d" % k: [source.uniform(*limit) for limit in LIMITS] for k in range(MORE)}
            after = {name: campaign.weighed(rows + campaign.measured(more, 5000 + seed))[0]
                     for name, more in (("planned", poses), ("random", anyhow))}
            found.append((before, lead, promised, after))
            if len(found) == wanted:
                break
        for name in decided:
            decided[name] += [one[3][name] >= DECIDED for one in found]
        print("%-30s tied %d of %d campaigns, lead over neither %s; P(truth) before %s, planned %s, random %s; promised %s" % (
            pair, len(found), seed + 1, quantiles([one[1] for one in found], (0.5,)) if found else "-",
            *[quantiles(values, (0.0, 0.5)) if found else "-" for values in (
                [one[0] for one in found], [one[3]["planned"] for one in found], [one[3]["random"] for one in found],
                [one[2] for one in found])]), flush=True)
    for name, hits in decided.items():
        print("%s: P(truth) >= %g in %d of %d" % (name, DECIDED, sum(hits), len(hits)))
