#!/usr/bin/env python3
"""What docs/TUTORIAL.md found, next to the truth that its readings were simulated with.

    python3 docs/tutorial/compare_with_truth.py results

Reads results/calibrated/estimate.json and results/points.csv. The true arm is that of problems/published/make_kr270.py,
which shares no code with the program. Standard library only.
"""
import csv
import json
import math
import pathlib
import sys

PUBLISHED = pathlib.Path(__file__).resolve().parent.parent.parent / 'problems' / 'published'
sys.dont_write_bytecode = True
sys.path.insert(0, str(PUBLISHED))
import make_kr270  # noqa: E402  (the path comes first)

GEOMETRIC, LOADED = (json.loads((PUBLISHED / 'kr270' / name).read_text(encoding='utf-8'))
                     for name in ('truth.json', 'loaded_truth.json'))


def true_values():
    """By parameter name, in the units of estimate.json: mm, mrad, deg, urad/Nm, N/mm."""
    values = {'geometry/' + name: entry.get('value_mm', entry.get('value_deg'))
              for name, entry in GEOMETRIC['geometry'].items()}
    for station, pose in list(GEOMETRIC['stations'].items()) + list(LOADED['stations'].items()):
        turned = pose.get('rotvec_mrad') or [1e3 * math.radians(angle) for angle in pose['rotvec_deg']]
        for axis, length, angle in zip('xyz', pose['xyz_mm'], turned):
            values['base/%s/%s' % (station, axis)] = length
            values['base/%s/r%s' % (station, axis)] = angle
    markers = {name: entry['xyz_mm'] for name, entry in GEOMETRIC['markers'].items()}
    for marker, point in dict(markers, **LOADED['markers']).items():
        values.update({'marker/%s/%s' % (marker, axis): length for axis, length in zip('xyz', point)})
    values.update({'compliance/A%d' % (j + 1): k for j, k in enumerate(LOADED['compliance_urad_per_Nm'])})
    spring = LOADED['spring']
    return dict(values, **{'compensator/s0': spring['s0_mm'], 'compensator/Kc': spring['Kc_N_per_mm']})


def chi_square(deviations, correlation):
    """d' C^-1 d by Cholesky's factor C = L L'."""
    factor, whitened = [], []
    for i, row in enumerate(correlation):
        line = []
        for j in range(i):
            line.append((row[j] - sum(a * b for a, b in zip(line, factor[j]))) / factor[j][j])
        line.append(math.sqrt(row[i] - sum(a * a for a in line)))
        factor.append(line)
        whitened.append((deviations[i] - sum(a * b for a, b in zip(line, whitened))) / line[i])
    return sum(w * w for w in whitened)


def off_target_mm(row, prefix, to_deg):
    """Distance of the true, loaded flange from that of the nominal arm at the program's joint values."""
    error = {name: entry['value_mm'] if 'value_mm' in entry else math.radians(entry['value_deg'])
             for name, entry in GEOMETRIC['geometry'].items()}
    wanted = make_kr270.flange([math.degrees(float(row['q%d_rad' % j])) for j in range(1, 7)],
                               dict.fromkeys(make_kr270.ERRORS, 0.0)).origin
    q_deg = [to_deg(float(row[prefix % j])) for j in range(1, 7)]
    level = [math.radians(angle) for angle in GEOMETRIC['stations']['S1']['rotvec_deg']]
    force = make_kr270.rotate([-angle for angle in level], (0.0, 0.0, -LOADED['load_N']))
    arm, _ = make_kr270.loaded_arm(q_deg, error, LOADED, force, LOADED['load_point_mm'])
    return math.dist(arm.origin, wanted)


def main(folder):
    folder = pathlib.Path(folder)
    estimate = json.loads((folder / 'calibrated' / 'estimate.json').read_text(encoding='utf-8'))
    found = {p['name']: p for p in estimate['parameters']}
    truth = true_values()
    missed = [name for name, value in truth.items() if not found[name]['ci95'][0] <= value <= found[name]['ci95'][1]]
    print('%d of %d intervals hold the truth; not: %s' % (len(truth) - len(missed), len(truth), ', '.join(missed)))
    names = estimate['correlation']['names']
    deviations = [(found[name]['value'] - truth[name]) / found[name]['sigma'] for name in names]
    print('all at once, correlations counted: chi-square %.1f of %d'
          % (chi_square(deviations, estimate['correlation']['matrix']), len(names)))
    print('\ntrue distance from the target, mm\n  point            program  corrected  stated 95 %')
    with open(folder / 'points.csv', encoding='utf-8') as lines:
        for row in csv.DictReader(lines):
            print('  %-15s %8.2f %10.3f %12.3f' % (row['target'], off_target_mm(row, 'q%d_rad', math.degrees),
                                                   off_target_mm(row, 'q%d_cmd_deg', float), float(row['u95_mm'])))


if __name__ == '__main__':
    main(*sys.argv[1:])
