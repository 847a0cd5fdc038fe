#!/usr/bin/env python3
"""Numbers that nobody measures, through the whole program: degenerate arms, markers and rows, sizes at the limits of the
readers and beyond them.

Whatever comes in: exit status 0, 2 or 3 and no signal; where there are results every number in them is finite and JSON
is strict; where there are none the words say why. A result that says it has converged is a stationary point: a second
run from it finds nothing more.

usage: hostile_numbers_test.py PROGRAM
"""
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import yaml

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from support.written_case import kr270_with_ripple  # noqa: E402

PROGRAM = None
POINT = ('x_mm', 'y_mm', 'z_mm')
NOT_A_NUMBER = re.compile(r'(?<![\w.])[-+]?(nan|inf|infinity)(?![\w])', re.IGNORECASE)


def every(column, value):
    def change(case):
        for row in case.rows:
            row[column] = value
    return change


def one(row_number, column, value):
    def change(case):
        case.rows[row_number][column] = value
    return change


def points(function):
    """function: of a row's number and point, mm."""
    def change(case):
        for k, row in enumerate(case.rows):
            for key, value in zip(POINT, function(k, [float(row[key]) for key in POINT])):
                row[key] = repr(float(value))
    return change


def experiment(**keys):
    def change(case):
        case.experiment.update(keys)
    return change


def robot(change_of_mapping):
    def change(case):
        mapping = yaml.safe_load(case.robot)
        change_of_mapping(mapping)
        case.robot = yaml.safe_dump(mapping, sort_keys=False)
    return change


def both(*changes):
    def change(case):
        for one_of_them in changes:
            one_of_them(case)
    return change


def only(condition):
    def change(case):
        case.rows = [row for row in case.rows if condition(row)]
    return change


def no_lengths(mapping):
    for transform in mapping['kinematics']['chain']:
        for key in list(transform):
            if key.endswith('_mm'):
                transform[key] = 0


def lengths(factor):
    def change(mapping):
        for transform in mapping['kinematics']['chain']:
            for key in list(transform):
                if key.endswith('_mm'):
                    transform[key] = transform[key] * factor
    return change


def copied_marker(case):
    """P3 is read where P2 is."""
    at = {(r['config'], r['station']): [r[k] for k in POINT] for r in case.rows if r['marker'] == 'P2'}
    for row in case.rows:
        if row['marker'] == 'P3':
            for key, value in zip(POINT, at[row['config'], row['station']]):
                row[key] = value


def collinear_markers(case):
    """P3 is read in the middle between P1 and P2."""
    at = {(r['config'], r['station'], r['marker']): [float(r[k]) for k in POINT] for r in case.rows}
    for row in case.rows:
        if row['marker'] == 'P3':
            a, b = (at[row['config'], row['station'], m] for m in ('P1', 'P2'))
            for key, x, y in zip(POINT, a, b):
                row[key] = repr((x + y) / 2)


def loads(force):
    def change(case):
        for k, row in enumerate(case.rows):
            is_loaded = hash_of(row['config']) % 2 == 0
            row['load'] = 'L' if is_loaded else 'none'
            row['fx_N'], row['fy_N'], row['fz_N'] = '0', '0', repr(-force) if is_loaded else '0'
        case.experiment.update(load_point_mm=[100, 0, 50], estimate={'compliance': 'all'})
    return change


def hash_of(text):
    return sum(ord(c) for c in text)


def identical_stations(case):
    """The second instrument reads what the first reads, digit by digit."""
    rows = []
    for row in case.rows:
        rows += [dict(row, station='S1'), dict(row, station='S2')]
    case.rows = rows


def compensator(**values):
    spring = dict(joint='A2', type='spring', L_mm=184.72, a_x_mm=685.93, a_y_mm=123.3, s0_mm=458, Kc_N_per_mm=15,
                  preload=True)
    spring.update(values)
    return robot(lambda mapping: mapping.update(gravity_compensator=spring, compliance={'A2': {'k_urad_per_Nm': 0.3}}))


TINY = 5e-324
CASES = {
    'lengths_of_zero': robot(no_lengths),
    'lengths_of_a_denormal': robot(lengths(TINY)),
    'lengths_of_1e6': robot(lengths(1e6)),
    'lengths_of_1e-9': robot(lengths(1e-9)),
    'equal_markers': copied_marker,
    'collinear_markers': collinear_markers,
    'one_marker': only(lambda row: row['marker'] == 'P1'),
    'one_row': lambda case: case.rows.__delitem__(slice(1, None)),
    'four_rows': lambda case: case.rows.__delitem__(slice(4, None)),
    'one_station_of_one_row': one(0, 'station', 'S9'),
    'a_marker_seen_once': one(0, 'marker', 'P9'),
    'an_axis_never_moved': every('q3_deg', '-20'),
    'two_axes_never_moved': both(every('q3_deg', '-20'), every('q5_deg', '0')),
    'no_axis_moved': both(*[every('q%d_deg' % j, '10') for j in range(1, 7)]),
    'joints_of_1e6_degrees': both(*[every('q%d_deg' % j, '1e6') for j in (1, 4)]),
    'joints_of_a_denormal': every('q4_deg', '5e-324'),
    'joints_of_1e300_degrees': every('q4_deg', '1e300'),
    'minus_zero': every('q5_deg', '-0.0'),
    'points_of_zero': points(lambda k, p: [0, 0, 0]),
    'points_all_equal': points(lambda k, p: [100, 200, 300]),
    'points_of_denormals': points(lambda k, p: [TINY, -TINY, TINY]),
    'points_of_1e12': points(lambda k, p: [1e12 * x for x in p]),
    'points_1e8_mm_away': points(lambda k, p: [x + 1e8 for x in p]),
    'points_times_1000': points(lambda k, p: [1e3 * x for x in p]),
    'points_over_1e6': points(lambda k, p: [1e-6 * x for x in p]),
    'points_on_a_plane': points(lambda k, p: [p[0], p[1], 0]),
    'points_mirrored': points(lambda k, p: [p[0], -p[1], p[2]]),
    'one_point_of_1e8': one(5, 'x_mm', '1e8'),
    'one_point_of_1e300': one(5, 'x_mm', '1e300'),
    'one_denormal': one(5, 'x_mm', '5e-324'),
    'sigma_1e-12': experiment(noise={'sigma_mm': 1e-12}),
    'sigma_of_a_nanometre': experiment(noise={'sigma_mm': 1e-6}),
    'sigma_of_ten_metres': experiment(noise={'sigma_mm': 1e4}),
    'sigma_1e9': experiment(noise={'sigma_mm': 1e9}),
    'sigma_nowhere': experiment(noise={}),
    'huber_and_one_point_of_1e8': both(experiment(loss='huber'), one(5, 'x_mm', '1e8')),
    'cauchy_and_one_point_of_1e8': both(experiment(loss='cauchy'), one(5, 'x_mm', '1e8')),
    'repeatability_at_its_limit': experiment(repeatability_urad=1e5),
    'repeatability_of_1e-9': experiment(repeatability_urad=1e-9),
    'repeatability_asked_for': experiment(repeatability_urad='estimate'),
    'loads_of_1_N': loads(1.0),
    'loads_of_1e6_N': loads(1e6),
    'loads_of_1e12_N': loads(1e12),
    'loads_of_1e-300_N': loads(1e-300),
    'identical_stations': identical_stations,
    'prior_of_1e6': experiment(priors={'geometry/p_x1': {'value': 0, 'sigma': 1e6}}),
    'prior_of_1e14': experiment(priors={'geometry/p_x1': {'value': 0, 'sigma': 1e14}}),
    'prior_of_1e-12': experiment(priors={'geometry/p_x1': {'value': 1, 'sigma': 1e-12}}),
    'prior_far_off': experiment(priors={'geometry/p_x1': {'value': 1e4, 'sigma': 1e-3}}),
    'spring_of_no_length': both(loads(1000.0), compensator(L_mm=0.0)),
    'spring_of_1e6': both(loads(1000.0), compensator(Kc_N_per_mm=1e6)),
    'spring_of_1e-300': both(loads(1000.0), compensator(Kc_N_per_mm=1e-300)),
    'spring_whose_ends_meet': both(loads(1000.0), compensator(a_x_mm=0.0, a_y_mm=-184.72)),
    'gravity_of_1e-2': both(loads(1000.0), experiment(gravity={'m_per_s2': 1e-2}, tool={'mass_kg': 100})),
    'tool_of_1e6_kg': both(loads(1000.0), experiment(tool={'mass_kg': 1e6})),
    'all_held_out_but_one': lambda case: [row.update(set='calibration' if k < 3 else 'validation')
                                          for k, row in enumerate(case.rows)],
    'sandwich': experiment(covariance='sandwich'),
    'equal_weights_of_unequal_sigmas': both(
        lambda case: [row.update({'sigma_%s_mm' % a: repr(1e-5 if k % 2 else 1e3) for a in 'xyz'})
                      for k, row in enumerate(case.rows)], experiment(noise={'from': 'rows'}, weights='equal')),
    'sigmas_over_eight_decades': lambda case: [row.update({'sigma_%s_mm' % a: repr(1e-5 if k % 2 else 1e3)
                                                           for a in 'xyz'}) for k, row in enumerate(case.rows)],
}


def numbers_in(value):
    if isinstance(value, dict):
        for item in value.values():
            yield from numbers_in(item)
    elif isinstance(value, list):
        for item in value:
            yield from numbers_in(item)
    elif isinstance(value, float):
        yield value


def refuse_constant(word):
    raise ValueError('%s is no JSON' % word)


class Hostile(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.base = kr270_with_ripple(PROGRAM, cls.folder / 'base')
        cls.outcomes = {}

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()
        for command, outcomes in cls.outcomes.items():
            counts = {status: outcomes.count(status) for status in sorted(set(outcomes))}
            print('%s: %s' % (command, ', '.join('exit %d: %d' % item for item in counts.items())))

    def run_program(self, command, *arguments):
        done = subprocess.run([PROGRAM, command, *map(str, arguments)], capture_output=True, text=True, timeout=300)
        self.outcomes.setdefault(command, []).append(done.returncode)
        told = '%s: exit %d\n%s%s' % (command, done.returncode, done.stdout[-2000:], done.stderr[-2000:])
        self.assertIn(done.returncode, (0, 2, 3), told)
        if done.returncode != 0:
            self.assertRegex(done.stderr, r'sagitta: (error|no estimate|nothing \w+|no \w+): \S', told)
            self.assertNotIn('report it', done.stderr, told)
        return done.returncode, told

    def check_outputs(self, out, told):
        files = sorted(path for path in out.rglob('*') if path.is_file())
        self.assertTrue(files, told)
        for path in files:
            text = path.read_text()
            if path.suffix == '.json':
                for number in numbers_in(json.loads(text, parse_constant=refuse_constant)):
                    self.assertTrue(math.isfinite(number), (path.name, told))
            elif path.suffix in ('.csv', '.yaml'):
                self.assertIsNone(NOT_A_NUMBER.search(text), (path.name, NOT_A_NUMBER.search(text), told))
            else:
                # Of a page only what is drawn: words may hold "inf".
                for place in re.findall(r'(?:points|d|x|y|cx|cy|x1|x2|y1|y2|width|height)="([^"]*)"', text):
                    self.assertIsNone(NOT_A_NUMBER.search(place), (path.name, place[:200], told))

    def check_stationary(self, case, out, folder, told):
        """A second run from the calibrated robot finds nothing that is worth a tenth of a standard deviation: 0.01 of
        chi-square. What is held rests anew about the first's values, with a prior of its physical range in units of the
        scatter: within that range each direction is worth chi-square over degrees of freedom at most."""
        first = json.loads((out / 'estimate.json').read_text())
        self.assertGreaterEqual(first['iterations'], 0, told)
        again = case.copy()
        again.robot = (out / 'robot.calibrated.yaml').read_text()
        status, told_again = self.run_program('calibrate', again.write(folder / 'again'), '--out=%s' % (folder / 'second'),
                                              '--quiet', '--force')
        if status != 0:
            return  # a robot calibrated to such data may be refused, in words
        second = json.loads((folder / 'second' / 'estimate.json').read_text())
        if second['fit']['dof'] != first['fit']['dof'] or 'priors' in case.experiment:
            return  # other directions are held, or priors count from another nominal
        gained = first['fit']['chi2'] - second['fit']['chi2']
        held = len([p for p in first['parameters'] if not p['identifiable']])
        rests = held * first['fit']['chi2'] / max(1, first['fit']['dof'])
        self.assertLess(gained, 1e-4 * first['fit']['chi2'] + rests + 1e-2, told + told_again)

    def check(self, name):
        case = self.base.copy()
        CASES[name](case)
        folder = self.folder / name
        path = case.write(folder / 'case')
        self.run_program('inspect', path)
        for command in ('calibrate', 'diagnose'):
            out = folder / command
            status, told = self.run_program(command, path, '--out=%s' % out, '--quiet', '--force')
            if status != 0:
                self.assertFalse(out.exists(), told)
                continue
            self.check_outputs(out, told)
        if (folder / 'calibrate').exists():
            told = (folder / 'calibrate' / 'estimate.json').read_text()[:1500]
            self.check_stationary(case, folder / 'calibrate', folder, told)
            rows = folder / 'predicted.csv'
            status, told = self.run_program('predict', folder / 'calibrate' / 'estimate.json',
                                            folder / 'case' / 'rows0.csv', '--out=%s' % rows)
            if status == 0:
                self.assertIsNone(NOT_A_NUMBER.search(rows.read_text()), told)


for case_name in CASES:
    setattr(Hostile, 'test_' + re.sub(r'\W', '_', case_name), lambda self, name=case_name: self.check(name))


if __name__ == '__main__':
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    PROGRAM = sys.argv.pop(1)
    unittest.main(verbosity=1)
