#!/usr/bin/env python3
"""What must not change an estimate or a diagnosis, and what must change it exactly so.

The same measurements are written another way (rows in another order, other names, another measurement frame, other
units, other standard deviations, two files, other markers first, another number of threads), and calibrate and diagnose
have to say the same. Simulated data, and real ones where ../shared holds them.

usage: metamorphic_test.py PROGRAM
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import yaml

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from support.written_case import ROOT, Case, kr270_with_ripple, mark_validation, read_rows  # noqa: E402

PROGRAM = None
SHARED = ROOT.parent / 'shared' / 'data'

# Of a standard deviation: the optimum is found to rounding.
SAME = 1e-9
# Relative, of standard deviations, chi-square and figures of a fit.
CLOSE = 1e-9
# Of probabilities: what is not listed (1e-4). The search leaves sets of little weight out, by sums that end where rounding
# ends them.
LISTED = 1e-4
RIGHT = math.pi / 2


def rotation(vector):
    """exp of a rotation vector, rad."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-15:
        return np.eye(3)
    x, y, z = np.asarray(vector) / angle
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * (k @ k)


def run(command, experiment, out, *flags):
    done = subprocess.run([PROGRAM, command, str(experiment), '--out=%s' % out, '--quiet', *flags], text=True,
                          capture_output=True)
    assert done.returncode == 0, done.stderr
    name = 'estimate.json' if command == 'calibrate' else 'diagnosis.json'
    return json.loads((out / name).read_text())


def simulated(folder):
    return kr270_with_ripple(PROGRAM, folder)


def practice(_folder):
    """Simulated by somebody else, with time, temperature and loads."""
    folder = SHARED / 'practice' / 'case007'
    experiment = yaml.safe_load((folder / 'experiment.yaml').read_text())
    rows = mark_validation(read_rows(folder / 'measurements.csv'))
    for key in ('schema', 'robot', 'measurements'):
        del experiment[key]
    return Case((folder / 'robot.yaml').read_text(), dict(experiment, validation={'column': 'set'}), rows)


def real_ur5(_folder):
    folder = SHARED / 'ur5_gts3800'
    rows = [{k: v for k, v in row.items() if k != 'group'} for row in read_rows(folder / 'measurements.csv')[::9]]
    return Case((folder / 'robot.yaml').read_text(), {'noise': {'sigma_mm': 0.05}, 'validation': {'column': 'set'}},
                mark_validation(rows))


CASES = {'simulated': simulated}
if (SHARED / 'practice').exists():
    CASES['practice'] = practice
if (SHARED / 'ur5_gts3800').exists():
    CASES['ur5'] = real_ur5


# Each change: what it does to a case, and how the results are read back: names, values, standard deviations.
class Change:
    names = staticmethod(lambda name: name)     # of a parameter of the original
    flags = ()
    sigmas = 1.0                                # factor on stated standard deviations
    moved = None                                # rotation, translation (m) of the measurement frame
    same_words = True
    deals = False                               # whether names decide which rows are set against which

    def apply(self, case):
        raise NotImplementedError


class Permuted(Change):
    def apply(self, case):
        order = np.random.default_rng(7).permutation(len(case.rows))
        case.rows = [case.rows[i] for i in order]


class PermutedInShots(Permuted):
    """Rows in another order; without time_s only those of one shot. The order of shots says there what was measured
    when, and what the arm remembers (hysteresis) depends on it: a diagnosis may change with it."""
    def apply(self, case):
        if 'time_s' in case.rows[0]:
            return super().apply(case)
        shots, random = {}, np.random.default_rng(7)
        for row in case.rows:
            shots.setdefault(tuple(row.get(name) for name in ('config', 'visit', 'station', 'load')), []).append(row)
        case.rows = [rows[i] for rows in shots.values() for i in random.permutation(len(rows))]


class Renamed(Change):
    """Markers and stations by other names in the same order."""
    same_words = False
    keys = ('marker',)

    @staticmethod
    def names(name):
        parts = name.split('/')
        if parts[0] in ('marker', 'base'):
            parts[1] = 'my_' + parts[1]
        return '/'.join(parts)

    def apply(self, case):
        for row in case.rows:
            for key in self.keys:
                row[key] = 'my_' + row[key]
            row['station'] = 'my_' + (row.get('station') or 'S1')
        for key in ('markers', 'stations'):
            if key in case.experiment:
                case.experiment[key] = {'my_' + k: v for k, v in case.experiment[key].items()}


class RenamedAll(Renamed):
    """Configurations as well: folds are dealt by their names, so what unseen points say of the model's error is other."""
    keys = ('marker', 'config')
    deals = True


class SwappedMarkers(Change):
    """The first and the last marker exchange their names."""
    same_words = False

    def __init__(self, case):
        known = list(dict.fromkeys(row['marker'] for row in case.rows))
        self.pair = {known[0]: known[-1], known[-1]: known[0]}

    def names(self, name):
        parts = name.split('/')
        if parts[0] == 'marker':
            parts[1] = self.pair.get(parts[1], parts[1])
        return '/'.join(parts)

    def apply(self, case):
        for row in case.rows:
            row['marker'] = self.pair.get(row['marker'], row['marker'])
        if 'markers' in case.experiment:
            case.experiment['markers'] = {self.pair.get(k, k): v for k, v in case.experiment['markers'].items()}


class Moved(Change):
    """Another measurement frame: turned about its upright axis, which gravity keeps, and moved. Where rows state other
    standard deviations for x and y: by a right angle."""

    def __init__(self, case, shift=(1.5, -2.0, 0.4), angle=0.8):
        self.is_right = angle == RIGHT or 'sigma_x_mm' in case.rows[0]
        self.moved = (np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]) if self.is_right else rotation((0, 0, angle)),
                      np.array(shift))

    def apply(self, case):
        turn, shift = self.moved
        for row in case.rows:
            point = turn @ [float(row[k]) * 1e-3 for k in ('x_mm', 'y_mm', 'z_mm')] + shift
            for key, value in zip(('x_mm', 'y_mm', 'z_mm'), point):
                row[key] = repr(1e3 * float(value))
            if self.is_right and 'sigma_x_mm' in row:
                row['sigma_x_mm'], row['sigma_y_mm'] = row['sigma_y_mm'], row['sigma_x_mm']
            if row.get('fx_N'):
                for keys in (('fx_N', 'fy_N', 'fz_N'), ('mx_Nm', 'my_Nm', 'mz_Nm')):
                    if keys[0] in row:
                        for key, value in zip(keys, turn @ [float(row[k]) for k in keys]):
                            row[key] = repr(float(value))


class Units(Change):
    """Metres and radians in place of millimetres and degrees."""
    same_words = False

    def apply(self, case):
        for key in list(case.rows[0]):
            if key in ('x_mm', 'y_mm', 'z_mm', 'sigma_x_mm', 'sigma_y_mm', 'sigma_z_mm'):
                case.column(key, key[:-3] + '_m', lambda v: repr(float(v) / 1e3) if v else v)
            elif key.startswith('q') and key.endswith('_deg'):
                case.column(key, key[:-4] + '_rad', lambda v: repr(math.radians(float(v))))


class Split(Change):
    same_words = False

    def apply(self, case):
        case.files = 2


class Threads(Change):
    flags = ('--threads=2',)

    def apply(self, case):
        pass


class Sigmas(Change):
    """Four times the stated standard deviations, and the weights stay what they are."""
    sigmas = 4.0
    same_words = False

    def apply(self, case):
        for key in ('sigma_x_mm', 'sigma_y_mm', 'sigma_z_mm'):
            if key in case.rows[0]:
                case.column(key, key, lambda v: repr(4 * float(v)) if v else v)
        if 'sigma_mm' in case.experiment.get('noise', {}):
            case.experiment['noise'] = {'sigma_mm': 4 * case.experiment['noise']['sigma_mm']}
        for key in ('repeatability_urad', 'repeatability_um'):
            if key in case.experiment:
                case.experiment[key] = 4 * case.experiment[key]


def spec_of(entry):
    return entry['effect'], entry['target'], json.dumps(entry['settings'], sort_keys=True)


class Metamorphic(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.temporary.name)
        self.addCleanup(self.temporary.cleanup)
        self.worst = {}

    def each(self, name, changes):
        case = CASES[name](self.folder)
        for change in changes(case):
            changed = case.copy()
            change.apply(changed)
            kind = type(change).__name__
            if not (self.folder / 'plain').exists():
                self.plain = case.write(self.folder / 'plain')
            yield kind, change, changed.write(self.folder / kind)

    def bound(self, kind, what, value, limit, where):
        self.worst[what] = max(self.worst.get(what, 0.0), value)
        self.assertLessEqual(value, limit, (kind, what, where))

    def relative(self, kind, what, a, b, where, limit=CLOSE):
        self.bound(kind, what, abs(a - b) / max(abs(a), abs(b), 1e-300) if a != b else 0.0, limit, where)

    # Pairs of parameters: (original, changed).
    def compare_parameters(self, kind, change, before, after, scaled):
        rows = {row['name']: row for row in after['parameters']}
        self.assertEqual({change.names(row['name']) for row in before['parameters']}, set(rows), kind)
        for row in before['parameters']:
            own = rows[change.names(row['name'])]
            self.assertEqual((row['free'], row['identifiable'], row['unit']),
                             (own['free'], own['identifiable'], own['unit']), (kind, row['name']))
            if not row['free'] or row['sigma'] is None:
                continue
            if change.moved and row['name'].startswith('base/'):
                continue  # compare_bases
            self.relative(kind, 'sigma', row['sigma_noise_only'] * scaled, own['sigma_noise_only'], row['name'])
            if change.sigmas == 1.0 and not change.deals:  # with the model's error
                self.relative(kind, 'sigma', row['sigma'], own['sigma'], row['name'])
            self.bound(kind, 'value', abs(row['value'] - own['value']) / row['sigma'], SAME, row['name'])

    def compare_bases(self, kind, change, before, after):
        turn, shift = change.moved if change.moved else (np.eye(3), np.zeros(3))
        for station, pose in before['stations'].items():
            own = after['stations'][change.names('base/' + station).split('/')[1]]
            expected = turn @ (np.array(pose['xyz_mm']) * 1e-3) + shift
            self.bound(kind, 'base, m', float(np.abs(expected - np.array(own['xyz_mm']) * 1e-3).max()), 1e-10, station)
            difference = turn @ rotation(np.array(pose['rotvec_mrad']) * 1e-3) - rotation(
                np.array(own['rotvec_mrad']) * 1e-3)
            self.bound(kind, 'base, rad', float(np.abs(difference).max()), 1e-10, station)

    def compare_estimates(self, kind, change, before, after):
        self.assertEqual(before['status'], after['status'], kind)
        stated_scale = change.sigmas
        if change.sigmas != 1.0:
            # Where residuals had said that the sigmas are too small, the interval went by the residuals.
            before_scale = before['sigma']['a_posteriori'] if before['sigma']['scaled'] else 1.0
            after_scale = after['sigma']['a_posteriori'] if after['sigma']['scaled'] else 1.0
            stated_scale = change.sigmas * after_scale / before_scale
        for key in ('chi2', 'reduced_chi2'):
            self.relative(kind, 'chi2', before['fit'][key], after['fit'][key] * change.sigmas ** 2, key)
        for part in ('fit', 'validation'):
            for key in ('rms_mm', 'distance_rms_mm', 'distance_max_mm'):
                self.relative(kind, 'rms', before[part][key], after[part][key], (part, key))
        if change.sigmas == 1.0 or not before['held']['names']:  # what is held does not get larger with the noise
            self.relative(kind, 'validation', before['validation']['predicted_rms_mm'] * stated_scale,
                          after['validation']['predicted_rms_mm'], 'predicted_rms_mm')
        self.assertEqual(before['fit']['dof'], after['fit']['dof'], kind)
        self.compare_parameters(kind, change, before, after, stated_scale)
        self.compare_bases(kind, change, before, after)

    def compare_diagnoses(self, kind, change, before, after):
        self.assertEqual(before['verdict'], after['verdict'], kind)
        self.assertEqual([spec_of(step) for step in before['steps']],
                         [spec_of(step)[:1] + (self.original_name(change, step['target']),) + spec_of(step)[2:]
                          for step in after['steps']], kind)
        for step, own in zip(before['steps'], after['steps']):
            self.bound(kind, 'probability', abs(step['probability'] - own['probability']), LISTED, step['effect'])
            for row, other in zip(step['parameters'], own['parameters']):
                self.bound(kind, 'step value', abs(row['value'] - other['value']) / row['sigma'], SAME, row['name'])
                self.relative(kind, 'step sigma', row['sigma'], other['sigma'], row['name'])
            self.assertEqual([(a['effect'], self.original_name(change, a['target'])) for a in own['alternatives']],
                             [(a['effect'], a['target']) for a in step['alternatives']], kind)
        for key in ('nothing', 'noise', 'unnamed'):
            self.bound(kind, 'posterior', abs(before['posterior'][key] - after['posterior'][key]), LISTED, key)
        for key in ('reduced_chi2', 'rms_mm', 'holdout_rms_mm', 'noise_floor_mm', 'gap_after_mm', 'gap_closed'):
            if isinstance(before['final'].get(key), float) and abs(before['final'][key]) > 1e-6:
                self.relative(kind, 'final', before['final'][key], after['final'][key], key)

    @staticmethod
    def original_name(change, target):
        for prefix in ('marker', 'base'):
            if target.startswith('my_') and change.names('%s/x' % prefix) == '%s/my_x' % prefix:
                return target[3:]
        pair = getattr(change, 'pair', {})
        return pair.get(target, target)

    def tell(self, name):
        print('%s: %s' % (name, ', '.join('%s %.1e' % item for item in sorted(self.worst.items()))))


def changes_of_estimates(case):
    yield from (Permuted(), Renamed(), RenamedAll(), Moved(case), Units(), Split(), Threads(), Sigmas())
    if len({row['marker'] for row in case.rows}) > 1:
        yield SwappedMarkers(case)


def changes_of_diagnoses(case):
    # Turned only: what drifts and what an instrument reads wrong counts about the origin of the measurement frame.
    yield from (PermutedInShots(), Renamed(), Moved(case, (0, 0, 0), RIGHT), Units(), Split(), Threads())
    if len({row['marker'] for row in case.rows}) > 1:
        yield SwappedMarkers(case)


class Names(unittest.TestCase):
    """Results are a function of inputs: the length of a folder's name does not change the last digit."""

    def test_other_folders_have_the_same_bytes(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            experiment = simulated(folder).write(folder / 'case')
            for command, kept in (('calibrate', ('residuals.csv',)), ('diagnose', ('residuals.csv',))):
                first = None
                for out in ('a', 'bb', 'c' * 23, 'd' * 64):
                    json_of_run = run(command, experiment, folder / out)
                    for key in ('command', 'run', 'seconds'):
                        json_of_run.pop(key, None)
                    told = [json.dumps(json_of_run)] + [(folder / out / file).read_text() for file in kept]
                    first = first or told
                    self.assertEqual(first, told, (command, out))


def test_calibrate(name):
    def test(self):
        before = None
        for kind, change, experiment in self.each(name, changes_of_estimates):
            before = before or run('calibrate', self.plain, self.folder / 'estimate')
            after = run('calibrate', experiment, self.folder / ('of_' + kind), *change.flags)
            self.compare_estimates(kind, change, before, after)
        self.tell('calibrate ' + name)
    return test


def test_diagnose(name):
    def test(self):
        before = None
        for kind, change, experiment in self.each(name, changes_of_diagnoses):
            before = before or run('diagnose', self.plain, self.folder / 'diagnosis')
            after = run('diagnose', experiment, self.folder / ('of_' + kind), *change.flags)
            self.compare_diagnoses(kind, change, before, after)
        if name == 'simulated':
            self.assertEqual([(s['effect'], s['target']) for s in before['steps']], [('joint_harmonic', 'A3')])
        self.tell('diagnose ' + name)
    return test


for case_name in CASES:
    setattr(Metamorphic, 'test_calibrate_' + case_name, test_calibrate(case_name))
    setattr(Metamorphic, 'test_diagnose_' + case_name, test_diagnose(case_name))


if __name__ == '__main__':
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    PROGRAM = sys.argv.pop(1)
    unittest.main(verbosity=1)
