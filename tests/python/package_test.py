#!/usr/bin/env python3
"""cpack -G DEB makes packages that install into an empty root and run from there, with what they say they need.

usage: package_test.py BUILD_FOLDER
"""
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
NEEDS = {"sagitta": ["libyaml-cpp0.7", "libc6"], "python3-sagitta": ["libyaml-cpp0.7", "python3 (>= 3.", "python3-numpy"],
         "libsagitta-dev": ["libceres-dev"]}
CONTAINS = {"sagitta": ["usr/bin/sagitta", "usr/bin/sagitta-reproduce", "usr/share/man/man1/sagitta.1",
                        "usr/share/bash-completion/completions/sagitta", "usr/share/zsh/vendor-completions/_sagitta"],
            "python3-sagitta": ["usr/lib/python3/dist-packages/sagitta/__init__.pyi"],
            "libsagitta-dev": ["usr/include/sagitta/sagitta.h"]}


def run(*command, **options):
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False, **options)
    if done.returncode != 0:
        raise SystemExit("%s ends with %d\n%s%s" % (" ".join(map(str, command)), done.returncode, done.stdout, done.stderr))
    return done.stdout


def main(build):
    with tempfile.TemporaryDirectory() as work:
        run("cpack", "-G", "DEB", "--config", build / "CPackConfig.cmake", "-B", work, cwd=work)
        packages = {path.name.split("_")[0]: path for path in pathlib.Path(work).glob("*.deb")}
        if set(packages) != set(NEEDS):
            raise SystemExit("packages: %s" % sorted(packages))
        root = pathlib.Path(work, "root")
        for name, path in packages.items():
            depends = run("dpkg-deb", "--field", path, "Depends")
            lacking = [need for need in NEEDS[name] if need not in depends]
            if lacking:
                raise SystemExit("%s does not depend on %s: %s" % (name, lacking, depends))
            run("dpkg-deb", "-x", path, root)
            for file in CONTAINS[name]:
                if not (root / file).exists() and not (root / (file + ".gz")).exists():
                    raise SystemExit("%s does not hold %s" % (name, file))
        kr270 = ROOT / "problems" / "published" / "kr270" / "experiment.yaml"
        run(root / "usr/bin/sagitta", "calibrate", kr270, "--out=%s" % pathlib.Path(work, "results"), "--quiet")
        tables = run(root / "usr/bin/sagitta", "import", "--help")
        if "Examples" not in tables:
            raise SystemExit("import --help says: " + tables)
        code = ("import sagitta; assert sagitta.__file__.startswith(%r), sagitta.__file__; "
                "print(sagitta.calibrate(sagitta.read(%r)).status)" % (str(root), str(kr270)))
        said = run(sys.executable, "-c", code,
                   env={**os.environ, "PYTHONPATH": str(root / "usr/lib/python3/dist-packages")}, cwd=work)
        if "converged" not in said:
            raise SystemExit("the installed module says: " + said)
    print("%d packages run from an empty root" % len(packages))


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]).resolve())
