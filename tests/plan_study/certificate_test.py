#!/usr/bin/env python3
"""The optimum and the bound of a plan's certificate against an independent convex solver (cvxopt, interior points).

For the candidates of a KR 270 (three markers, two stations, base and markers unknown) and the criteria I, A and D the
problem  minimise f(M0 + N sum_i w_i A_i' A_i), w >= 0, sum w = 1  is solved by cvxopt.solvers.cp with derivatives of its
own, written from the information and not from the covariance's blocks as the library does:

    I   tr(W M^-1)           d_i = -N tr(A_i C W C A_i')     H_ij = 2 N^2 tr((A_i C A_j')(A_j C W C A_i'))
    A   the same with W = the identity on the robot's parameters
    D   ln det C_SS = ln det M_RR - ln det M (R: base and markers)     H_ij = N^2 (|A_i C A_j'|^2 - |A_iR M_RR^-1 A_jR'|^2)

usage: certificate_test.py SAGITTA_EXPORT_DESIGN
"""
import json
import subprocess
import sys

try:
    import cvxopt
    import numpy as np
except ImportError as missing:
    print("skipped: %s; tools/install-dependencies --tests installs python3-cvxopt" % missing)
    sys.exit(77)

POSES, CANDIDATES = 24, 30  # each candidate from two stations
AGREEMENT = 3e-5            # of the cost's scale: both stop within 1e-5 of it


def exported(program, criterion):
    text = subprocess.run([program, criterion, str(POSES), str(CANDIDATES)], check=True, stdout=subprocess.PIPE).stdout
    design = json.loads(text)
    design["known"] = np.array(design["known"])
    return design


def block_sums(matrix, first):
    """Sums of a matrix of rows x rows over the blocks of candidates."""
    return np.add.reduceat(np.add.reduceat(matrix, first[:-1], axis=0), first[:-1], axis=1)


class Problem:
    """Cost, gradient and Hessian over the weights of the candidates."""

    def __init__(self, design):
        self.n, self.known = design["poses"], design["known"]
        self.rows, self.first = np.array(design["rows"]), np.array(design["first"])
        self.size = len(self.first) - 1
        p = len(self.known)
        self.interest = design["interest"]
        self.rest = [i for i in range(p) if i not in set(self.interest)]
        self.is_log = design["criterion"] == "D"
        self.w = np.array(design["weight"])
        if design["criterion"] == "A":
            self.w = np.zeros((p, p))
            self.w[self.interest, self.interest] = 1.0

    def information(self, weights):
        per_row = np.repeat(weights, np.diff(self.first))
        return self.known + self.n * (self.rows.T * per_row) @ self.rows

    def __call__(self, weights):
        m = self.information(weights)
        c = np.linalg.inv(m)
        cross = self.rows @ c @ self.rows.T
        if not self.is_log:
            sloped = self.rows @ c @ self.w @ c @ self.rows.T
            value = np.trace(self.w @ c)
            gradient = -self.n * np.add.reduceat(np.diag(sloped), self.first[:-1])
            return value, gradient, 2 * self.n ** 2 * block_sums(cross * sloped, self.first)
        inner = m[np.ix_(self.rest, self.rest)]
        of_rest = self.rows[:, self.rest] @ np.linalg.inv(inner) @ self.rows[:, self.rest].T
        value = np.linalg.slogdet(inner)[1] - np.linalg.slogdet(m)[1]
        gradient = self.n * np.add.reduceat(np.diag(of_rest - cross), self.first[:-1])
        return value, gradient, self.n ** 2 * block_sums(cross ** 2 - of_rest ** 2, self.first)


def solved(problem):
    """The least cost, by cvxopt."""
    size = problem.size
    scale = abs(problem(np.full(size, 1.0 / size))[0])

    def f(x=None, z=None):
        if x is None:
            return 0, cvxopt.matrix(1.0 / size, (size, 1))
        try:  # on the way there weights may be negative, as long as the information is positive definite
            np.linalg.cholesky(problem.information(np.array(x).ravel()))
        except np.linalg.LinAlgError:
            return None
        value, gradient, hessian = problem(np.array(x).ravel())
        value, gradient, hessian = value / scale, gradient / scale, hessian / scale
        if z is None:
            return cvxopt.matrix(value), cvxopt.matrix(gradient).T
        return cvxopt.matrix(value), cvxopt.matrix(gradient).T, z[0] * cvxopt.matrix(hessian)

    cvxopt.solvers.options.update({"show_progress": False, "abstol": 1e-7, "reltol": 1e-7, "feastol": 1e-8})
    positive = cvxopt.spdiag([-1.0] * size)
    answer = cvxopt.solvers.cp(f, positive, cvxopt.matrix(0.0, (size, 1)), A=cvxopt.matrix(1.0, (1, size)),
                               b=cvxopt.matrix(1.0))
    assert answer["status"] == "optimal", answer["status"]
    return problem(np.array(answer["x"]).ravel())[0]


def main(program):
    failures = 0
    for criterion in ("I", "A", "D"):
        design = exported(program, criterion)
        problem = Problem(design)
        best = solved(problem)
        scale = len(design["interest"]) if criterion == "D" else abs(best)
        over, under = (design["cost"] - best) / scale, (best - design["bound"]) / scale
        good = -1e-7 < over < AGREEMENT and -1e-7 < under < AGREEMENT
        print("%s: cvxopt %.8g, ours %.8g (%+.1e of the scale), bound %.8g (%+.1e)%s" % (
            criterion, best, design["cost"], over, design["bound"], -under, "" if good else "   FAILED"))
        failures += not good
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
