"""Robot, experiment and rows that a test changes, writes and gives to the program."""
import copy
import csv
import math
import pathlib
import subprocess

import yaml

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
KR270 = ROOT / 'problems' / 'published' / 'kr270'


class Case:
    """robot: text; experiment: without schema, robot and measurements; rows: dictionaries of texts."""

    def __init__(self, robot, experiment, rows):
        self.robot, self.experiment, self.rows = robot, experiment, rows
        self.files = 1

    def copy(self):
        return copy.deepcopy(self)

    def write(self, folder):
        folder.mkdir(parents=True)
        (folder / 'robot.yaml').write_text(self.robot)
        names = ['rows%d.csv' % i for i in range(self.files)]
        per_file = -(-len(self.rows) // self.files)
        for i, name in enumerate(names):
            with open(folder / name, 'w', newline='') as stream:
                writer = csv.DictWriter(stream, list(self.rows[0]), lineterminator='\n')
                writer.writeheader()
                writer.writerows(self.rows[i * per_file:(i + 1) * per_file])
        experiment = dict(self.experiment, schema='sagitta/experiment/1', robot='robot.yaml', measurements=names)
        (folder / 'experiment.yaml').write_text(yaml.safe_dump(experiment, sort_keys=False))
        return folder / 'experiment.yaml'

    def column(self, old, new, change):
        """Renames a column and changes its cells."""
        self.rows = [{(new if k == old else k): (change(v) if k == old else v) for k, v in row.items()}
                     for row in self.rows]


def read_rows(path):
    with open(path, newline='') as stream:
        return list(csv.DictReader(line for line in stream if not line.startswith('#')))


def mark_validation(rows):
    """Every fourth configuration is held out, whatever it is called."""
    order = list(dict.fromkeys(row['config'] for row in rows))
    held_out = set(order[::4])
    return [dict(row, set='validation' if row['config'] in held_out else 'calibration') for row in rows]


def kr270_with_ripple(program, folder, seed=5):
    """The published arm with a periodic error of joint 3 that its robot file does not know: two stations, three
    markers, 36 configurations, 0.05 mm."""
    believed = (KR270 / 'robot.yaml').read_text()
    effect = 'effects: [{effect: joint_harmonic, joint: A3, order: 1, cos_urad: 260, sin_urad: -150}]\n'
    rows = []
    for row in read_rows(KR270 / 'geometric.csv'):
        rows.append(dict(row))
        # A second configuration from each, its joints moved by up to 40 degrees.
        other = dict(row, config=row['config'] + 'b')
        number = int(row['config'][1:])
        for j in range(1, 7):
            key = 'q%d_deg' % j
            other[key] = repr(float(row[key]) + 40 * math.sin(1 + number * (0.7 + 0.31 * j)))
        rows.append(other)
    rows.sort(key=lambda row: (row['config'], row['marker']))
    truth = Case(believed + effect, {
        'noise': {'sigma_mm': 0.05}, 'validation': 'none',
        'stations': {'S1': {'xyz_mm': [10, 20, 30], 'rotvec_mrad': [100, -50, 300]},
                     'S2': {'xyz_mm': [-40, 10, 5], 'rotvec_mrad': [20, 30, -700]}},
        'markers': {'P1': {'xyz_mm': [279, -16, -92]}, 'P2': {'xyz_mm': [10, 200, 100]},
                    'P3': {'xyz_mm': [100, -100, 200]}}}, rows)
    experiment = truth.write(folder / 'truth')
    done = subprocess.run([program, 'simulate', str(experiment), '--truth=%s' % experiment, '--seed=%d' % seed,
                           '--out=%s' % (folder / 'simulated.csv')], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return Case(believed, {'noise': {'sigma_mm': 0.05}, 'validation': {'column': 'set'}},
                mark_validation(read_rows(folder / 'simulated.csv')))
