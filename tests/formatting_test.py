#!/usr/bin/env python3
"""Every source file is as clang-format writes it (.clang-format at the root)."""
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
FOLDERS = ('models', 'problems', 'estimator', 'tools', 'python', 'tests')


def main():
    program = shutil.which('clang-format')
    if program is None:
        sys.exit('clang-format is missing: tools/install-dependencies --tests installs it')
    files = sorted(str(f) for folder in FOLDERS for ending in ('*.cc', '*.h') for f in (ROOT / folder).rglob(ending))
    done = subprocess.run([program, '--dry-run', '--Werror', '--style=file'] + files, capture_output=True, text=True)
    if done.returncode != 0:
        print(done.stderr[:4000])
        sys.exit('run clang-format -i on the files above')
    print('%d files' % len(files))


if __name__ == '__main__':
    main()
