#!/usr/bin/env python3
"""The hand-written stubs are true: stubtest compares them with the module, mypy checks what users write against them.

usage: stubs_test.py FOLDER        where the package `sagitta` is
"""
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PLANTED = {  # what mypy must refuse
    "sagitta.calibrate('experiment.yaml')": "arg-type",
    "sagitta.read('e.yaml').fit": "attr-defined",
    "x: str = sagitta.calibrate(sagitta.read('e.yaml'))['base/S1/x'].value": "assignment",
}


def mypy(folder, cache, *arguments):
    environment = {**os.environ, "MYPYPATH": folder}
    return subprocess.run([sys.executable, "-m", "mypy", "--cache-dir", cache, "--strict", "--scripts-are-modules",
                           *map(str, arguments)], env=environment, capture_output=True, text=True, check=False)


def main(folder):
    failures = []
    # pandas of Debian 12 carries no types of its own.
    with tempfile.TemporaryDirectory() as work:
        settings = pathlib.Path(work, "mypy.ini")
        settings.write_text("[mypy]\n[mypy-pandas.*,matplotlib.*]\nignore_missing_imports = True\nfollow_imports = skip\n"
                            "[mypy-sagitta._core,sagitta._tables]\nignore_missing_imports = True\n")
        allowed = pathlib.Path(work, "allowed")
        allowed.write_text("sagitta\\._core.*\nsagitta\\._tables.*\n")
        environment = {**os.environ, "MYPYPATH": folder, "PYTHONPATH": folder}
        stubtest = subprocess.run([sys.executable, "-m", "mypy.stubtest", "sagitta", "--mypy-config-file", settings,
                                   "--allowlist", allowed, "--ignore-unused-allowlist"],
                                  env=environment, capture_output=True, text=True, check=False)
        if stubtest.returncode != 0:
            failures.append("stubtest:\n" + stubtest.stdout + stubtest.stderr)
        examples = sorted((ROOT / "tools" / "examples").glob("*.py"))
        cache = str(pathlib.Path(work, "cache"))
        done = mypy(folder, cache, "--config-file", settings, *examples)
        if done.returncode != 0:
            failures.append("mypy:\n" + done.stdout + done.stderr)
        planted = pathlib.Path(work, "planted.py")
        planted.write_text("import sagitta\n" + "\n".join(PLANTED) + "\n")
        refused = mypy(folder, cache, "--config-file", settings, planted).stdout
        for line, (text, expected) in enumerate(PLANTED.items(), 2):
            if not any("planted.py:%d: error" % line in said and expected in said for said in refused.splitlines()):
                failures.append("mypy does not refuse\n%s\n%s" % (text, refused))
    print("\n".join(failures) if failures else "%d examples, %d planted slips" % (len(examples), len(PLANTED)))
    return 1 if failures or not examples else 0


if __name__ == "__main__":
    sys.exit(main(os.path.abspath(sys.argv[1])))
