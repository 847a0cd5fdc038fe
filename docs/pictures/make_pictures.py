#!/usr/bin/env python3
"""Draws the pictures of README.md and docs/TUTORIAL.md from the results of the tutorial's ten commands.

    python3 docs/pictures/make_pictures.py results [--out DIR]

The folder holds what the commands wrote: job/, believed/, diagnosis/, calibrated/. `sagitta` has to be on the PATH: the
nominal robot, with only base poses and markers fitted, is computed here. White background, legible in dark mode too.
"""
import argparse
import json
import pathlib
import subprocess
import tempfile

import matplotlib
matplotlib.use('svg')
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)
import numpy as np  # noqa: E402
import pandas as pd  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
NOMINAL, BELIEVED, CALIBRATED = '#8c8c8c', '#d95f02', '#1b5e9c'  # distinguished by colour-blind readers, and in print
plt.rcParams.update({'svg.fonttype': 'none', 'svg.hashsalt': 'sagitta', 'font.family': 'sans-serif', 'font.size': 11,
                     'figure.facecolor': 'white', 'axes.facecolor': 'white', 'savefig.facecolor': 'white',
                     'axes.spines.top': False, 'axes.spines.right': False, 'axes.grid': True, 'grid.color': '#e4e4e4',
                     'axes.axisbelow': True})

NOMINAL_EXPERIMENT = '\nestimate: {geometry: none, compliance: none}\n'
RESIDUAL = ['res_x_mm', 'res_y_mm', 'res_z_mm']


def nominal_residuals(job):
    """Residuals of the nominal robot of the tutorial's start, without the compensator that it is given later."""
    with tempfile.TemporaryDirectory() as folder:
        robot = [line for line in (job / 'robot.yaml').read_text().splitlines() if 'gravity_compensator' not in line]
        pathlib.Path(folder, 'robot.yaml').write_text('\n'.join(robot) + '\n')
        pathlib.Path(folder, 'measurements.csv').write_text((job / 'measurements.csv').read_text())
        experiment = pathlib.Path(folder, 'experiment.yaml')
        experiment.write_text((job / 'experiment.yaml').read_text() + NOMINAL_EXPERIMENT)
        subprocess.run(['sagitta', 'calibrate', str(experiment), '--out=' + folder + '/out', '--quiet'], check=True,
                       stdout=subprocess.DEVNULL)
        return pd.read_csv(folder + '/out/residuals.csv')


def distances(rows):
    return np.sort(np.linalg.norm(rows[RESIDUAL].to_numpy(), axis=1))


def save(figure, path):
    figure.savefig(path, metadata={'Date': None, 'Creator': None}, bbox_inches='tight', pad_inches=0.15)
    plt.close(figure)


def errors(nominal, believed, calibrated, path):
    figure, axes = plt.subplots(figsize=(7.2, 3.4))
    for rows, colour, label in ((nominal, NOMINAL, 'nominal robot'), (believed, BELIEVED, 'geometry and compliances'),
                                (calibrated, CALIBRATED, 'with the gravity compensator')):
        sorted_mm = distances(rows)
        axes.step(sorted_mm, np.arange(1, len(sorted_mm) + 1) / len(sorted_mm) * 100, where='post', color=colour,
                  linewidth=2.4, label=label)
    axes.set_xscale('log')
    axes.set_xlim(0.008, 10)
    axes.set_xticks([0.01, 0.1, 1, 10], ['0.01', '0.1', '1', '10'])
    axes.set_xlabel('distance between measured and predicted point, mm')
    axes.set_ylabel('readings within, %')
    axes.legend(frameon=False, loc='lower center', bbox_to_anchor=(0.5, 1.0), ncols=3, columnspacing=1.2)
    save(figure, path)


def compensator(believed, calibrated, path):
    """What the believed model leaves over the angle of joint 2: height of the loaded poses of station S3."""
    figure, axes = plt.subplots(figsize=(7.2, 3.4))
    for rows, colour, marker, label in ((believed, BELIEVED, 'o', 'geometry and compliances'),
                                        (calibrated, CALIBRATED, 's', 'with the gravity compensator')):
        loaded = rows[rows['station'] == 'S3']
        axes.plot(loaded['q2_deg'], loaded['res_z_mm'], marker, color=colour, markersize=6, alpha=0.8, label=label)
    axes.axhline(0, color='black', linewidth=0.8)
    axes.set_xlabel('angle of joint A2, deg')
    axes.set_ylabel('measured − predicted height, mm')
    axes.legend(frameon=False, loc='lower left')
    save(figure, path)


def known(folder, path):
    """Estimated compliances with their 95 % intervals, next to the values that the simulation used."""
    truth_file = HERE.parent.parent / 'problems' / 'published' / 'kr270' / 'loaded_truth.json'
    truth = json.loads(truth_file.read_text())['compliance_urad_per_Nm']
    values = {p['name']: p for p in json.loads((folder / 'estimate.json').read_text())['parameters']}
    figure, axes = plt.subplots(figsize=(7.2, 2.8))
    for j in range(1, 7):
        found, true = values['compliance/A%d' % j], truth[j - 1]
        low, high = found['ci95']
        axes.plot([100 * (low / true - 1), 100 * (high / true - 1)], [j, j], color=CALIBRATED, linewidth=3,
                  solid_capstyle='butt')
        axes.plot(100 * (found['value'] / true - 1), j, 'o', color=CALIBRATED, markersize=7)
    axes.axvline(0, color='black', linewidth=1)
    axes.set_yticks(range(1, 7), ['A%d' % j for j in range(1, 7)])
    axes.invert_yaxis()
    axes.set_xlabel('compliance, estimate − truth, % of the truth (bars: 95 % intervals)')
    save(figure, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('results', type=pathlib.Path)
    parser.add_argument('--out', type=pathlib.Path, default=HERE)
    arguments = parser.parse_args()
    folder, out = arguments.results, arguments.out
    believed, calibrated = (pd.read_csv(folder / name / 'residuals.csv') for name in ('believed', 'calibrated'))
    errors(nominal_residuals(folder / 'job'), believed, calibrated, out / 'kr270_errors.svg')
    compensator(believed, calibrated, out / 'kr270_residual_over_a2.svg')
    known(folder / 'calibrated', out / 'kr270_compliances.svg')


if __name__ == '__main__':
    main()
