#!/usr/bin/env python3
"""Units in what the program writes: each header, column and key says the one unit of its quantity; no drawn number is
beyond what arms do; rows that were held out keep their colour however many there are.

usage: report_units_test.py PROGRAM
"""
import csv
import html.parser
import json
import math
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
PUBLISHED = ROOT / 'problems/published/kr270'
PROGRAM = ''
POSES = 500  # more than 400

# One unit per quantity: what may be said of a length, an angle of the robot, a turn of a base pose, an effect.
UNITS = ('mm', 'um', 'deg', 'mrad', 'urad', '%', 's', 'N', 'Nm', 'Nmm', 'kg', 'K', 'urad/Nm', 'um/N', 'mm/K', 'times',
         'degC', 'N/mm', 'standard deviations')
# Names, counts, shares, probabilities: no unit.
BARE = {'', 'name', 'joint', 'joints', 'config', 'configuration', 'count', 'points', 'rows', 'parameter', 'parameters',
        'factor', 'unit', 'pose', 'poses', 'by', 'after', 'axis', 'over', 'with', 'correlation', 'effect', 'step',
        'named', 'probability', 'a machine shows that', 'parts compared', 'differences', 'inflation', 'reading',
        'the most correlated', 'the largest', 'rank', 'mean leverage', 'leverage', 'times better known', 'marker',
        'station', 'shots', 'mean', 'over, and its unit', 'chi-square explained', 'p, corrected', 'log evidence', 'of the limits', 'state',
        'visit', 'load', 'what', 'answer', 'explanation', 'probability', 'verdict', 'largest'}
# Dimensionless or textual columns of CSV files.
BARE_COLUMNS = {'config', 'marker', 'station', 'load', 'visit', 'repeat', 'group', 'file', 'line', 'set', 'target',
                'outcome', 'status', 'method', 'order', 'iterations', 'message', 'kind', 'reachable', 'solution',
                'row', 'of', 'smallest_singular_value', 'leverage', 'state', 'weight', 'whitened', 'outlier', 'validation', 'cluster', 'branch', 'shot', 'reason'}


def unit_of(name):
    """What results say of a parameter."""
    family, last = name.split('/')[0], name.split('/')[-1]
    if family == 'base':
        return 'mrad' if last in ('rx', 'ry', 'rz') else 'mm'
    if family == 'marker':
        return 'mrad' if last in ('rx', 'ry', 'rz') else 'mm'
    if family == 'geometry':
        return 'mm' if re.search(r'/p_|\.(a|d|x|y|z)$', name) else 'deg'
    if family == 'compliance':
        return 'urad/Nm'
    return None


class Page(html.parser.HTMLParser):
    """Header and rows of each table; what each picture is drawn from."""

    def __init__(self, text):
        super().__init__()
        self.tables, self.pictures, self.cell, self.in_script = [], [], None, False
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        if tag == 'table':
            self.tables.append(([], []))
        elif tag == 'tr':
            self.tables[-1][1].append([])
        elif tag in ('td', 'th'):
            self.cell = ''
        elif tag == 'script':
            self.in_script = dict(attrs).get('type') == 'application/json'

    def handle_data(self, data):
        if self.cell is not None:
            self.cell += data
        if self.in_script:
            drawn = json.loads(data)
            if 'data' in drawn:
                self.pictures.append(drawn)
            self.in_script = False

    def handle_endtag(self, tag):
        if tag in ('td', 'th') and self.cell is not None:
            (self.tables[-1][0] if tag == 'th' else self.tables[-1][1][-1]).append(self.cell)
            self.cell = None


def says_unit(words):
    return any(re.search(r'(^|[\s,(\[])%s($|[\s,;)\].])' % re.escape(unit), words) for unit in UNITS)


def unsaid(header):
    """Columns of a table that name neither a unit nor a quantity without one."""
    if 'unit' in header or header and (header[0] in UNITS or 'unit' in header[0] or header[1:] == ['mm']):
        return []  # a column of its own, or one cell says it of all
    missing, said = [], False
    for cell in header:
        plain = cell.split(':')[-1].strip()
        said = said or says_unit(cell)
        if plain in BARE or says_unit(cell) or plain in ('to', 'largest') and said:
            continue
        missing.append(cell)
    return missing


def numbers_in(value):
    if isinstance(value, dict):
        for each in value.values():
            yield from numbers_in(each)
    elif isinstance(value, list):
        for each in value:
            yield from numbers_in(each)
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        yield float(value)


# Of files: counts, shares, probabilities, ratios.
BARE_KEYS = {'condition', 'prediction_p_value', 'p_value', 'a_posteriori', 'seconds', 'scale', 'instrument_factor', 'factor',
             'excess', 'm_per_s2', 'level', 'reduced_chi2', 'chi2', 'cost', 'share', 'inflation', 'sandwich_over_model',
             'share_sandwich', 'share_model', 'share_of_excess', 'significance', 'probability', 'unnamed', 'nothing',
             'noise_wrong', 'further', 'catalogue', 'model_error', 'noise', 'travel_share', 'rate_predicted',
             'rate_measured', 'max_deviation_sigma', 'leverage', 'largest', 'lack_of_fit_p', 'gap_closed',
             'gap_closed_ci95', 'efficiency', 'bound', 'score', 'log_evidence', 'O1', 'O2', 'O3', 'O4', 'O5',
             'share_of_gap', 'between_parts', 'overlap', 'compatible_p', 'chi2_reduction', 'reduced_chi2_after',
             'slopes', 'sigma_over_limit', 'criterion', 'cost_per_pose'}
# The 95 % interval of the factor next to it; eigenvalues of mean outer products of unit vectors.
BARE_PATHS = {('noise', 'ci95'), ('orientation', 'most'), ('orientation', 'least')}


def keys_without_unit(value, path=(), has_unit=False):
    """Paths of numbers with a fraction whose name ends with no unit, without a key 'unit' or 'units' next to them."""
    if isinstance(value, dict):
        has_unit = has_unit or 'unit' in value or 'units' in value
        for key, each in value.items():
            yield from keys_without_unit(each, (*path, key), has_unit)
    elif isinstance(value, list):
        for each in value:
            yield from keys_without_unit(each, path, has_unit)
    elif isinstance(value, float) and not has_unit:
        named = any(re.search(r'_(mm2?|um|deg|mrad|urad|s|Nm|N|kg|degC|K|m_per_s2|percent)$', key) for key in path)
        if not named and path[-1] not in BARE_KEYS and path[-2:] not in BARE_PATHS and 'correlation' not in path and 'direction' not in path:
            yield '.'.join(path)


def run(*words):
    return subprocess.run([PROGRAM, *map(str, words)], check=True, capture_output=True, text=True).stdout


def is_number(text):
    try:
        float(text)
        return True
    except ValueError:
        return False


class Units(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        home = cls.home = pathlib.Path(cls.folder.name)
        experiment = PUBLISHED / 'experiment.yaml'
        cls.said = {
            'calibrate': run('calibrate', experiment, '--holdout=0.3', '--out=%s' % (home / 'calibrate'), '--quiet'),
            'diagnose': run('diagnose', experiment, '--holdout=0.3', '--out=%s' % (home / 'diagnose'), '--quiet'),
            'plan': run('plan', experiment, '--poses=6', '--pool=60', '--out=%s' % (home / 'plan'), '--quiet'),
            'inspect': run('inspect', experiment, '--out=%s' % (home / 'inspect'), '--quiet'),
        }
        random.seed(5)
        ranges = [(-150, 150), (-140, -10), (-100, 140), (-170, 170), (-110, 110), (-170, 170)]
        lines = ['config,marker,station,' + ','.join('q%d_deg' % (j + 1) for j in range(6))]
        lines += ['C%d,P1,S1,%s' % (pose, ','.join('%.3f' % random.uniform(*ends) for ends in ranges))
                  for pose in range(POSES)]
        (home / 'poses.csv').write_text('\n'.join(lines) + '\n')
        robot = PUBLISHED / 'robot.yaml'
        run('simulate', robot, home / 'poses.csv', '--truth=%s' % (home / 'calibrate/estimate.json'), '--sigma_mm=0.05',
            '--out=%s' % (home / 'rows.csv'), '--quiet')
        cls.said['many'] = run('calibrate', robot, home / 'rows.csv', '--sigma_mm=0.05', '--holdout=0.3',
                               '--out=%s' % (home / 'many'), '--quiet')
        run('predict', home / 'many/estimate.json', home / 'poses.csv', '--out=%s' % (home / 'predicted.csv'), '--quiet')
        (home / 'targets.csv').write_text('\n'.join(
            ['target,' + ','.join('q%d_deg' % (j + 1) for j in range(6))] +
            ['T%d,%s' % (k, line.split(',', 3)[3]) for k, line in enumerate(lines[1:21])]) + '\n')
        run('compensate', home / 'many/estimate.json', home / 'targets.csv', '--out=%s' % (home / 'corrected.csv'),
            '--quiet')
        run('compare', robot, home / 'rows.csv', '--sigma_mm=0.05', '--methods=joint,two-step',
            '--out=%s' % (home / 'compare'), '--quiet')
        run('coverage', experiment, '--trials=20', '--out=%s' % (home / 'coverage'), '--quiet')
        run('validate', home / 'many/estimate.json', home / 'rows.csv', '--out=%s' % (home / 'validate'), '--quiet')
        run('changed', home / 'many/estimate.json', home / 'calibrate/estimate.json', '--out=%s' % (home / 'changed'),
            '--quiet')
        cls.pages = {name: Page((home / name / 'report.html').read_text()) for name in cls.said}

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_the_test_sees_a_missing_and_a_wrong_unit(self):
        self.assertEqual(unsaid(['joint', 'sag', 'sag, mm']), ['sag'])
        self.assertEqual(unsaid(['name', 'value', 'unit']), [])
        self.assertEqual(unit_of('base/S1/rx'), 'mrad')

    def test_every_table_of_every_page_says_its_units(self):
        for name, page in self.pages.items():
            self.assertTrue(page.tables, name)
            for header, _ in page.tables:
                with self.subTest(page=name, header=header):
                    self.assertEqual(unsaid(header), [])

    def test_every_table_on_the_terminal_says_its_units(self):
        for name, text in self.said.items():
            lines = text.splitlines()
            for above, line in zip(lines, lines[1:]):
                # A header: words in columns two blanks apart over a row that has numbers in the same.
                cells = re.split(r' {2,}', above.strip())
                values = re.split(r' {2,}', line.strip())
                if len(cells) < 3 or not above.startswith('  ') or any(is_number(cell) for cell in cells):
                    continue
                if sum(is_number(value) for value in values) >= 2:
                    with self.subTest(said=name, header=above):
                        self.assertEqual(unsaid(cells), [])

    def test_parameters_have_the_one_unit_of_their_quantity(self):
        for folder in ('calibrate', 'many', 'diagnose'):
            estimate = json.loads((self.home / folder / 'estimate.json').read_text())
            for row in estimate['parameters']:
                wanted = unit_of(row['name'])
                if wanted:
                    self.assertEqual(row['unit'], wanted, row['name'])
        for name, page in self.pages.items():
            for header, rows in page.tables:
                if 'unit' not in header:
                    continue
                at = header.index('unit')
                for row in rows:
                    wanted = unit_of(row[0]) if row and '/' in row[0] else None
                    if wanted and at < len(row):
                        self.assertEqual(row[at], wanted, (name, row))

    def test_numbers_in_result_files_say_their_unit(self):
        files = sorted(self.home.rglob('*.json'))
        for name in ('estimate', 'diagnosis', 'plan', 'inspect', 'comparison', 'coverage', 'validation', 'changed'):
            self.assertIn(name + '.json', [file.name for file in files])
        for file in files:
            unsaid_keys = set(keys_without_unit(json.loads(file.read_text())))
            with self.subTest(file=str(file.relative_to(self.home))):
                self.assertEqual(unsaid_keys, set())

    def test_columns_of_tables_in_files_end_with_their_unit(self):
        files = sorted(self.home.rglob('*.csv'))
        self.assertTrue(any(file.name == 'residuals.csv' for file in files))
        for file in files:
            rows = list(csv.DictReader(line for line in file.read_text().splitlines() if not line.startswith('#')))
            for column in rows[0]:
                plain = re.sub(r'_[xyz]$', '', column)  # whitened residuals; directions
                if column in BARE_COLUMNS or plain in ('whitened', 'paxis1', 'paxis2', 'paxis3') or not any(is_number(row[column]) for row in rows):
                    continue
                with self.subTest(file=file.name, column=column):
                    self.assertRegex(column, r'_(mm2?|um|deg|mrad|urad|s|Nm|N|kg|degC|K)$')

    def test_no_picture_is_drawn_to_a_number_that_no_arm_shows(self):
        # 10 m, 10^4 mm and 573 deg; an effect of 1e5 urad is 6 deg. Counts and chi-squares come as other columns.
        for name, page in self.pages.items():
            self.assertTrue(page.pictures, name)
            for picture in page.pictures:
                most = max((abs(v) for v in numbers_in([picture['data'], picture['settings']])), default=0.0)
                self.assertTrue(math.isfinite(most))
                with self.subTest(page=name, picture=picture['kind'], menus=str(picture['menus'])[:200]):
                    self.assertLess(most, 1e5)

    def test_rows_held_out_keep_their_colour_above_400_configurations(self):
        found = 0
        for picture in self.pages['many'].pictures:
            rows = picture['data'].get('rows') if isinstance(picture['data'], dict) else None
            if not isinstance(rows, dict) or 'set' not in rows:
                continue
            found += 1
            self.assertEqual(rows['set'].count('held out'), round(0.3 * POSES))
            self.assertEqual(rows['set'].count('fitted'), POSES - round(0.3 * POSES))
            colours = [menu for menu in picture['menus'].values() if 'set' in menu['options']]
            self.assertTrue(colours, picture['menus'])
        self.assertGreater(found, 0)


if __name__ == '__main__':
    PROGRAM = sys.argv.pop(1)
    unittest.main()
