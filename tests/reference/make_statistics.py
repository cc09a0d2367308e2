"""Reference values for the statistics of reports, by independent implementations.

Writes statistics.json beside this file. Needs numpy, scipy, statsmodels and rliable; the versions that made the committed
file stand in it. The tests read the JSON, never this script.
"""

import itertools
import json
from importlib.metadata import version
from pathlib import Path

import numpy as np
from rliable import library as rly
from rliable import metrics as rl_metrics
from scipy import stats
from statsmodels.stats.contingency_tables import mcnemar
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.proportion import confint_proportions_2indep, proportion_confint

COUNTS = [[15, 25], [18, 25], [22, 25], [25, 25], [0, 20], [1, 29], [3477, 4870], [3604, 4870], [0, 1], [1, 1]]
PAIRS = [
    [[15, 25], [25, 25]], [[18, 25], [25, 25]], [[22, 25], [25, 25]], [[25, 25], [25, 25]],
    [[3604, 4870], [3477, 4870]], [[0, 32], [32, 32]], [[7, 32], [13, 48]], [[1, 3], [2, 3]],
]
SEEDS = {
    "apart": [[0.91, 0.88, 0.97, 0.84, 0.93], [0.41, 0.66, 0.52, 0.38, 0.71]],
    "overlapping": [[3.1, 2.4, 5.9, 4.4, 3.8], [2.9, 4.1, 2.2, 3.3, 1.7]],
    "tied": [[1.0, 1.0, 0.5, 1.0, 0.75], [1.0, 0.5, 0.5, 0.25, 1.0]],
    "uneven": [[12.0, 15.5, 11.2, 19.9, 14.1, 13.3, 16.0], [11.0, 12.5, 9.9, 10.1]],
}
P_VALUES = [[0.01, 0.04, 0.03, 0.005], [0.5, 0.9], [0.02], [0.012, 0.012, 0.2, 0.001, 0.04]]
LEVELS = [0.95, 0.99, 0.8]


def one_proportion():
    for (successes, trials), level in itertools.product(COUNTS, LEVELS):
        low, high = proportion_confint(successes, trials, alpha=1 - level, method="wilson")
        yield {"count": [successes, trials], "confidence": level, "interval": [float(low), float(high)]}


def two_proportions():
    for (first, second), level in itertools.product(PAIRS, LEVELS):
        low, high = confint_proportions_2indep(*first, *second, method="newcomb", compare="diff", alpha=1 - level)
        table = [[first[0], first[1] - first[0]], [second[0], second[1] - second[0]]]
        yield {
            "counts": [first, second], "confidence": level, "interval": [float(low), float(high)],
            "fisher": float(stats.fisher_exact(table).pvalue),
        }


def discordant():
    for only_first, only_second in [(10, 2), (0, 5), (3, 3), (0, 0), (21, 8), (140, 96)]:
        result = mcnemar([[7, only_first], [only_second, 4]], exact=True)
        yield {"discordant": [only_first, only_second], "p": float(result.pvalue)}



def exact_difference(first, second):
    """The 2.5 and 97.5 percentiles of the difference of means over every pair of resamples."""
    means = [np.array([np.mean(draw) for draw in itertools.product(s, repeat=len(s))]) for s in (first, second)]
    return np.quantile(np.subtract.outer(*means).ravel(), [0.025, 0.975])


def seeds():
    for name, (first, second) in SEEDS.items():
        x, y = np.array(first), np.array(second)
        rank = stats.mannwhitneyu(x, y, method="exact")
        welch = stats.ttest_ind(x, y, equal_var=False)
        interval = welch.confidence_interval(0.95)
        entry = {
            "name": name, "first": first, "second": second,
            "iqm": [float(stats.trim_mean(x, 0.25)), float(stats.trim_mean(y, 0.25))],
            "welch": {"p": float(welch.pvalue), "interval": [float(interval.low), float(interval.high)]},
            "improvement": float(rl_metrics.probability_of_improvement(x[:, None], y[:, None])),
            "ties": len(set(first + second)) < len(first + second),
            "mann_whitney": float(rank.pvalue),
        }
        if len(first) == len(second) == 5:
            entry["bootstrap"] = [float(end) for end in exact_difference(first, second)]
        yield entry


def rank_interval():
    """Hodges and Lehmann's interval of a shift from the exact distribution of U, by its definition."""
    for name in ["apart", "overlapping", "uneven"]:
        first, second = (np.array(sample) for sample in SEEDS[name])
        n, m = len(first), len(second)
        ranks = [sum(subset) - n * (n + 1) // 2 for subset in itertools.combinations(range(1, n + m + 1), n)]
        counts = np.bincount(ranks, minlength=n * m + 1) / len(ranks)
        cut = 0
        while counts[: cut + 1].sum() <= 0.025:
            cut += 1
        shifts = np.sort(np.subtract.outer(first, second).ravel())
        yield {
            "name": name, "shift": float(np.median(shifts)),
            "interval": [float(shifts[cut - 1]), float(shifts[-cut])],
        }


def stratified():
    """rliable: runs in rows, tasks in columns; runs are resampled inside each task."""
    scores = np.array([[0.9, 0.3, 0.6], [0.8, 0.5, 0.65], [1.0, 0.2, 0.7], [0.7, 0.4, 0.5], [0.95, 0.45, 0.55]])
    for name, aggregate in [("mean", rl_metrics.aggregate_mean), ("iqm", rl_metrics.aggregate_iqm)]:
        random = np.random.RandomState(1)
        point, ends = rly.get_interval_estimates(
            {"x": scores}, lambda x, f=aggregate: np.array([f(x)]), reps=200_000, random_state=random
        )
        yield {
            "summary": name, "strata": scores.T.tolist(), "value": float(point["x"][0]),
            "interval": [float(ends["x"][0, 0]), float(ends["x"][1, 0])],
        }


def improvement_interval():
    """rliable's interval of the probability of improvement; ties count one half."""
    first, second = (np.array(sample)[:, None] for sample in SEEDS["overlapping"])
    random = np.random.RandomState(1)
    point, ends = rly.get_interval_estimates(
        {"x": (first, second)}, lambda x, y: np.array([rl_metrics.probability_of_improvement(x, y)]),
        reps=20_000, random_state=random,
    )
    return {"name": "overlapping", "value": float(point["x"][0]), "interval": [float(e) for e in ends["x"][:, 0]]}


def holm():
    for values in P_VALUES:
        yield {"p": values, "adjusted": [float(p) for p in multipletests(values, method="holm")[1]]}


def main():
    packages = ["numpy", "scipy", "statsmodels", "rliable"]
    reference = {
        "made_by": {name: version(name) for name in packages},
        "one_proportion": list(one_proportion()),
        "two_proportions": list(two_proportions()),
        "discordant": list(discordant()),
        "seeds": list(seeds()),
        "rank_interval": list(rank_interval()),
        "stratified": list(stratified()),
        "improvement_interval": improvement_interval(),
        "holm": list(holm()),
    }
    Path(__file__).with_name("statistics.json").write_text(json.dumps(reference, indent=1) + "\n")


if __name__ == "__main__":
    main()
