"""Rows of a real measurement, with columns made up in which nothing can be: the placebo."""
import csv
import json
import math
import random
import re

SECONDS_PER_ROW = 25.0
DEPENDS_ON_PLACEBO = {'backlash', 'joint_slip', 'thermal_growth', 'station_drift', 'marker_shift'}
DATA_SETS = {'ur5': ('ur5_gts3800', 'measurements.csv'), 'ur10_b': ('ur10_leica', 'series_B.csv'),
             'ur10_d': ('ur10_leica', 'series_D.csv')}
INJECTED = ['joint_harmonic', 'encoder_gain', 'joint_coupling', 'axis_wobble', 'backlash', 'joint_slip',
            'thermal_growth', 'station_drift', 'marker_shift']


class RealData:
    def __init__(self, folder, file):
        self.robot_text = (folder / 'robot.yaml').read_text()
        with open(folder / file, newline='') as stream:
            self.rows = [r for r in csv.DictReader(stream)]
        self.joints = re.findall(r'- \{name: (\w+), type: revolute\}', self.robot_text)

    def dh(self):
        """Nominal table in rad and m."""
        links = []
        for line in re.findall(r'- \{joint: (.*)\}', self.robot_text):
            numbers = {k: float(v) for k, v in re.findall(r'(\w+): (-?[\d.]+)', line)}
            links.append({'theta': math.radians(numbers.get('theta_deg', 0.0)), 'd': 1e-3 * numbers.get('d_mm', 0.0),
                          'a': 1e-3 * numbers.get('a_mm', 0.0), 'alpha': math.radians(numbers.get('alpha_deg', 0.0)),
                          'beta': math.radians(numbers.get('beta_deg', 0.0))})
        return links

    def take(self, count, seed):
        """A random part of the rows, in their order."""
        if count and count < len(self.rows):
            chosen = sorted(random.Random('rows/%d' % seed).sample(range(len(self.rows)), count))
            self.rows = [self.rows[i] for i in chosen]

    def halves(self, seed):
        """Rows of two disjoint halves, in their order; equal joint values stay together."""
        poses = sorted({self.pose(row) for row in self.rows})
        random.Random('halves/%s' % seed).shuffle(poses)
        first = set(poses[::2])
        return [[row for row in self.rows if (self.pose(row) in first) == is_first] for is_first in (True, False)]

    def replace_points(self, path):
        """x, y, z of rows in the same order."""
        with open(path, newline='') as stream:
            others = list(csv.DictReader(stream))
        if len(others) != len(self.rows):
            raise ValueError('%s: %d rows, %d expected' % (path, len(others), len(self.rows)))
        for row, other in zip(self.rows, others):
            row.update({a + '_mm': other[a + '_mm'] for a in 'xyz'})

    def pose(self, row):
        return tuple(row['q%d_deg' % (j + 1)] for j in range(len(self.joints)))

    def drop(self, configurations):
        self.rows = [r for r in self.rows if r['config'] not in configurations]

    def make_up_columns(self, seed):
        """Time, temperature and approach that have nothing to do with the rows: all of them permuted."""
        draw = random.Random('placebo/%d' % seed)
        order = list(range(len(self.rows)))
        draw.shuffle(order)
        temperatures = [float(r.get('temperature_degC') or 0.0) for r in self.rows]
        if max(temperatures) - min(temperatures) < 0.5:  # none in the file: a warm-up
            temperatures = [20.0 + 5.0 * (1.0 - math.exp(-i / (0.4 * len(order)))) for i in range(len(order))]
        draw.shuffle(temperatures)
        for row, place, temperature in zip(self.rows, order, temperatures):
            row['time_s'] = '%.1f' % (place * SECONDS_PER_ROW)
            row['temperature_degC'] = '%.4f' % temperature
            for j in range(len(self.joints)):
                row['approach%d' % (j + 1)] = str(draw.choice((-1, 1)))

    def write(self, folder, robot_text, sigma_mm, effects, displacement=None, points=None):
        """robot.yaml, measurements.csv, experiment.yaml; `points` replace the measured ones."""
        folder.mkdir(parents=True, exist_ok=True)
        (folder / 'robot.yaml').write_text(robot_text)
        with open(folder / 'measurements.csv', 'w', newline='') as stream:
            names = [n for n in self.rows[0] if not n.startswith('sigma_')]
            writer = csv.DictWriter(stream, names, extrasaction='ignore', lineterminator='\n')
            writer.writeheader()
            for i, row in enumerate(self.rows):
                xyz = list(points[i]) if points else [float(row[a + '_mm']) for a in 'xyz']
                if displacement:
                    xyz = [v + d for v, d in zip(xyz, displacement[i])]
                writer.writerow(dict(row, **{a + '_mm': '%.9f' % v for a, v in zip('xyz', xyz)}))
        noise = 'noise: {sigma_mm: %.9g}\n' % sigma_mm if sigma_mm else ''
        (folder / 'experiment.yaml').write_text(
            'schema: sagitta/experiment/1\nrobot: robot.yaml\nmeasurements: [measurements.csv]\n' + noise +
            'estimate:\n  base: true\n  markers: true\n  geometry: default\n' + ('  effects: all\n' if effects else '') +
            'validation: {fraction: 0.3, seed: 1}\n')
        return folder / 'experiment.yaml'

    def generator_input(self, estimate):
        """What the generator needs of the arm as it stands."""
        first = {}
        for row in self.rows:
            first.setdefault(row['station'], float(row['time_s']))
        rows = [{'q_rad': [math.radians(float(row['q%d_deg' % (j + 1)])) for j in range(len(self.joints))],
                 'station': row['station'], 'marker': row['marker'], 'time_s': float(row['time_s']),
                 'since_start_s': float(row['time_s']) - first[row['station']],
                 'temperature_degC': float(row['temperature_degC']),
                 'approach': [int(row['approach%d' % (j + 1)]) for j in range(len(self.joints))]} for row in self.rows]
        return {'joints': [{'name': n, 'low_rad': -math.pi, 'high_rad': math.pi} for n in self.joints], 'dh': self.dh(),
                'stations': {n: {'origin_m': [1e-3 * v for v in s['xyz_mm']],
                                 'rotvec_rad': [1e-3 * v for v in s['rotvec_mrad']]}
                             for n, s in estimate['stations'].items()},
                'markers': {n: [1e-3 * v for v in m['xyz_mm']] for n, m in estimate['markers'].items()}, 'rows': rows}


def predicted_points(results):
    with open(results / 'residuals.csv', newline='') as stream:
        return [[float(r['pred_%s_mm' % a]) for a in 'xyz'] for r in csv.DictReader(stream)]


def displacement_of(programs, data, estimate, kind, number, scale, seed, folder):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / 'in.json').write_text(json.dumps(data.generator_input(estimate)))
    programs.displace(folder / 'in.json', folder / 'out.json', kind, scale, seed, number)
    answer = json.loads((folder / 'out.json').read_text())
    return answer['hidden'], answer['displacement_mm']
