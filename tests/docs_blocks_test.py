#!/usr/bin/env python3
"""Files that the pages show are files that the program accepts: every block ```yaml of README.md and docs/ is given to
it as printed, alone or, where it is a part of a file, in its place. So is the command of docs/COMPENSATION.md.

Blocks ```sh and ```text are those of docs_test.py, code that of docs_code_test.py and repository_test.py.

usage: docs_blocks_test.py PROGRAM
"""
import csv
import pathlib
import random
import re
import subprocess
import sys
import tempfile

import docs_pages

ROOT = docs_pages.ROOT
KR270 = ROOT / 'problems/published/kr270'
PROGRAM = str(pathlib.Path(sys.argv[1]).resolve())
LINK = '''  <joint name="{name}" type="revolute">
    <parent link="{parent}"/><child link="{child}"/><origin xyz="{xyz}" rpy="0 0 0"/><axis xyz="{axis}"/>
    <limit lower="-3.2" upper="3.2" effort="1" velocity="1"/>
  </joint>
'''


def run(folder, *words):
    done = subprocess.run([PROGRAM, *map(str, words)], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, ' '.join(map(str, words)) + '\n' + done.stderr
    return done.stdout


def without(text, key):
    """A YAML text without one of its keys."""
    kept = re.sub(r'(?m)^%s:.*\n(?:[ #].*\n)*' % key, '', text)
    assert kept != text, key
    return kept


def with_part(text, part):
    """A YAML text with one of its keys replaced by what `part` says of it."""
    key = part.split(':')[0]
    return (without(text, key) if re.search(r'(?m)^%s:' % key, text) else text) + part


# The arm of FORMATS as a URDF: what the page's last kinematics names.
def write_urdf(path):
    links = ''.join('  <link name="%s"/>\n' % name for name in ('base_link', 'carousel', 'arm', 'forearm', 'flange'))
    joints = ''.join(LINK.format(name=name, parent=parent, child=child, xyz=xyz, axis=axis) for name, parent, child, xyz, axis in
                     (('A1', 'base_link', 'carousel', '0 0 0.75', '0 0 1'), ('A2', 'carousel', 'arm', '0.35 0 0', '0 1 0'),
                      ('A3', 'arm', 'forearm', '1.25 0 0', '0 1 0')))
    path.write_text('<robot name="kr270">\n' + links + joints + '  <joint name="end" type="fixed"><parent link="forearm"/>'
                    '<child link="flange"/><origin xyz="1.1 0 0" rpy="0 0 0"/></joint>\n</robot>\n')


def write_poses(folder):
    """The measurement files that FORMATS' experiment names, without their points."""
    random.seed(3)
    for name, load in (('geometric', 'none'), ('loaded', 'V250')):
        with open(folder / (name + '.csv'), 'w', newline='', encoding='utf-8') as file:
            out = csv.writer(file)
            out.writerow(['config', 'marker', 'station', 'load', 'set', 'q1_deg', 'q2_deg', 'q3_deg'])
            for k in range(24):
                q = ['%.2f' % random.uniform(*ends) for ends in ((-150, 150), (-130, -10), (-60, 120))]
                for marker in ('M1', 'P1', 'B1'):
                    out.writerow(['C%d' % k, marker, 'S1', load, 'validation' if k % 4 == 0 else 'calibration', *q])
        random.seed(3)


def points_of(path, marker):
    with open(path, newline='', encoding='utf-8') as file:
        return [[float(row[axis + '_mm']) for axis in 'xyz'] for row in csv.DictReader(file) if row['marker'] == marker]


def formats_page(folder, blocks):
    """The robot with each of its three kinematics, and the experiment: simulated from what it states, and calibrated."""
    robot, experiment = blocks['robot'], blocks['experiment']
    write_urdf(folder / 'kr270.urdf')
    write_poses(folder)
    # The markers that the experiment leaves open have to be somewhere.
    truth = experiment
    for where in ('A2', 'base'):
        truth = truth.replace('{on: %s}' % where, '{xyz_mm: [300, 40, -50], on: %s}' % where)
    assert truth != experiment
    (folder / 'truth.yaml').write_text(truth)
    (folder / 'experiment.yaml').write_text(experiment)
    found = []
    for number, part in enumerate([None] + blocks['kinematics']):
        (folder / 'robot.yaml').write_text(robot if part is None else with_part(robot, part))
        run(folder, 'simulate', 'truth.yaml', '--truth=truth.yaml', '--sigma_mm=0', '--quiet', '--out=points%d.csv' % number)
        found.append(points_of(folder / ('points%d.csv' % number), 'M1'))  # on the flange, where all three agree
    assert len(found) == 3 and len(found[0]) == 48
    for other in found[1:]:
        most = max(abs(a - b) for p, q in zip(found[0], other) for a, b in zip(p, q))
        assert most < 1e-6, 'the arms of FORMATS are %g mm apart' % most
    (folder / 'robot.yaml').write_text(robot)
    rows = (folder / 'points0.csv').read_text().splitlines()
    for name, load in (('geometric', ',none,'), ('loaded', ',V250,')):
        (folder / (name + '.csv')).write_text('\n'.join([rows[0]] + [row for row in rows if load in row]) + '\n')
    run(folder, 'calibrate', 'experiment.yaml', '--quiet', '--out=out')


def compensation_page(folder, command):
    """The corrected program, of robtargets that the arm reaches."""
    run(folder, 'calibrate', KR270 / 'experiment.yaml', '--quiet', '--out=results')
    (folder / 'weld.mod').write_text('MODULE weld\n  CONST jointtarget start:=[[-20,-60,70,10,50,20],[9E9,9E9,9E9,9E9,9E9,9E9]];\n'
                                     '  PROC main()\n    MoveAbsJ start,v100,fine,tool0;\n  ENDPROC\nENDMODULE\n')
    (folder / 'corrected').mkdir()
    words = command.replace('\\\n', ' ').replace("'", '').split()
    assert words[0] == 'sagitta' and words[1] == 'compensate', words
    run(folder, *words[1:])
    changed = (folder / 'corrected/weld.mod').read_text()
    assert changed.startswith('MODULE weld') and changed != (folder / 'weld.mod').read_text()


def plan_page(folder, cell):
    run(folder, 'convert', KR270 / 'robot.yaml', 'robot.urdf')
    # The names that URDF gives base and flange here.
    links = re.findall(r'<link name="([^"]*)"', (folder / 'robot.urdf').read_text())
    named = cell.replace('base_link: base_link', 'base_link: ' + links[0]).replace('tip_link: tool0', 'tip_link: ' + links[-1])
    (folder / 'cell.yaml').write_text(named)
    run(folder, 'plan', KR270 / 'experiment.yaml', '--cell=cell.yaml', '--poses=8', '--pool=60', '--quiet', '--out=plan')


def guide_page(folder, markers):
    """Its markers are those of an experiment on the loaded arm."""
    loaded = (KR270 / 'all_stages.yaml').read_text()
    for name in ('robot_loaded.yaml', 'loaded.csv'):
        loaded = loaded.replace(name, str(KR270 / name), 1)
    text = re.sub(r',P(\d),', r',F\1,', (KR270 / 'loaded.csv').read_text())
    (folder / 'loaded.csv').write_text(re.sub(r',K(\d),', r',P\1,', text))
    loaded = loaded.replace(str(KR270 / 'loaded.csv'), 'loaded.csv')
    (folder / 'experiment.yaml').write_text(with_part(loaded, markers))
    run(folder, 'calibrate', 'experiment.yaml', '--quiet', '--out=out')


def main():
    pages = {}
    for path in [ROOT / 'README.md', *sorted((ROOT / 'docs').rglob('*.md'))]:
        for block in docs_pages.blocks_of(path.read_text(encoding='utf-8')):
            if block.language == 'yaml':
                pages.setdefault(path.relative_to(ROOT).as_posix(), []).append(block.text)
    command, = [block.text for block in docs_pages.blocks_of((ROOT / 'docs/COMPENSATION.md').read_text(encoding='utf-8'))
                if block.text.startswith('sagitta ')]
    formats = pages.pop('docs/FORMATS.md')
    runs = {'docs/FORMATS.md': (formats_page, {
        'robot': formats[0], 'experiment': formats[-1], 'kinematics': formats[1:-1]}),
            'docs/COMPENSATION.md': (compensation_page, command)}
    for page, run_page in (('docs/PLAN.md', plan_page), ('docs/GUIDE.md', guide_page)):
        text, = pages.pop(page)
        runs[page] = (run_page, text)
    pages.pop('README.md')                  # docs_test.py runs it with its table
    pages.pop('docs/ADDING_AN_EFFECT.md')   # of an effect that only its own program has: estimator/own_effect_test.cc
    assert not pages, 'nobody runs the yaml of %s' % ', '.join(pages)
    defects = 0
    for page, (run_page, what) in runs.items():
        with tempfile.TemporaryDirectory() as folder:
            try:
                run_page(pathlib.Path(folder), what)
            except AssertionError as error:
                print('%s: %s' % (page, error))
                defects += 1
    print('the files shown in %s are used' % ', '.join(runs) if not defects else '')
    return 1 if defects else 0


if __name__ == '__main__':
    sys.exit(main())
