#!/usr/bin/env python3
"""The study in small, with fixed seeds: generator and program agree where nothing is hidden, files carry no hint, and
strong effects are found by name.

usage: mini_test.py FOLDER_OF_THE_PROGRAMS
"""
import csv
import json
import os
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
from study import cases, figures, programs, real_rows, rivals, runner  # noqa: E402

PROGRAMS = None
SEED = 11
ROBOTS = ['kr270', 'kr270_compensator', 'ur10', 'seven', 'track']
# (kind, robot): NC about 400 each.
HIDDEN = [('joint_harmonic', 'kr270'), ('backlash', 'kr270'), ('joint_compliance', 'kr270'),
          ('thermal_growth', 'kr270'), ('station_drift', 'ur10'), ('marker_shift', 'track')]


def mini_suite():
    for i, (kind, robot) in enumerate(HIDDEN):
        yield cases.case('mini', SEED, i, [kind], [400.0], {'robot': robot, 'configurations': 40}, 'strong')
    yield cases.case('mini', SEED, len(HIDDEN), [], [], {'robot': 'kr270', 'configurations': 40}, 'nothing hidden',
                     'nothing')


class WithFolder(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.temporary.name)
        self.addCleanup(self.temporary.cleanup)


class Generator(WithFolder):
    def test_agrees_with_the_program_where_nothing_is_hidden(self):
        # Two derivations of the same mechanics: what is left is the ten decimals of the file, 1e-10 mm over
        # sigmas from 8 um. A wrong sign or lever leaves 1e3 and more.
        for robot in ROBOTS:
            for extra in ({}, {'stations': 2}, {'unloaded': None}):
                if robot == 'kr270_compensator' and 'unloaded' in extra:
                    continue  # a spring on rigid joints does nothing
                flags = dict({'robot': robot, 'study': SEED, 'repeatability_urad': 8}, **extra)
                PROGRAMS.generate(flags, self.folder / 'case', self.folder / 'answer')
                estimate = PROGRAMS.calibrated(self.folder / 'answer' / 'experiment.yaml', self.folder / 'estimate')
                self.assertIsNotNone(estimate, (robot, extra))
                self.assertEqual(estimate['status'], 'converged', (robot, extra))
                self.assertLess(estimate['fit']['chi2'], 1e-6, (robot, extra))

    def test_each_hidden_effect_disturbs_the_believed_model(self):
        listed = subprocess.run([str(PROGRAMS.generator), '--list'], capture_output=True, text=True, check=True).stdout
        kinds = [line.split()[0] for line in listed.splitlines()]
        self.assertEqual(sorted(kinds), sorted(cases.CATALOGUE + cases.OUTSIDE + cases.FOREIGN + cases.STRANGERS +
                                               cases.NEWCOMERS + cases.LATECOMERS))
        for kind in kinds:
            flags = {'kinds': kind, 'study': SEED, 'case': 2, 'stations': 2 if kind == 'station_scale' else 1}
            if kind == 'self_weight_sag':
                flags.update(unloaded=None, robot='ur10')
            PROGRAMS.generate(flags, self.folder / 'case', self.folder / 'answer')
            chi2 = PROGRAMS.chi_square(self.folder / 'answer' / 'experiment.yaml', self.folder / 'estimate')
            self.assertGreater(chi2, 1e-3, kind)

    def moved_by(self, kind, number):
        """(words of the sealed answer, rows with marker, seconds since the first, undisturbed point and displacement in
        mm, joint values in rad)"""
        rows = []
        for scale in (0, 1):
            answer = self.folder / ('answer%d' % scale)
            PROGRAMS.generate({'kinds': kind, 'scales': scale, 'study': SEED, 'case': number}, self.folder / 'case', answer)
            with open(answer / 'measurements.csv', newline='') as file:
                rows.append(list(csv.DictReader(file)))
        sealed = json.loads((answer / 'answer.json').read_text())['hidden'][0]
        self.assertFalse(sealed['in_catalogue'])
        start = float(rows[0][0]['time_s'])
        told = []
        for zero, true in zip(*rows):
            at = [float(zero[c]) for c in ('x_mm', 'y_mm', 'z_mm')]
            by = [float(true[c]) - p for c, p in zip(('x_mm', 'y_mm', 'z_mm'), at)]
            told.append({'config': true['config'], 'load': true['load'], 'marker': true['marker'],
                         's': float(true['time_s']) - start, 'mm': math.hypot(*by), 'at': at, 'by': by,
                         'air': float(true['temperature_degC']),
                         'q': {c[:-4]: math.radians(float(true[c])) for c in true if c.endswith('_deg')}})
        return sealed, told

    def test_foreign_causes_follow_the_laws_their_answers_say(self):
        none = 1e-9  # mm: the tenth decimal of the file
        sealed, rows = self.moved_by('seat_wear', 1)
        early = float(re.search(r'/ ([0-9.]+) s', sealed['words']).group(1))
        worn = [r for r in rows if r['marker'] == sealed['target'] and r['s'] > 0]
        rates = [r['mm'] / math.log1p(r['s'] / early) for r in worn]
        self.assertLess(max(rates) / min(rates) - 1.0, 1e-4)
        self.assertAlmostEqual(max(r['mm'] for r in worn), 0.06, places=6)
        self.assertLess(max(r['mm'] for r in rows if r['marker'] != sealed['target']), none)

        sealed, rows = self.moved_by('floor_settling', 1)
        at = float(re.search(r'at ([0-9.]+) s', sealed['words']).group(1))
        self.assertLess(max(r['mm'] for r in rows if r['s'] < at), none)
        self.assertGreater(min(r['mm'] for r in rows if r['s'] > at), 1e-3)

        self.assertLess(max(r['mm'] for r in self.moved_by('link_heating', 1)[1] if r['s'] == 0.0), none)

        drawn = [self.moved_by('loose_bolt', number) for number in range(6)]
        nests = [(sealed['target'], rows) for sealed, rows in drawn if sealed['target'] != 'flange']
        self.assertTrue(nests)
        for loose, rows in nests:
            moved = [r for r in rows if r['mm'] > none]
            self.assertTrue(0 < len(moved) < len(rows) / 3)
            self.assertTrue(all(r['marker'] == loose and abs(r['mm'] - 0.06) < none for r in moved))

    def test_strangers_follow_the_laws_their_answers_say(self):
        none = 1e-9  # mm: the tenth decimal of the file
        for number in range(3):
            sealed, rows = self.moved_by('weather_dropouts', number)
            lost = [tuple(map(float, pair)) for pair in re.findall(r'([0-9.]+) to ([0-9.]+)', sealed['words'])]
            for r in rows:
                self.assertEqual(r['mm'] > none, any(a < r['s'] < b for a, b in lost))
                self.assertLess(r['mm'], 16e-6 * 10e3)

            sealed, rows = self.moved_by('brake_drop', number)
            arrived = {}
            for r in rows:
                arrived.setdefault(r['config'], r['s'])
            self.assertLess(max(r['mm'] for r in rows if r['s'] == arrived[r['config']]), none)
            self.assertTrue(all(r['mm'] > none for r in rows if r['load'] == 'V250'))

            sealed, rows = self.moved_by('shifting_load', number)
            self.assertTrue(all((r['mm'] > none) == (r['load'] == sealed['target']) for r in rows))

            sealed, rows = self.moved_by('range_cycles', number)
            half_period = float(re.search(r'and ([0-9.]+) of it', sealed['words']).group(1))
            self.assertLess(max(r['mm'] for r in rows), 0.03 * (1.0 + half_period) + none)

            sealed, rows = self.moved_by('drive_heat', number)
            self.assertLess(max(r['mm'] for r in rows if r['config'] == rows[0]['config']), none)

            sealed, rows = self.moved_by('hunting_servo', number)
            share = float(re.search(r'in ([0-9.]+) of', sealed['words']).group(1))
            still = {r['config'] for r in rows} - {r['config'] for r in rows if r['mm'] > none}
            self.assertLess(abs(1.0 - len(still) / 60.0 - share), 0.2)

        drawn = [self.moved_by('soft_tool', number) for number in range(6)]
        bars = [(sealed['target'], rows) for sealed, rows in drawn if sealed['target'] != 'flange']
        self.assertTrue(bars)
        for soft, rows in bars:
            self.assertTrue(all(r['mm'] < (0.06 + none if r['marker'] == soft else none) for r in rows))

    def test_newcomers_follow_the_laws_their_answers_say(self):
        none = 1e-9  # mm: the tenth decimal of the file
        number = r'(-?[0-9.]+)'

        def read_as(at, further_left, further_up):
            """Where a point seems to lie, in mm from where it is, whose azimuth and elevation are read off by so much."""
            azimuth, elevation = math.atan2(at[1], at[0]) + further_left, math.asin(at[2] / math.hypot(*at)) + further_up
            unit = (math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth), math.sin(elevation))
            return [math.hypot(*at) * u - p for u, p in zip(unit, at)]

        def assert_near(row, expected):
            self.assertLess(math.dist(row['by'], expected), none + 1e-4 * row['mm'])

        for case in range(3):
            # The textbook's collimation c / cos E, transit axis i tan E and index e, by the face of the configuration.
            sealed, rows = self.moved_by('two_faces', case)
            c, i, e = (1e-6 * float(t) for t in re.findall(r'(?:collimation|axis|index) ' + number, sealed['words']))
            joint, far = re.search(r'when A(\d) turns by ' + number, sealed['words']).groups()
            face = 1
            for before, row in zip([rows[0]] + rows, rows):
                if abs(row['q']['q' + joint] - before['q']['q' + joint]) > float(far):
                    face = -face
                up = math.asin(row['at'][2] / math.hypot(*row['at']))
                assert_near(row, read_as(row['at'], face * (c / math.cos(up) + i * math.tan(up)), face * e))

            # A bend b u exp((1 - u^2) / 2) in the sheet is an angle at the instrument by the part of the way beyond.
            sealed, rows = self.moved_by('warm_sheet', case)
            at, width, away, bend = (float(t) for t in re.findall(r'(?:azimuth|as|,|by) ' + number, sealed['words']))
            for row in rows:
                level, far = math.hypot(*row['at'][:2]), math.hypot(*row['at'])
                u = math.remainder(math.atan2(row['at'][1], row['at'][0]) - at, 2 * math.pi) / width
                aside = 1e-6 * bend * u * math.exp((1 - u * u) / 2) * max(0.0, far - 1e3 * away)
                self.assertLess(math.dist(row['by'], read_as(row['at'], aside / level, 0.0)), 1e-5)

            sealed, rows = self.moved_by('swapped_balls', case)
            other = re.search(r'with (\w+) at', sealed['words']).group(1)
            times = [float(t) for t in re.findall(r'[0-9]+\.[0-9]+', sealed['words'])]
            for row in rows:
                swapped = row['marker'] in (sealed['target'], other) and sum(row['s'] > t for t in times) % 2 == 1
                self.assertLess(abs(row['mm'] - (0.06 if swapped else 0.0)), none)

            sealed, rows = self.moved_by('radiant_heat', case)
            self.assertLess(max(r['mm'] for r in rows if r['s'] == 0.0), none)
            self.assertGreater(max(r['mm'] for r in rows), 0.01)

    @staticmethod
    def turned_by(rows):
        """Of each weight (N) hung on: the turn that it adds to that without a load, rad, and the joints. The turn w that
        moves the points d and e, seen from a third, by w x d and w x e is (w x d) x (w x e) / ((w x d) e)."""
        def cross(a, b):
            return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        shots = {}
        for row in rows:
            shots.setdefault((row['config'], row['load']), []).append(row)
        for (config, load), seen in shots.items():
            if not load.startswith('V'):
                continue
            empty = shots[config, 'none']
            by = [[x - y for x, y in zip(r['by'], e['by'])] for r, e in zip(seen, empty)]
            moved = [[x - y for x, y in zip(by[i], by[0])] for i in (1, 2)]
            last = [x - y for x, y in zip(seen[2]['at'], seen[0]['at'])]
            volume = sum(x * y for x, y in zip(moved[0], last))
            yield [x / volume for x in cross(*moved)], seen[0]['q'], 9.80665 * float(load[1:])

    @staticmethod
    def wrist_of_kr270(q):
        """Axes of A5 and A6, and from where they meet to the load, m: all in the base frame."""
        def turned(axis, angle, v):
            i, j = (axis + 1) % 3, (axis + 2) % 3
            out, c, s = list(v), math.cos(angle), math.sin(angle)
            out[i], out[j] = c * v[i] - s * v[j], s * v[i] + c * v[j]
            return out

        def to_base(v, joints):
            for name, axis in reversed(joints):
                v = turned(axis, q[name], v)
            return v
        wrist = [('q1', 2), ('q2', 1), ('q3', 1), ('q4', 0), ('q5', 1), ('q6', 0)]
        return to_base([0, 1, 0], wrist[:4]), to_base([1, 0, 0], wrist[:5]), to_base([0.23 + 0.28, 0.06, -0.15], wrist)

    def test_latecomers_follow_the_laws_their_answers_say(self):
        none = 1e-9  # mm: the tenth decimal of the file

        def numbers(sealed):
            return [float(t) for t in re.findall(r'-?[0-9]+\.[0-9]+', sealed['words'])]

        def minus(a, b):
            return [x - y for x, y in zip(a, b)]

        def dot(a, b):
            return sum(x * y for x, y in zip(a, b))

        def pairs(rows):
            """Readings of two markers in one shot: between their points, and between their displacements."""
            for one, other in zip(rows, rows[1:]):
                if one['s'] == other['s']:
                    yield one, minus(other['at'], one['at']), minus(other['by'], one['by'])

        def is_upright(between):
            """Its height is at least the half. The station is off upright by 3 mrad (sigma) per axis, and what lies level
            adds to what stands by three of these: 0.02 of it."""
            return abs(between[2]) > 0.5 * math.hypot(*between)

        def assert_steady(ratios, tolerance):
            self.assertGreater(len(ratios), 1)
            self.assertLess(max(ratios) - min(ratios), tolerance * max(abs(r) for r in ratios))

        swung = {'V250': [], 'V120': []}
        for case in range(3):
            # At half the width from the middle there are exp(-1/16) of the play, at 1.7 of it less than 3e-4.
            sealed, rows = self.moved_by('worn_sector', case)
            middle, half_width = numbers(sealed)[:2]
            away = [abs(r['q']['q' + sealed['target'][1:]] - middle) / half_width for r in rows]
            least = min(r['mm'] for r, x in zip(rows, away) if x < 0.5)
            self.assertGreater(least, 1e-3)
            self.assertLess(max(r['mm'] for r, x in zip(rows, away) if x > 1.7), 3e-4 * 0.1 * 4.0)  # 100 urad at 4 m

            # The plate only lifts: what is higher above the ground goes over, two markers by their heights alone.
            sealed, rows = self.moved_by('rocking_foot', case)
            lifted = [r for r in rows if r['mm'] > none]
            self.assertTrue(0 < len(lifted) < len(rows) / 2)
            aside = [(r, between, by) for r, between, by in pairs(lifted) if is_upright(between)]
            self.assertTrue(aside)
            headings = [math.atan2(by[1] / between[2], by[0] / between[2]) for _, between, by in aside]
            spread = [math.remainder(h - headings[0], 2 * math.pi) for h in headings]
            self.assertLess(max(spread) - min(spread), 0.05)

            # dh/dt = (r - h) / tau in steps of a second.
            sealed, rows = self.moved_by('spindle_heat', case)
            tau, *switches = numbers(sealed)
            heat = [0.0]
            for second in range(int(rows[-1]['s']) + 2):
                runs = sum(t < second + 0.5 for t in switches) % 2
                heat.append(heat[-1] + (runs - heat[-1]) * (1.0 - math.exp(-1.0 / tau)))
            warm = [(r, heat[int(r['s'])] + (r['s'] % 1.0) * (heat[int(r['s']) + 1] - heat[int(r['s'])])) for r in rows]
            for marker in {r['marker'] for r in rows}:
                assert_steady([r['mm'] / h for r, h in warm if r['marker'] == marker and h > 0.1], 0.02)

            # A rigid body between two seats: each marker as far as before, and two of them as far apart.
            sealed, rows = self.moved_by('reseated_tool', case)
            times = numbers(sealed)
            epoch = [sum(r['s'] >= t for t in times) for r in rows]
            self.assertTrue(all(r['mm'] < none for r, e in zip(rows, epoch) if e == 0))
            for key in {(r['marker'], e) for r, e in zip(rows, epoch) if e > 0}:
                assert_steady([r['mm'] for r, e in zip(rows, epoch) if (r['marker'], e) == key], 1e-4)
            for _, between, by in pairs(rows):
                self.assertLess(abs(dot(between, by)), 1e-2 * math.hypot(*between) * (math.hypot(*by) + none))

            sealed, rows = self.moved_by('swinging_load', case)
            self.assertTrue(all((r['mm'] > none) == (r['load'] in ('V250', 'V120')) for r in rows))
            for load, squares in swung.items():
                squares += [r['mm'] ** 2 for r in rows if r['load'] == load]

            # The head's friction drags the stand along: by the part 1 - exp(-turn / width) of what is left.
            sealed, rows = self.moved_by('stand_twist', case)
            twist, width = numbers(sealed)
            state, before = 0.0, math.atan2(rows[0]['at'][1], rows[0]['at'][0])
            for row in rows:
                azimuth = math.atan2(row['at'][1], row['at'][0])
                turned, before = math.remainder(azimuth - before, 2 * math.pi), azimuth
                state += (math.copysign(1.0, turned) - state) * (1.0 - math.exp(-abs(turned) / width))
                expected = [1e-6 * twist * state * row['at'][1], -1e-6 * twist * state * row['at'][0], 0.0]
                # The arm's errors of 0.5 mrad and 0.3 mm per part, of its 4 m, turn the ray by 2 mrad.
                self.assertLess(math.dist(row['by'], expected), 1e-6 * twist * math.hypot(*row['at']) * 0.005 / width)

            sealed, rows = self.moved_by('thermal_scaling', case)
            ppm, *times = numbers(sealed)
            typed = {}
            for row in rows:
                temperature = typed.setdefault(sum(row['s'] >= t for t in times), row['air'])
                for by, at in zip(row['by'], row['at']):
                    self.assertLess(abs(by + 1e-6 * ppm * (temperature - 20.0) * at), 2e-9)

            # A saw in time: two markers go apart by how full the pallet is, times the heights between them.
            sealed, rows = self.moved_by('stacked_pallet', case)
            fills, phase = numbers(sealed)
            filled = [(between, by, (r['s'] / fills + phase) % 1.0) for r, between, by in pairs(rows)]
            slopes = [(by[0] / between[2] / f, by[1] / between[2] / f) for between, by, f in filled
                      if f > 0.2 and is_upright(between)]
            self.assertGreater(len(slopes), 10)
            for slope in slopes:
                self.assertLess(math.dist(slope, slopes[0]), 0.04 * math.hypot(*slopes[0]))
                self.assertAlmostEqual(1e6 * math.hypot(*slope), 22.0, delta=0.5)

            sealed, rows = self.moved_by('load_number', case)
            self.assertTrue(all((r['mm'] > none) == (r['s'] >= numbers(sealed)[0]) for r in rows))

            # A load of the moment m turns the flange by k (a (b m) + b (a m)) about two joints' axes a and b. Of that the
            # part upright is the same in base and station, but for the 3 mrad between their uprights.
            sealed, rows = self.moved_by('wrist_windup', case)
            k, = numbers(sealed)
            said, seen = [], []
            for turned, q, load in self.turned_by(rows):
                a, b, lever = self.wrist_of_kr270(q)
                moment = [lever[1] * -load, lever[0] * load, 0.0]
                said.append(1e-6 * k * (a[2] * dot(b, moment) + b[2] * dot(a, moment)))
                seen.append(turned[2])
            self.assertGreater(len(seen), 30)
            for expected, found in zip(said, seen):
                self.assertLess(abs(found - expected), 0.03 * max(map(abs, said)))

        # By their weights, 250 to 120, at random angles: the means of a hundred scatter by a seventh.
        root_mean = {load: math.sqrt(sum(squares) / len(squares)) for load, squares in swung.items()}
        self.assertAlmostEqual(root_mean['V250'] / root_mean['V120'], 250.0 / 120.0, delta=0.6)

    def test_the_value_that_is_hidden_is_the_value_that_is_estimated(self):
        # The generator makes these from their causes, so their second order remains: 20 urad squared over metres.
        cases_of = [('warm_up', {}), ('station_eccentricity', {'stations': 2}), ('station_range_offset', {'stations': 2}),
                    ('station_refraction', {}),
                    ('load_com', {}), ('hysteresis', {}), ('marker_acceptance', {}), ('backlash', {}),
                    ('joint_slip', {'stations': 2}), ('marker_shift', {'stations': 2})]
        for kind, extra in cases_of:
            for number in (3, 4):
                flags = dict({'kinds': kind, 'scales': 1, 'study': SEED, 'case': number}, **extra)
                answer, believed = self.folder / 'answer', self.folder / 'believed'
                PROGRAMS.generate(flags, self.folder / 'case', answer)
                sealed = json.loads((answer / 'answer.json').read_text())['hidden'][0]
                rivals.extend(answer, believed, [(kind, sealed['target'], sealed['settings'], {})])
                estimate = PROGRAMS.calibrated(believed / 'experiment.yaml', self.folder / 'estimate')
                self.assertIsNotNone(estimate, kind)
                self.assertLess(estimate['fit']['chi2'], 1e-3, (kind, sealed))
                rows = {r['name'].rsplit('/', 1)[1] + '_' + r['unit'].replace('/', '_per_'): r
                        for r in estimate['parameters'] if r['name'].startswith('effect/' + kind)}
                self.assertEqual(set(rows), set(sealed['parameters']), kind)
                for name, truth in sealed['parameters'].items():
                    self.assertLess(abs(rows[name]['value'] - truth), 1e-3 * abs(truth) + 1e-3, (kind, name, sealed))

    def test_files_carry_no_hint(self):
        words = cases.CATALOGUE + cases.OUTSIDE + ['harmonic', 'hidden', 'truth', 'answer', 'gain', 'drift', 'slip']
        for kind in ('joint_harmonic', 'encoder_gain', 'station_drift', 'joint_slip', 'bump'):
            PROGRAMS.generate({'kinds': kind, 'study': SEED, 'case': 4}, self.folder / 'case', self.folder / 'answer')
            files = sorted((self.folder / 'case').iterdir())
            self.assertEqual([f.name for f in files], ['experiment.yaml', 'measurements.csv', 'robot.yaml'])
            text = ''.join(f.read_text() for f in files).lower()
            for word in words:
                self.assertNotIn(word, text)

    def test_the_same_seed_gives_the_same_case_another_seed_another(self):
        def measured(study, number):
            PROGRAMS.generate({'kinds': 'bump', 'study': study, 'case': number}, self.folder / 'c', self.folder / 'a')
            return (self.folder / 'c' / 'measurements.csv').read_text()
        self.assertEqual(measured(1, 5), measured(1, 5))
        self.assertNotEqual(measured(1, 5), measured(1, 6))
        self.assertNotEqual(measured(1, 5), measured(2, 5))


class Study(WithFolder):
    def test_strong_effects_are_named_and_nothing_is_named_where_nothing_is_hidden(self):
        folders = runner.Folders(self.folder, 'mini', SEED)
        records = runner.run_suite(PROGRAMS, mini_suite(), folders, 1, True, quiet=True)
        told = '\n'.join(runner.line_of(r) for r in records)
        result = figures.all_figures(records)
        self.assertEqual(result['failed'], [], told)
        self.assertEqual(result['nothing_hidden']['not_consistent']['k'], 0, told)
        strong = result['naming']['by_nc']['NC >= 40']
        self.assertEqual(strong['named_first']['n'], len(HIDDEN), told)
        self.assertEqual(strong['named_first']['k'], len(HIDDEN), told)
        # The work folder is resumable: nothing is computed twice.
        again = runner.run_suite(PROGRAMS, mini_suite(), folders, 1, True, quiet=True)
        self.assertEqual(json.dumps(again), json.dumps(records))


class PapersOwnCases(WithFolder):
    """What paper 002 leaves out, at the size of the published machine."""

    def named(self, kind, number):
        PROGRAMS.generate({'kinds': kind, 'scales': 1, 'study': 6, 'case': number}, self.folder / 'case',
                          self.folder / 'answer')
        sealed = json.loads((self.folder / 'answer' / 'answer.json').read_text())['hidden'][0]
        diagnosis, message, _ = PROGRAMS.diagnose(self.folder / 'case' / 'experiment.yaml', self.folder / 'result')
        self.assertIsNotNone(diagnosis, message)
        self.assertEqual(diagnosis['verdict'], 'explained', diagnosis['words'])
        self.assertEqual(len(diagnosis['steps']), 1, diagnosis['words'])
        step = diagnosis['steps'][0]
        self.assertEqual((step['effect'], step['target']), (kind, sealed['target']), diagnosis['words'])
        for probability in step['halves']['probability']:
            self.assertGreater(probability, 0.5, step['halves'])
        self.assertTrue(step['physical']['plausible'])
        self.assertGreater(diagnosis['final']['gap_closed'], 0.95)
        self.assertEqual(diagnosis['noise']['outliers'], [])
        return {p['name']: p for p in step['parameters']}, sealed

    def test_compliance_of_joint_1(self):
        found, sealed = self.named('joint_compliance', 14)
        self.assertEqual(sealed['target'], 'A1')
        k = found['k_urad_per_Nm']
        self.assertLess(abs(k['value'] - sealed['parameters']['k_urad_per_Nm']), 4 * k['sigma'])

    def test_gravity_compensator_with_its_shape(self):
        found, sealed = self.named('gravity_compensator', 1)
        truth = sealed['parameters']
        # The gauge: lengths times c, the rate over c^2. The search assumes a lever of 200 mm.
        c = 200 / truth['L_mm']
        for name, factor in (('a_x_mm', c), ('a_y_mm', c), ('s0_mm', c), ('Kc_N_per_mm', 1 / c ** 2)):
            self.assertLess(abs(found[name]['value'] - factor * truth[name]), 4 * found[name]['sigma'], name)


class WhatWasOnceNamedWrong(WithFolder):
    """Each was called something else, or noise, by the search that went by penalties."""

    def diagnosed(self, flags):
        PROGRAMS.generate(dict({'study': SEED}, **flags), self.folder / 'case', self.folder / 'answer')
        sealed = json.loads((self.folder / 'answer' / 'answer.json').read_text())['hidden']
        diagnosis, message, _ = PROGRAMS.diagnose(self.folder / 'case' / 'experiment.yaml', self.folder / 'result')
        self.assertIsNotNone(diagnosis, message)
        return diagnosis, [(h['kind'], h['target']) for h in sealed]

    def assert_explained(self, flags):
        diagnosis, sealed = self.diagnosed(flags)
        self.assertEqual(diagnosis['verdict'], 'explained', diagnosis['words'])
        self.assertEqual([(s['effect'], s['target']) for s in diagnosis['steps']], sealed)
        self.assertGreater(diagnosis['final']['gap_closed'], 0.9)
        self.assertGreater(diagnosis['final']['lack_of_fit_p'], 0.01)

    def test_the_load_point_is_off_by_30_mm(self):
        for number in (1, 2):
            self.assert_explained({'kinds': 'load_com', 'scales': 1.5, 'case': number})

    def test_the_circles_of_the_tracker_are_eccentric(self):
        self.assert_explained({'kinds': 'station_eccentricity', 'scales': 1.5, 'case': 1})

    def test_a_joint_slips_and_a_marker_is_reseated_between_two_stations(self):
        for kind in ('joint_slip', 'marker_shift'):
            self.assert_explained({'kinds': kind, 'scales': 1, 'case': 1, 'stations': 2})

    def test_beside_what_has_no_name_an_effect_needs_untouched_rows(self):
        """Joints drop when brakes close: the fitted rows are sure of a soft base as well, resamples and rows that were
        not fitted are not."""
        diagnosis, _ = self.diagnosed({'study': 9901, 'case': 10, 'kinds': 'brake_drop', 'scales': 1.7347429390368514,
                                       'robot': 'kr270', 'configurations': 60, 'stations': 1})
        said = {(e['effect'], e['target']): e['probability'] for e in diagnosis['posterior']['explanations']}
        self.assertLess(said['base_compliance', 'base'], 0.5)
        self.assertGreater(diagnosis['posterior']['unnamed'], 0.9)
        self.assertIn(diagnosis['verdict'], ('unknown', 'partly'), diagnosis['words'])
        self.assertTrue(all(step['probability'] < said['unnamed'] for step in diagnosis['steps']), diagnosis['words'])
        cautions = ' '.join(diagnosis['cautions'])
        self.assertRegex(cautions, r'base_compliance, base\) with \d+ % is not named')
        self.assertIn('resamples', cautions)

    def test_the_prior_of_an_effect_counts_once(self):
        """The axis wobbles. With the prior of its values in the refit's chi-square as well, that set lost to many others
        that hold something more, each something else."""
        diagnosis, sealed = self.diagnosed({'study': 10107, 'case': 1000374, 'kinds': 'axis_wobble',
                                            'scales': 3.6045605678230666, 'robot': 'kr270', 'configurations': 60,
                                            'stations': 1, 'unloaded': None})
        self.assertEqual([(s['effect'], s['target']) for s in diagnosis['steps']], sealed)
        alone = [s['probability'] for s in diagnosis['sets']
                 if len(s['explanations']) == 1 and not s.get('unnamed') and s['explanations'][0]['effect'] == sealed[0][0]]
        self.assertGreater(sum(alone), 0.5)

    def test_weights_of_several_links_are_weighed_where_they_are(self):
        """The believed model absorbs so much of them that its compliances, and with these the columns of every
        weight, are up to 60 % off, and one is 0: weighed about it a rest was left, and effects had no name."""
        for kinds, scales, number in (('link_gravity,link_gravity,link_gravity', '1,0.6,0.8', 3),
                                      ('link_gravity,link_gravity,joint_harmonic', '1,1.4,1', 4)):
            diagnosis, sealed = self.diagnosed({'study': 7701, 'case': number, 'kinds': kinds, 'scales': scales})
            self.assertEqual(diagnosis['verdict'], 'explained', diagnosis['words'])
            self.assertEqual(sorted((s['effect'], s['target']) for s in diagnosis['steps']), sorted(sealed))
            self.assertGreater(diagnosis['final']['gap_closed'], 0.99)

    def test_joints_that_no_data_distinguish_share_the_probability(self):
        """Joint 4 turns about y between 3 and 5, all in one point: k (x x' + z z') is the same before and after it, so
        a tilt of joint 3 about x is one of joint 4 with other compliances of 3 and 5. Weighed with columns of several
        torques, with the weight and without, joint 4 had more than 99.9 %."""
        diagnosis, sealed = self.diagnosed({'study': 70, 'case': 3, 'kinds': 'link_gravity,transverse_compliance',
                                            'scales': '3,3', 'robot': 'seven', 'configurations': 90})
        self.assertIn(('transverse_compliance', 'J3'), sealed)
        share = {e['target']: e['probability'] for e in diagnosis['posterior']['explanations']
                 if e['effect'] == 'transverse_compliance'}
        self.assertGreater(min(share['J3'], share['J4']), 0.2, share)
        self.assertGreater(share['J3'] + share['J4'], 0.9, share)

    def test_play_by_the_sign_of_a_torque_that_a_missing_weight_turns(self):
        """The sign jumps in shots where the weight is not known well enough: the refit found no optimum, the right set
        counted as none, and a width ten times what the rows allow was named next to a rest."""
        flags = {'study': 71, 'case': 12, 'kinds': 'backlash,link_gravity', 'scales': '3,2', 'robot': 'seven',
                 'configurations': 90}
        diagnosis, sealed = self.diagnosed(flags)
        self.assertEqual(diagnosis['verdict'], 'explained', diagnosis['words'])
        self.assertEqual(sorted((s['effect'], s['target']) for s in diagnosis['steps']), sorted(sealed))
        play = next(s for s in diagnosis['steps'] if s['effect'] == 'backlash')['parameters'][0]
        self.assertLess(play['ci95'][0], 210.5, play)
        self.assertGreater(play['ci95'][1], 210.5, play)

    def test_one_heavy_link_leaves_no_rest(self):
        """Twice the usual weight: the rest that was called unnamed was what the first linearization had wrong."""
        for number in (2, 11):
            self.assert_explained({'study': 7900, 'case': number, 'kinds': 'link_gravity', 'scales': 2})

    def test_a_stated_spring_that_is_another(self):
        """The robot file states 11 N/mm of 15 and nothing makes it free: the weighed load was accused."""
        PROGRAMS.generate({'study': 7910, 'case': 1, 'kinds': 'none', 'robot': 'kr270_compensator'}, self.folder / 'case',
                          self.folder / 'answer')
        for file, old, new in (('robot.yaml', 'Kc_N_per_mm: 15,', 'Kc_N_per_mm: 11,'),
                               ('experiment.yaml', '  gravity_compensator: [Kc]\n', '')):
            text = (self.folder / 'case' / file).read_text()
            self.assertIn(old, text)
            (self.folder / 'case' / file).write_text(text.replace(old, new))
        diagnosis, message, _ = PROGRAMS.diagnose(self.folder / 'case' / 'experiment.yaml', self.folder / 'result')
        self.assertIsNotNone(diagnosis, message)
        self.assertEqual([(s['effect'], s['target']) for s in diagnosis['steps']], [('gravity_compensator', 'A2')])
        self.assertEqual(diagnosis['verdict'], 'explained', diagnosis['words'])
        self.assertIn('not as stated', diagnosis['words'])
        rate = [p for p in diagnosis['steps'][0]['parameters'] if p['name'] == 'Kc_N_per_mm']
        self.assertEqual(len(rate), 1, diagnosis['steps'][0]['parameters'])
        low, high = rate[0]['ci95']
        self.assertTrue(low < 15 < high, rate)

    def test_what_is_less_probable_than_no_name_explains_nothing(self):
        """A stand twists: no effect of the catalogue does that. What is named with even odds is not all of it."""
        diagnosis, _ = self.diagnosed({'study': 10201, 'case': 6, 'kinds': 'stand_twist', 'scales': 2.4096050283902546,
                                       'robot': 'kr270', 'configurations': 60, 'stations': 1, 'repeatability_urad': 8})
        said = diagnosis['posterior']
        self.assertLess(max(e['probability'] for e in said['explanations']), said['unnamed'])
        self.assertIn(diagnosis['verdict'], ('unknown', 'partly'), diagnosis['words'])
        self.assertTrue(all(step['probability'] < said['unnamed'] for step in diagnosis['steps']), diagnosis['words'])

    def test_a_slip_is_found_whichever_moment_explains_most_at_first(self):
        """Every second moment is weighed first: of these the nearest to the slip explained less than a later one."""
        diagnosis, sealed = self.diagnosed({'study': 22001, 'case': 9000014, 'kinds': 'joint_slip',
                                            'scales': 2.7944051719915537, 'robot': 'kr270',
                                            'configurations': 60, 'stations': 1, 'without': 'approach',
                                            'repeatability_urad': 8})
        self.assertEqual(sealed, [('joint_slip', 'A2')])
        self.assertEqual([(s['effect'], s['target']) for s in diagnosis['steps']], sealed)

    def test_wide_functions_on_half_of_a_real_arm(self):
        """Three smooth functions with a residual of 10^6, averaged over all their sizes, were once given a weight
        above all others by rounding: nothing was named."""
        folder, file = real_rows.DATA_SETS['ur10_b']
        folder = HERE.parents[2] / 'shared/data' / folder
        if not folder.exists():
            self.skipTest('no measured rows of the UR10')
        half = real_rows.RealData(folder, file).halves('5')[0]
        with open(self.folder / 'half.csv', 'w', newline='') as stream:
            writer = csv.DictWriter(stream, list(half[0]), lineterminator='\n')
            writer.writeheader()
            writer.writerows(half)
        diagnosis, message, _ = PROGRAMS.diagnose(folder / 'robot.yaml', self.folder / 'result',
                                                  [str(self.folder / 'half.csv'), '--validation=none'])
        self.assertIsNotNone(diagnosis, message)
        self.assertEqual(diagnosis['verdict'], 'partly')
        self.assertIn(('joint_harmonic', 'j3'), [(s['effect'], s['target']) for s in diagnosis['steps']])

    def test_poses_are_proposed_between_functions_without_a_name(self):
        """They are listed anew with few effects of the catalogue, those of the loads' points among them. What is read
        where nothing was written is no number then."""
        with unittest.mock.patch.dict(os.environ, MALLOC_PERTURB_='255'):
            diagnosis, _ = self.diagnosed({'study': 9801, 'case': 27, 'kinds': 'two_faces', 'scales': 0.411300015,
                                           'robot': 'kr270', 'configurations': 60, 'stations': 1, 'without': 'time'})
        self.assertGreater(diagnosis['posterior']['unnamed'], 0.05)
        self.assertGreater(diagnosis['next']['decides'], 0.5)


class AgainstASimulation(WithFolder):
    """--simulation=columns: the generator's own arm without the hidden effect is somebody else's simulation."""

    def setUp(self):
        super().setUp()
        flags = {'kinds': 'joint_harmonic', 'study': 6, 'case': 3}
        PROGRAMS.generate(dict(flags, scales=0), self.folder / 'simulated', self.folder / 'points')
        PROGRAMS.generate(dict(flags, scales=1), self.folder / 'case', self.folder / 'answer')
        self.sealed = json.loads((self.folder / 'answer' / 'answer.json').read_text())['hidden'][0]
        simulated = self.read('points')
        rows = [dict(row, **{'sim_%s_mm' % a: point['%s_mm' % a] for a in 'xyz'})
                for row, point in zip(self.read('case'), simulated)]
        with open(self.folder / 'case' / 'measurements.csv', 'w', newline='') as stream:
            writer = csv.DictWriter(stream, list(rows[0]), lineterminator='\n')
            writer.writeheader()
            writer.writerows(rows)

    def read(self, folder):
        with open(self.folder / folder / 'measurements.csv', newline='') as stream:
            return list(csv.DictReader(stream))

    def replace(self, file, old, new):
        path = self.folder / 'case' / file
        text = path.read_text()
        self.assertIn(old, text)
        path.write_text(text.replace(old, new))

    def diagnosed(self):
        diagnosis, message, _ = PROGRAMS.diagnose(self.folder / 'case' / 'experiment.yaml', self.folder / 'result',
                                                  ['--simulation=columns'])
        self.assertIsNotNone(diagnosis, message)
        return diagnosis

    def test_the_gap_to_it_is_explained(self):
        diagnosis = self.diagnosed()
        step = diagnosis['steps'][0]
        self.assertEqual((step['effect'], step['target']), ('joint_harmonic', self.sealed['target']))
        self.assertEqual(str(step['settings']['order']), self.sealed['settings']['order'])
        for parameter in step['parameters']:
            truth = self.sealed['parameters'][parameter['name']]
            self.assertLess(abs(parameter['value'] - truth), 4 * parameter['sigma'], parameter)
        self.assertTrue(any('base and markers stay free' in c for c in diagnosis['cautions']))

    def test_an_effect_of_the_robot_file_is_held_and_said_to_be(self):
        order = self.sealed['settings']['order']
        self.replace('robot.yaml', 'kinematics:', 'effects: [{effect: joint_harmonic, joint: %s, order: %s, cos_urad: 0, '
                     'sin_urad: 0}]\nkinematics:' % (self.sealed['target'], order))
        diagnosis = self.diagnosed()
        self.assertTrue(any(c.startswith('Held at the values of the robot file') for c in diagnosis['cautions']),
                        diagnosis['cautions'])
        self.assertGreater(diagnosis['baseline']['reduced_chi2'], 1.3)

    def test_nothing_is_held_out_where_the_experiment_says_so(self):
        self.replace('experiment.yaml', 'validation: {fraction: 0.3, seed: 1}', 'validation: none')
        diagnosis = self.diagnosed()
        self.assertEqual(diagnosis['verdict'], 'explained')
        for figures_of in (diagnosis['baseline'], diagnosis['final']):
            self.assertIsNone(figures_of['holdout_rms_mm'])
        self.assertNotIn('hold-out', diagnosis['steps'][0]['words'])
        self.assertIn('Nothing is held out', (self.folder / 'result' / 'report.html').read_text())


class Outliers(WithFolder):
    def test_rows_of_a_reseated_marker_are_none_once_it_is_named(self):
        PROGRAMS.generate({'kinds': 'marker_shift', 'scales': 1, 'study': 6, 'case': 1}, self.folder / 'case',
                          self.folder / 'answer')
        diagnosis, message, _ = PROGRAMS.diagnose(self.folder / 'case' / 'experiment.yaml', self.folder / 'result')
        self.assertIsNotNone(diagnosis, message)
        self.assertEqual([s['effect'] for s in diagnosis['steps']], ['marker_shift'])
        self.assertEqual(diagnosis['noise']['outliers'], [])


class Demo(WithFolder):
    def test_the_demo_names_what_was_sealed(self):
        root = HERE.parent.parent
        command = [str(root / 'tools/demo-hidden-effect'), '--build=%s' % PROGRAMS.sagitta.parent,
                   '--out=%s' % (self.folder / 'demo')]
        done = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        for part in ('Where the gap is', 'What it says', 'noise floor', 'The seal is opened', 'unchanged', 'named'):
            self.assertIn(part, done.stdout)


if __name__ == '__main__':
    PROGRAMS = programs.Programs(sys.argv.pop(1))
    unittest.main()
