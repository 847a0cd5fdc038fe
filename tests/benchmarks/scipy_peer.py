#!/usr/bin/env python3
"""The benchmarks' problem by scipy.optimize.least_squares: trust region, numeric Jacobian, numpy over all configurations.

usage: tests/benchmarks/scipy_peer.py MEASURED.csv

Writes a JSON line: seconds of the solve from nominal (base poses and markers from the truth of tests/benchmarks/run,
rounded to 1 mm and 1 mrad), evaluations, and the RMS that is left, mm. The model is that of problems/published/kr270:
18 geometric errors, six compliances, a spring on A2, equilibrium by two steps of a fixed point.
"""
import csv
import json
import sys
import time

import numpy
from scipy.optimize import least_squares

L, A_X, S0 = 0.18472, 0.68593, 0.450  # m
LOAD_POINT = numpy.array([0.280, 0.060, -0.150])  # m, flange frame
SIGMA = 5e-5  # m
START = numpy.concatenate([
    [-0.034, -0.031, -0.097, 0.052, 0.002, -0.015], [0.100, 3.000, 0.050, 0.003, -0.002, 0.700],  # base poses
    [0.279, -0.016, -0.092, 0.279, -0.025, 0.096, 0.282, 0.130, 0.006],  # markers
    numpy.zeros(18), 0.9e-6 * numpy.array([0.623, 0.302, 0.416, 2.786, 3.483, 2.074]), [0.12330, 1.1e5]])
X, Y, Z = numpy.eye(3)


def read(path):
    """Joint values, forces and stations by configuration, and points: n x 3 markers x 3, m."""
    with open(path, encoding='utf-8') as source:
        rows = list(csv.DictReader(source))
    first = rows[::3]
    q = numpy.radians([[float(row['q%d_deg' % (j + 1)]) for j in range(6)] for row in first])
    force = numpy.array([[float(row['f%s_N' % axis]) for axis in 'xyz'] for row in first])
    station = numpy.array([int(row['station'][1:]) - 1 for row in first])
    points = 1e-3 * numpy.array([[float(row[axis + '_mm']) for axis in 'xyz'] for row in rows])
    return q, force, station, points.reshape(-1, 3, 3)


def turn(axis, angle):
    """Rotations about one axis, n x 3 x 3."""
    cross = numpy.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    angle = numpy.asarray(angle, float).reshape(-1, 1, 1)
    return numpy.eye(3) + numpy.sin(angle) * cross + (1 - numpy.cos(angle)) * (cross @ cross)


def rotation(vector):
    angle = numpy.linalg.norm(vector)
    return turn(vector / angle, angle)[0] if angle > 0 else numpy.eye(3)


def arm(v, e):
    """Axes and origins of the joints, flange rotation and origin, of n configurations."""
    axes, origins = [], []
    r, p = numpy.broadcast_to(numpy.eye(3), (len(v), 3, 3)), numpy.broadcast_to([0, 0, 0.75], (len(v), 3))
    after = ([(0.350 + e[0], e[1], 0), (X, e[2])], [(1.250 + e[4], 0, 0), (X, e[5]), (Z, e[6])],
             [(1.100 + e[8], 0, -0.055 + e[9]), (Z, e[10])], [(0, e[12], e[13]), (Z, e[14])],
             [(0, 0, e[16]), (Z, e[17])], [(0.230, 0, 0)])
    for j, about in enumerate((Z, Y, Y, X, Y, X)):
        axes.append(r @ about)
        origins.append(p)
        r = r @ turn(about, v[:, j])
        p = p + r @ numpy.array(after[j][0])
        for axis, angle in after[j][1:]:
            r = r @ turn(axis, angle)
    return axes, origins, r, p


def residuals(x, q, force, station, points):
    bases, markers, e = x[:12].reshape(2, 6), x[12:21].reshape(3, 3), x[21:39]
    k, (a_y, k_c) = x[39:45], x[45:]
    rotations = numpy.array([rotation(base[3:]) for base in bases])[station]
    in_base = numpy.einsum('nji,nj->ni', rotations, force)
    free = q + numpy.concatenate([[0], e[[3, 7, 11, 15]], [0]])
    v = free
    for _ in range(2):
        axes, origins, r, p = arm(v, e)
        at = p + r @ LOAD_POINT
        torque = numpy.stack([numpy.einsum('ni,ni->n', axis, numpy.cross(at - origin, in_base))
                              for axis, origin in zip(axes, origins)], axis=1)
        s, c = numpy.sin(v[:, 1]), numpy.cos(v[:, 1])
        length = numpy.hypot(A_X + L * s, a_y + L * c)
        torque[:, 1] -= k_c * (length - S0) / length * L * (A_X * c - a_y * s)
        v = free + k * torque
    _, _, r, p = arm(v, e)
    seen = p[:, None, :] + numpy.einsum('nij,mj->nmi', r, markers)
    predicted = bases[station][:, None, :3] + numpy.einsum('nij,nmj->nmi', rotations, seen)
    return ((predicted - points) / SIGMA).ravel()


def main():
    data = read(sys.argv[1])
    begin = time.process_time()
    result = least_squares(residuals, START, args=data, x_scale='jac', method='trf', ftol=1e-9, xtol=1e-12, gtol=1e-12)
    seconds = time.process_time() - begin
    rms = 1e3 * SIGMA * float(numpy.sqrt(numpy.mean(result.fun**2)))
    print(json.dumps({'seconds': seconds, 'evaluations': int(result.nfev), 'rms_mm': rms, 'chi2': 2 * float(result.cost)}))


if __name__ == '__main__':
    main()
