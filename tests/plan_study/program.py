"""The program as figures run it, and tables of poses."""
import csv
import json
import subprocess

MARKERS = ("P1", "P2", "P3")


class Program:
    def __init__(self, build):
        self.path = str(build.resolve() / "bin/sagitta")

    def __call__(self, folder, *arguments):
        done = subprocess.run([self.path, *map(str, arguments)], cwd=folder, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True, check=False)
        if done.returncode != 0:
            raise SystemExit("sagitta %s: %s" % (" ".join(map(str, arguments)), done.stderr))
        return done.stdout

    def plan(self, folder, experiment, *arguments):
        """plan.json and the planned rows."""
        self(folder, "plan", experiment, "--out=planned", "--quiet", *arguments)
        return json.loads((folder / "planned/plan.json").read_text()), table(folder / "planned/plan.csv")

    def calibrate(self, folder, experiment):
        self(folder, "calibrate", experiment, "--out=calibrated", "--quiet", "--force")
        return json.loads((folder / "calibrated/estimate.json").read_text())


def table(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def write_table(path, rows, columns=None):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, columns or list(rows[0]), extrasaction="ignore")
        writer.writeheader()
        writer.writerows(rows)


def write_poses(path, poses, **cells):
    """poses: {config: (joint values in deg)}; station per pose where cells name a function of its number."""
    rows = []
    for number, (config, q) in enumerate(poses.items()):
        for marker in MARKERS:
            row = {"config": config, "marker": marker}
            row.update({"q%d_deg" % (i + 1): "%.9g" % value for i, value in enumerate(q)})
            row.update({name: value(number) if callable(value) else value for name, value in cells.items()})
            rows.append(row)
    write_table(path, rows)


def quantiles(values, shares=(0.0, 0.05, 0.5, 0.95, 1.0)):
    ordered = sorted(values)
    return ", ".join("%.4g" % ordered[min(len(ordered) - 1, int(share * len(ordered)))] for share in shares)


def better_than(value, values):
    return sum(value < other for other in values) / len(values)
