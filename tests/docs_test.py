#!/usr/bin/env python3
"""Runs README's two-file example as it is printed: the robot block, the measurement block, the command.

usage: docs_test.py PROGRAM
"""
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
BLOCK = re.compile(r'^```\w*\n(.*?)^```', re.MULTILINE | re.DOTALL)
SHOWN_PROGRAM = 'build/release/bin/sagitta'


def blocks_of(page):
    return BLOCK.findall((ROOT / page).read_text(encoding='utf-8'))


def only(blocks, start):
    found = [block for block in blocks if block.startswith(start)]
    if len(found) != 1:
        raise SystemExit('README.md: %d blocks begin with %r, one is expected' % (len(found), start))
    return found[0]


def main(program):
    blocks = blocks_of('README.md')
    robot = only(blocks, 'schema: sagitta/robot/1')
    rows = only(blocks, 'config,marker,')
    command = only(blocks, SHOWN_PROGRAM + ' calibrate ROBOT.yaml MEAS.csv')
    with tempfile.TemporaryDirectory() as folder:
        pathlib.Path(folder, 'ROBOT.yaml').write_text(robot)
        pathlib.Path(folder, 'MEAS.csv').write_text(rows)
        words = shlex.split(command)
        run = subprocess.run([program] + words[1:], cwd=folder, capture_output=True, text=True, check=False)
        written = sorted(path.name for path in pathlib.Path(folder, 'DIR').glob('*'))
    if run.returncode != 0:
        print('README.md: %s ends with %d\n%s' % (command.strip(), run.returncode, run.stderr))
        return 1
    expected = ['estimate.json', 'report.html', 'residuals.csv', 'robot.calibrated.yaml']
    if written != expected:
        print('README.md: the example writes %s, not %s' % (written, expected))
        return 1
    print("README's example runs as printed")
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1]))
