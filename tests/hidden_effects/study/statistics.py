"""Distributions and intervals; Python's standard library only."""
import math

NORMAL_95 = 1.959963984540054


def normal_cdf(x):
    return 0.5 * math.erfc(-x / math.sqrt(2.0))


def _gamma_series(a, x):
    term = total = 1.0 / a
    n = a
    while abs(term) > 1e-17 * abs(total):
        n += 1.0
        term *= x / n
        total += term
    return total * math.exp(a * math.log(x) - x - math.lgamma(a))


def _gamma_fraction(a, x):
    b = x + 1.0 - a
    c = 1e300
    d = 1.0 / b
    h = d
    for i in range(1, 10000):
        an = -i * (i - a)
        b += 2.0
        d = 1.0 / (an * d + b or 1e-300)
        c = b + an / c or 1e-300
        h *= d * c
        if abs(d * c - 1.0) < 1e-16:
            break
    return h * math.exp(a * math.log(x) - x - math.lgamma(a))


def chi_square_survival(x, dof):
    """P(X > x) of a chi-square variable."""
    if x <= 0.0:
        return 1.0
    a, half = 0.5 * dof, 0.5 * x
    return 1.0 - _gamma_series(a, half) if half < a + 1.0 else _gamma_fraction(a, half)


def _bisect(function, low, high, steps=200):
    """Root of an increasing function."""
    for _ in range(steps):
        middle = 0.5 * (low + high)
        if function(middle) < 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def chi_square_quantile_above(p, dof):
    """x with P(X > x) = p."""
    return _bisect(lambda x: p - chi_square_survival(x, dof), 0.0, 10.0 * dof + 2000.0)


def noncentral_survival(x, dof, noncentrality):
    """P(X > x) of a noncentral chi-square variable: Poisson mixture of central ones."""
    half = 0.5 * noncentrality
    if half == 0.0:
        return chi_square_survival(x, dof)
    total = 0.0
    spread = 10.0 * math.sqrt(half) + 30.0
    for k in range(max(0, int(half - spread)), int(half + spread) + 1):
        weight = math.exp(k * math.log(half) - half - math.lgamma(k + 1.0))
        total += weight * chi_square_survival(x, dof + 2 * k)
    return min(1.0, total)


def binomial_survival(k, n, p):
    """P(K >= k)."""
    if k <= 0:
        return 1.0
    if p <= 0.0:
        return 0.0
    if p >= 1.0:
        return 1.0
    total = 0.0
    for i in range(k, n + 1):
        total += math.exp(math.lgamma(n + 1) - math.lgamma(i + 1) - math.lgamma(n - i + 1)
                          + i * math.log(p) + (n - i) * math.log1p(-p))
    return min(1.0, total)


def clopper_pearson(k, n, level=0.95):
    """Exact interval of a probability after k of n."""
    if n == 0:
        return 0.0, 1.0
    tail = 0.5 * (1.0 - level)
    low = 0.0 if k == 0 else _bisect(lambda p: binomial_survival(k, n, p) - tail, 0.0, 1.0, 60)
    high = 1.0 if k == n else _bisect(lambda p: binomial_survival(k + 1, n, p) - (1.0 - tail), 0.0, 1.0, 60)
    return low, high


def kolmogorov_smirnov(values):
    """Distance of values from uniform on [0, 1], and its p-value (asymptotic, Stephens)."""
    n = len(values)
    if n == 0:
        return 0.0, 1.0
    ordered = sorted(values)
    distance = max(max((i + 1) / n - v, v - i / n) for i, v in enumerate(ordered))
    x = (math.sqrt(n) + 0.12 + 0.11 / math.sqrt(n)) * distance
    if x < 0.2:
        return distance, 1.0
    p = 2.0 * sum((-1) ** (k - 1) * math.exp(-2.0 * k * k * x * x) for k in range(1, 101))
    return distance, min(1.0, max(0.0, p))


def normal_quantile(p):
    return _bisect(lambda x: normal_cdf(x) - p, -40.0, 40.0)


def median(values):
    ordered = sorted(values)
    n = len(ordered)
    if n == 0:
        return float('nan')
    return ordered[n // 2] if n % 2 else 0.5 * (ordered[n // 2 - 1] + ordered[n // 2])
