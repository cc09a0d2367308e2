"""Reference values for the analysis of failures over parameter sets, by independent implementations.

Writes failures.json beside this file. Needs numpy, scikit-learn and statsmodels; the versions that made the committed file
stand in it. The sets come from a formula (multiples of square roots of primes), so that the test makes the same ones to
the bit. The tests read the JSON, never this script.
"""

import json
from importlib.metadata import version
from pathlib import Path

import numpy as np
import statsmodels.api as sm
from sklearn.decomposition import PCA
from sklearn.linear_model import LogisticRegression

PRIMES = [2, 3, 5, 7, 11, 13, 17, 19]
LUCK = 23
SETS = 400


def spread(prime):
    """Numbers in [0, 1) that fill it evenly."""
    multiples = np.arange(1, SETS + 1, dtype=float) * np.sqrt(float(prime))
    return multiples - np.floor(multiples)


def sets():
    return np.stack([2.0 * spread(prime) - 1.0 for prime in PRIMES], axis=1)


def failed(x):
    """Delay-like in the first parameter, both extremes in the fourth, some luck."""
    odds = -1.2 + 2.0 * x[:, 0] + 0.8 * x[:, 1] - 0.6 * x[:, 2] + 1.5 * x[:, 3] ** 2
    return spread(LUCK) < 1.0 / (1.0 + np.exp(-odds))


def design(x):
    z = (x - x.mean(axis=0)) / x.std(axis=0)
    q = z**2
    return np.hstack([z, (q - q.mean(axis=0)) / q.std(axis=0)])


def aligned(direction, rows):
    """Towards the mean of the rows."""
    return direction if direction @ rows.mean(axis=0) > 0 else -direction


def regression(x, fails):
    fit = sm.Logit(fails.astype(float), sm.add_constant(design(x))).fit(disp=0, method="newton", tol=1e-12)
    return {"intercept": float(fit.params[0]), "coefficients": [float(p) for p in fit.params[1:]]}


def ridge(x, fails):
    """The squared coefficients but not the intercept carry a penalty of one half each."""
    fit = LogisticRegression(C=1.0, solver="newton-cholesky", tol=1e-12, max_iter=1000).fit(design(x), fails)
    return {"intercept": float(fit.intercept_[0]), "coefficients": [float(p) for p in fit.coef_[0]]}


def main():
    x = sets()
    fails = failed(x)
    rows = x[fails]
    _, values, right = np.linalg.svd(rows, full_matrices=False)
    difference = x[fails].mean(axis=0) - x[~fails].mean(axis=0)
    pooled = np.sqrt(0.5 * (x[fails].var(axis=0, ddof=1) + x[~fails].var(axis=0, ddof=1)))
    tenths = [np.array_split(np.argsort(column, kind="stable"), 10) for column in x.T]
    apart = x[:, 0] > 0.3
    reference = {
        "made_by": {name: version(name) for name in ["numpy", "scikit-learn", "statsmodels"]},
        "failures": int(fails.sum()),
        "direction": [float(entry) for entry in aligned(right[0], rows)],
        "share": float(values[0] ** 2 / (values**2).sum()),
        "centred": [float(entry) for entry in PCA(n_components=1).fit(rows).components_[0]],
        "logit": regression(x, fails),
        "separated": {"failures": int(apart.sum()), "ridge": ridge(x, apart)},
        "differences": [float(entry) for entry in difference / pooled],
        "deciles": [[int(fails[part].sum()) for part in parts] for parts in tenths],
    }
    Path(__file__).with_name("failures.json").write_text(json.dumps(reference, indent=1) + "\n")


if __name__ == "__main__":
    main()
