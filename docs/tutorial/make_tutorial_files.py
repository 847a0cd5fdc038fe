#!/usr/bin/env python3
"""Writes the files that docs/TUTORIAL.md starts from: what a measuring day and a robot's shelf would leave behind.

    python3 docs/tutorial/make_tutorial_files.py [--out DIR]

tracker.txt   rows of problems/published/kr270/loaded.csv (stages `geometry` and `loads`) as tracker software exports
              them: semicolons, decimal commas, its own headers. Simulated, not measured; see problems/published/SOURCES.md.
handling.src  a KRL program, its poses those of the nominal arm (Frame and `flange` of make_kr270.py).

Standard library only; the same bytes every time.
"""
import argparse
import csv
import math
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
PUBLISHED = HERE.parent.parent / 'problems' / 'published'
sys.dont_write_bytecode = True
sys.path.insert(0, str(PUBLISHED))
import make_kr270  # noqa: E402  (the path comes first)

STAGES = ('geometry', 'loads')
TOOL_LENGTH_MM = 300.0  # of the gripper, along the controller's flange axis z = the robot file's x
POINTS = (  # name in the program, joint values in deg
    ('PTP', (30, -70, 95, 10, 60, 20)),
    ('LIN', (30, -52, 92, 12, 45, 18)),
    ('PTP', (-40, -60, 100, -15, 50, -20)),
)


def comma(text, digits):
    return ('%.*f' % (digits, float(text))).replace('.', ',')


def tracker_rows():
    header = ['Pose', 'Reflector', 'Station', 'Load'] + ['A%d [deg]' % j for j in range(1, 7)]
    yield header + ['measured X [mm]', 'measured Y [mm]', 'measured Z [mm]', 'sigma X [mm]', 'sigma Y [mm]', 'sigma Z [mm]']
    with open(PUBLISHED / 'kr270' / 'loaded.csv', encoding='utf-8') as lines:
        rows = [row for row in csv.DictReader(line for line in lines if not line.startswith('#'))
                if row['stage'] in STAGES]
    for row in rows:
        yield ([row[name] for name in ('config', 'marker', 'station', 'load')]
               + [comma(row['q%d_deg' % j], 4) for j in range(1, 7)]
               + [comma(row[name + '_mm'], 3) for name in ('x', 'y', 'z', 'sigma_x', 'sigma_y', 'sigma_z')])


def abc_deg(x, y, z):
    """KUKA's A, B, C of a rotation with columns x, y, z: Rz(A) Ry(B) Rx(C)."""
    return (math.degrees(math.atan2(x[1], x[0])), math.degrees(math.asin(-x[2])), math.degrees(math.atan2(y[2], z[2])))


def pose_of(q_deg):
    frame = make_kr270.flange(q_deg, dict.fromkeys(make_kr270.ERRORS, 0.0))
    u, v, w = frame.axes
    x, y, z = [-c for c in w], v, u  # the controller's flange has z outward: Ry(90 deg)
    return frame.point((TOOL_LENGTH_MM, 0, 0)), abc_deg(x, y, z)


def status_and_turn(q_deg):
    """S: bit 1 the elbow past the angle where the arm is stretched, bit 2 the wrist negative; T: one bit per joint < 0."""
    stretched_deg = math.degrees(math.atan2(-55, 1100))
    status = (2 if q_deg[2] > stretched_deg else 0) + (4 if q_deg[4] < 0 else 0)
    return status, sum(1 << j for j, q in enumerate(q_deg) if q < 0)


def program():
    lines = ['DEF HANDLING( )', '; carries a casting of 250 kg', '$BASE = $NULLFRAME',
             '$TOOL = {X 0, Y 0, Z %g, A 0, B 0, C 0}   ; the gripper' % TOOL_LENGTH_MM,
             'PTP {A1 0, A2 -90, A3 90, A4 0, A5 45, A6 0}   ; home']
    for motion, q_deg in POINTS:
        (x, y, z), (a, b, c) = pose_of(q_deg)
        lines.append('%s {X %.3f, Y %.3f, Z %.3f, A %.4f, B %.4f, C %.4f, S %d, T %d}'
                     % ((motion, x, y, z, a, b, c) + status_and_turn(q_deg)))
    return '\r\n'.join(lines + ['END']) + '\r\n'


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--out', type=pathlib.Path, default=HERE)
    folder = parser.parse_args().out
    rows = '\r\n'.join(';'.join(row) for row in tracker_rows()) + '\r\n'
    (folder / 'tracker.txt').write_bytes(rows.encode('utf-8'))
    (folder / 'handling.src').write_bytes(program().encode('ascii'))


if __name__ == '__main__':
    main()
