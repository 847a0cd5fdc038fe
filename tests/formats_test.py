#!/usr/bin/env python3
"""Holds docs/FORMATS.md to the contract ../shared/FORMATS.md, and the result files to docs/FORMATS.md.

Every name of the contract stands in docs/FORMATS.md. Names are what programs depend on: text between backticks, quoted
keys of JSON, keys of YAML examples and the first column of tables. docs/FORMATS.md may say more, and says it in its own
words. Skips, and says so, where ../shared is absent.

Every key that the program writes stands in docs/FORMATS.md between backticks, quoted or in an example: the literals of
the sources that write result files and, where PROGRAM is given, the keys and columns of files that it writes. Below a
key of MAPS they are names of the user's (joints, parameters, stations). Standard library only.

usage: formats_test.py [PROGRAM]
       formats_test.py --self-test
"""
import csv
import json
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
CONTRACT = ROOT.parent / 'shared' / 'FORMATS.md'
COPY = ROOT / 'docs' / 'FORMATS.md'

WRITERS = ('estimator/results/*.cc', 'estimator/changes/changes.cc', 'estimator/predict.cc',
           'estimator/predicted_rows.cc', 'tools/compare.cc', 'tools/coverage.cc',
           'tools/reproduce/main.cc', 'tools/reproduce/table.cc')
# {"key", value}; ["key"]; columns; lists of columns.
LITERAL = (re.compile(r'\{\s*"([A-Za-z_]\w*)",'), re.compile(r'\["([A-Za-z_]\w*)"\]'),
           re.compile(r'(?:Cell|Number|number)\("(\w+)"'), re.compile(r'"(p(?:sig|cov|axis|held|arm|noise)\w+)"'))
FREE = {  # literal: what it is, if no key of a result file
    'flags': 'of coverage.state.jsonl, which the program alone reads',
    'x_m': "of the rows that a program's points become",
    'aligning': 'a phase of the progress',
    'all': 'a word of the command line',
    'reproduce': 'a command',
    'measurement': 'a value of gravity.frame',
}
MAPS = {'direction', 'parameters', 'sigmas', 'units', 'stations', 'markers', 'loads', 'first_time_s', 'status',
        'repeatability_urad', 'repeatability_um', 'sigma_axis_mm', 'infeasible_because', 'compliance', 'settings'}

EXAMPLE = ROOT / 'problems' / 'published' / 'kr270'
EXPERIMENTS = {  # name: keys in addition to robot and rows; every one is calibrated
    'plain': ('robot.yaml', 'geometric.csv', 'noise: {sigma_mm: 0.1}'),
    'held_out': ('robot.yaml', 'geometric.csv', 'validation: {fraction: 0.3, seed: 1}\nloss: huber'),
    'components': ('robot.yaml', 'geometric.csv', 'noise: {from: variance-components}\nrepeatability_urad: estimate'),
    'residuals': ('robot.yaml', 'geometric.csv', 'noise: {from: residuals, group: station-axis}\ncovariance: sandwich'),
    'instrument': ('robot.yaml', 'geometric.csv',
                   'noise: {instrument: {range_um: 10, range_um_per_m: 0.5, angle_um: 15, angle_um_per_m: 6}}\n'
                   'priors: {base/S1/x: {value: 0, sigma: 1}}\nestimate: {geometry: all}'),
    'loaded': ('robot_loaded.yaml', 'loaded.csv', 'noise: {from: rows}\nload_point_mm: [280, 60, -150]\n'
               'loads: {V250: {mass_kg: 250}}\nestimate: {compliance: all}\n'
               'markers: {K1: {on: A2, spring: lever}, K2: {on: A1, spring: anchor}}\n'
               'covariance: bootstrap\nbootstrap: {kind: parametric, replicates: 99, seed: 1}'),
}
COMMANDS = (  # after these; ROOT and SELF stand for folders
    'inspect SELF/plain.yaml --out=SELF/inspect',
    'diagnose SELF/held_out.yaml --out=SELF/diagnose',
    'plan SELF/plain.yaml --poses=8 --pool=60 --nomove --out=SELF/plan',
    'coverage SELF/plain.yaml --trials=2 --out=SELF/coverage',
    'compare SELF/plain.yaml --methods=joint,two-step --out=SELF/compare',
    'validate SELF/plain/estimate.json EXAMPLE/geometric.csv --out=SELF/validate',
    'predict SELF/plain/estimate.json EXAMPLE/geometric.csv --out=SELF/predicted.csv',
    'changed SELF/plain/estimate.json SELF/instrument/estimate.json --out=SELF/changed',
    'compensate SELF/plain/estimate.json SELF/targets.txt --out=SELF/corrected.csv',
)
TARGETS = 'target,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\na,10,-60,40,20,50,10\nb,-30,-80,70,0,40,0\n'


def names_of(text):
    """The names a text defines, white space folded."""
    names = set()
    for block in re.findall(r'```yaml\n(.*?)```', text, re.DOTALL):
        code = re.sub(r'#.*', '', block)
        names.update(re.findall(r'(?:^|[\s{,])([A-Za-z_]\w*):(?=\s|$)', code, re.MULTILINE))
    text = re.sub(r'```yaml\n.*?```', ' ', text, flags=re.DOTALL)
    for block in re.findall(r'```json\n(.*?)```', text, re.DOTALL):
        names.update(re.findall(r'"(\w+)"\s*:', block))
    text = re.sub(r'```json\n.*?```', ' ', text, flags=re.DOTALL)
    for span in re.findall(r'`([^`]+)`', text):
        names.update(re.findall(r'"(\w+)"', span) if '"' in span else re.findall(r'[A-Za-z_][\w.]*', span))
    return names


def missing(contract, copy):
    return sorted(names_of(contract) - set(re.findall(r'[A-Za-z_][\w.]*', copy)))


def family(name):
    """The member of a family that stands for it: x of x, y, z, joint 1 of all joints."""
    name = re.sub(r'^(q|tau|approach)\d+', r'\g<1>1', name)
    name = re.sub(r'^([TR])[xyz](?=_|$)', r'\1x', name)
    name = re.sub(r'_(?:xz|yz)(?=_)', '_xy', name)
    name = re.sub(r'(^|_)([roabc]?)[xyz](?=_|$)', r'\1\2x', name)
    return re.sub(r'^paxis\d', 'paxis1', name)


def documented_in(text):
    """Every name that a page shows as code or quotes."""
    names = set(re.findall(r'"(\w+)"', text))
    for name in names_of(text):
        names.update(name.split('.'))
    for span in re.findall(r'`([^`]+)`', re.sub(r'```.*?```', ' ', text, flags=re.DOTALL)):
        names.update(re.findall(r'[A-Za-z_]\w*', span))
    for block in re.findall(r'```yaml\n(.*?)```', text, re.DOTALL):
        names.update(re.findall(r'([A-Za-z_]\w*):', block))  # in their remarks, too
    return {family(name) for name in names}


def literals_of(source):
    return {name for pattern in LITERAL for name in pattern.findall(source)} - set(FREE)


def keys_of(value, is_map=False):
    """All keys of what JSON holds, without names of the user's."""
    keys = set()
    if isinstance(value, dict):
        for key, item in value.items():
            if not is_map:
                keys.add(key)
            keys |= keys_of(item, not is_map and key in MAPS)
    elif isinstance(value, list):
        for item in value:
            keys |= keys_of(item)
    return keys


def columns_of(path):
    with path.open(encoding='utf-8') as lines:
        return set(next(csv.reader(line for line in lines if not line.startswith('#'))))


def undocumented(keys, documented):
    return sorted(key for key in keys if family(key) not in documented)


def written_by(program, folder):
    """Keys of each result file that PROGRAM writes, by the file's name."""
    for name, (robot, rows, more) in EXPERIMENTS.items():
        (folder / (name + '.yaml')).write_text('schema: sagitta/experiment/1\nrobot: %s\nmeasurements: [%s]\n%s\n' %
                                               (EXAMPLE / robot, EXAMPLE / rows, more), encoding='utf-8')
    (folder / 'targets.txt').write_text(TARGETS, encoding='utf-8')
    given = {column for path in EXAMPLE.glob('*.csv') for column in columns_of(path)}  # handed on
    commands = ['calibrate SELF/%s.yaml --out=SELF/%s' % (name, name) for name in EXPERIMENTS] + list(COMMANDS)
    for command in commands:
        words = [word.replace('SELF', str(folder)).replace('EXAMPLE', str(EXAMPLE)) for word in command.split()]
        run = subprocess.run([program] + words + ['--quiet'], capture_output=True, text=True, timeout=300, check=False)
        if run.returncode != 0:
            raise SystemExit('%s: exit status %d\n%s' % (command, run.returncode, run.stderr))
    for path in sorted(folder.rglob('*')):
        name = path.relative_to(folder).as_posix()
        if path.suffix == '.json':
            yield name, keys_of(json.loads(path.read_text(encoding='utf-8')))
        elif path.suffix == '.csv':
            yield name, columns_of(path) - given


def check_results(program):
    documented = documented_in(COPY.read_text(encoding='utf-8'))
    lacking = looked_at = 0
    for pattern in WRITERS:
        for path in sorted(ROOT.glob(pattern)):
            keys = literals_of(path.read_text(encoding='utf-8'))
            looked_at += len(keys)
            for key in undocumented(keys, documented):
                print("docs/FORMATS.md lacks '%s', which %s writes" % (key, path.relative_to(ROOT)))
                lacking += 1
    if looked_at < 300:
        print('only %d literals were found in the sources' % looked_at)
        lacking += 1
    if program is None:
        return lacking
    with tempfile.TemporaryDirectory() as folder:
        for name, keys in written_by(program, pathlib.Path(folder)):
            for key in undocumented(keys, documented):
                print("docs/FORMATS.md lacks '%s' of %s" % (key, name))
                lacking += 1
    return lacking


def self_test():
    contract = 'A `key_mm` and\n```json\n{"one": 1}\n```\n```yaml\ntwo: {three: 3}\n```\n'
    assert missing(contract, contract) == [], missing(contract, contract)
    for name in ('key_mm', 'one', 'two', 'three'):
        assert missing(contract, contract.replace(name, 'other')) == [name], name
    source = 'json["one"] = {{"two", 1}, {"key_mm", x}}; out.Cell("three", i);'
    assert literals_of(source) == {'one', 'two', 'key_mm', 'three'}, literals_of(source)
    assert undocumented(literals_of(source), documented_in(contract)) == []
    assert undocumented({'four', 'one'}, documented_in(contract + ' four in prose')) == ['four']
    assert keys_of({'loads': {'V250': {'mass_kg': 1}}, 'a': [{'b': 2}]}) == {'loads', 'mass_kg', 'a', 'b'}
    assert family('psig_z_mm') == 'psig_x_mm' and family('q6_cmd_deg') == 'q1_cmd_deg' and family('parm_yz_mm2') == 'parm_xy_mm2'


def main(arguments):
    self_test()
    if arguments == ['--self-test']:
        return 0
    lacking = check_results(arguments[0] if arguments else None)
    if not lacking:
        print('docs/FORMATS.md has every key of the result files')
    if not CONTRACT.exists():
        print('skipped: no ../shared/FORMATS.md here')
        return 1 if lacking else 0
    names = missing(CONTRACT.read_text(encoding='utf-8'), COPY.read_text(encoding='utf-8'))
    for name in names:
        print("docs/FORMATS.md lacks '%s' of the contract" % name)
    if not names:
        print('docs/FORMATS.md has every name of the contract')
    return 1 if lacking or names else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
