#!/usr/bin/env python3
"""Every example of tools/examples runs as it is, in a folder of its own, and writes what its page says.

usage: examples_test.py FOLDER     where the package `sagitta` is
"""
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
WRITES = {"05_plots.py": ["residuals.png", "parameters.png"], "04_plan_and_compensate.py": ["plan.csv", "corrected.csv"],
          "01_calibrate.py": ["results/estimate.json", "results/residuals.csv", "results/robot.calibrated.yaml",
                              "results/report.html"],
          "07_inspect_and_compare.py": ["before/report.html"]}


def main(folder):
    examples = sorted((ROOT / "tools" / "examples").glob("*.py"))
    failures = []
    for path in examples:
        with tempfile.TemporaryDirectory() as work:
            environment = {**os.environ, "PYTHONPATH": folder, "MPLCONFIGDIR": work}
            done = subprocess.run([sys.executable, str(path), str(ROOT / "problems" / "published" / "kr270")], cwd=work,
                                  env=environment, capture_output=True, text=True, check=False)
            if done.returncode != 0:
                failures.append("%s ends with %d\n%s" % (path.name, done.returncode, done.stderr))
            for name in WRITES.get(path.name, []):
                written = pathlib.Path(work, name)
                if not written.exists() or written.stat().st_size < 100:
                    failures.append("%s does not write %s" % (path.name, name))
            if not done.stdout.strip():
                failures.append("%s says nothing" % path.name)
    failures += ["tools/examples has no %s" % name for name in WRITES if not (ROOT / "tools/examples" / name).exists()]
    print("\n".join(failures) if failures else "%d examples run" % len(examples))
    return 1 if failures or not examples else 0


if __name__ == "__main__":
    sys.exit(main(os.path.abspath(sys.argv[1])))
