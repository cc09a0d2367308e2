"""Recomputes every verdict of the committed pages with scipy, from their JSON records alone.

    python tests/reference/recompute_verdicts.py [FOLDER...]

Without folders: `reports/` and `tests/golden/verdicts/`. Of each claim the values of the runs are compared with the table of all
runs, then the p values, the comparisons, Holm's correction and the verdict are computed again. Needs numpy and scipy.
"""

import json
import math
import sys
from pathlib import Path

import numpy as np
from scipy import optimize, special, stats

RULES = 2

FEW, SMALLEST_OF_FEW = 5, 0.002
OF_RUNS = {"welch", "stratified_bootstrap", "mann_whitney", "probability_of_improvement"}
BOOTSTRAPS = {"stratified_bootstrap", "probability_of_improvement", "episode_bootstrap"}
PASS, FAIL, OPEN, MEANINGLESS = "PASS", "FAIL", "NOT ESTABLISHED", "NOT MEANINGFUL"


def wilson(successes, trials, level):
    z = stats.norm.isf(level / 2)
    share, scale = successes / trials, 1 / (1 + z * z / trials)
    centre = scale * (share + z * z / (2 * trials))
    half = scale * z * math.sqrt(share * (1 - share) / trials + z * z / (4 * trials**2))
    return (0.0 if successes == 0 else centre - half, 1.0 if successes == trials else centre + half)


def trend_weights(points):
    places = [point - (points - 1) / 2 for point in range(points)]
    return [place / sum(other * other for other in places) for place in places]


def trend_of_shares(counts, level):
    """Zou and Donner 2008: the interval of a slope of shares from Wilson's of each."""
    shares, ends = [s / n for s, n in counts], [wilson(s, n, level) for s, n in counts]
    weights = trend_weights(len(counts))
    value = sum(weight * share for weight, share in zip(weights, shares))
    reach = lambda side: math.sqrt(sum(
        (weight * (share - end[side if weight > 0 else 1 - side])) ** 2 for weight, share, end in zip(weights, shares, ends)
    ))
    return (value - reach(0), value + reach(1))


def newcombe(first, second, level, correlation=0.0):
    p, q = first[0] / first[1], second[0] / second[1]
    (a, b), (c, d) = wilson(*first, level), wilson(*second, level)
    reach = lambda x, y: math.sqrt(max(x * x + y * y - 2 * correlation * x * y, 0.0))
    return (p - q - reach(p - a, d - q), p - q + reach(b - p, q - c))


def paired(pairs, level):
    e, f, g, h = pairs
    n, product = e + f + g + h, (e + f) * (g + h) * (e + g) * (f + h)
    covariance = e * h - f * g
    corrected = max(covariance - n / 2, 0.0) if covariance > 0 else covariance
    correlation = corrected / math.sqrt(product) if product else 0.0
    return newcombe((e + f, n), (e + g, n), level, correlation)


def inverted(value, boundary, interval):
    """The level at which an interval begins to leave the boundary out."""
    if value == boundary:
        return 1.0
    side = 0 if boundary < value else 1
    reach = lambda log_level: interval(math.exp(log_level))[side] - boundary
    if reach(math.log(1e-9)) * (1 if side == 0 else -1) > 0:
        return 1e-9
    return math.exp(optimize.brentq(reach, math.log(1e-9), math.log(1 - 1e-12), xtol=1e-12))


def score(successes, trials, boundary):
    if not 0 < boundary < 1:
        return 1.0 if successes == boundary * trials else 0.0
    z = (successes / trials - boundary) / math.sqrt(boundary * (1 - boundary) / trials)
    return 2 * stats.norm.sf(abs(z))


def alike(sides):
    return all(len(runs) > 1 and len(set(runs)) == 1 for side in sides for runs in side)


def alike_p(sides, episodes, boundary):
    if len(sides) == 1:
        runs = sum(len(stratum) for stratum in sides[0])
        value = float(np.mean([stratum[0] for stratum in sides[0]]))
        if value == boundary:
            return 1.0
        if episodes and len(sides[0]) == 1 and 0 < boundary < 1:
            trials = runs * episodes
            return score(round(value * trials), trials, boundary)
        return min(2 * 0.5**runs, 1.0)
    strata = list(zip(*sides))
    if episodes and len(strata) == 1 and boundary != 0 and strata[0][0][0] == strata[0][1][0]:
        counts = [(round(side[0] * len(side) * episodes), len(side) * episodes) for side in strata[0]]
        return inverted(0.0, boundary, lambda level: newcombe(*counts, level))
    above = all(a[0] - boundary > b[0] for a, b in strata)
    below = all(a[0] - boundary < b[0] for a, b in strata)
    if not above and not below:
        return 1.0
    return min(2 * math.prod(1 / special.comb(len(a) + len(b), len(a), exact=True) for a, b in strata), 1.0)


def welch_p(sides, boundary, is_trend):
    weights = lambda side: trend_weights(len(side)) if is_trend else [1 / len(side)] * len(side)
    weighted = [
        (sign * weight, runs) for sign, side in zip((1, -1), sides) for weight, runs in zip(weights(side), side)
    ]
    if any(len(runs) < 2 for _, runs in weighted):
        return None
    value = sum(weight * np.mean(runs) for weight, runs in weighted)
    parts = [(weight**2 * np.var(runs, ddof=1) / len(runs), len(runs) - 1) for weight, runs in weighted]
    variance = sum(part for part, _ in parts)
    if variance == 0:
        return None
    freedom = variance**2 / sum(part**2 / n for part, n in parts)
    p = 2 * stats.t.sf(abs(value - boundary) / math.sqrt(variance), freedom)
    if len(weighted) == 2 and len(sides) == 2:
        library = stats.ttest_ind([run - boundary for run in sides[0][0]], sides[1][0], equal_var=False).pvalue
        assert math.isclose(p, library, rel_tol=1e-6), (p, library)
    return min(p, 1.0)


def mann_whitney_p(first, second, boundary):
    moved = [run - boundary for run in first]
    u = sum((x > y) + 0.5 * (x == y) for x in moved for y in second)
    larger = math.floor(max(u, len(first) * len(second) - u))
    # scipy's exact distribution is that of samples without ties.
    n, m = len(first), len(second)
    counts = np.zeros(n * m + 1)
    for ranks in ranks_of(n, n + m):
        counts[ranks - n * (n + 1) // 2] += 1
    return min(2 * counts[larger:].sum() / counts.sum(), 1.0)


def ranks_of(n, total):
    from itertools import combinations
    return (sum(chosen) for chosen in combinations(range(1, total + 1), n))


def drawn_p(sample, boundary):
    """The p value of a percentile bootstrap with draws of our own: it agrees with the page's up to the draws."""
    values, generator = sample(np.random.default_rng(1)), None
    below, above = (values < boundary).sum(), (values > boundary).sum()
    on = len(values) - below - above
    return min(2 * (min(below, above) + on + 1) / (len(values) + 1), 1.0)


def resampled(strata_of_sides, summary):
    def sample(generator):
        means = [
            summary([runs[generator.integers(len(runs), size=(10_000, len(runs)))] for runs in map(np.array, side)])
            for side in strata_of_sides
        ]
        return means[0] - means[1] if len(means) == 2 else means[0]
    return sample


mean_of_strata = lambda draws: np.mean([draw.mean(axis=1) for draw in draws], axis=0)


class Comparison:
    """One comparison: estimate, p value of a boundary, and for tests with both, the interval of a level."""

    def __init__(self, claim, case):
        self.test, self.evidence, self.value = claim["test"], case["evidence"], case["estimate"]["value"]
        self.is_trend = claim.get("over", "").startswith("trend of ")
        kind = next(iter(self.evidence))
        self.data = self.evidence[kind]
        if kind == "runs":
            factor = claim.get("factor", 1.0)
            scaled = lambda run, side: math.inf if run is None else run * (factor if side else 1.0)
            self.sides = [
                [[scaled(run, at) for run in runs] for runs in side] for at, side in enumerate(self.data["values"])
            ]
            if self.test == "mann_whitney":
                differences = [0.0 if x == y else x - y for x in sum(self.sides[0], []) for y in sum(self.sides[1], [])]
                self.value = float(np.median(differences))
            self.fewest = min((len(runs) for side in self.sides for runs in side), default=0)

    def p(self, boundary):
        p = self.exact_p(boundary)
        if p is not None and self.test in OF_RUNS and self.fewest < FEW:
            return max(p, SMALLEST_OF_FEW)
        return p

    def exact_p(self, boundary):
        test, data = self.test, self.data
        if self.is_trend and test == "welch" and alike(self.sides):
            episodes = data.get("episodes")
            if not episodes:
                return None
            counts = [(round(runs[0] * len(runs) * episodes), len(runs) * episodes) for runs in self.sides[0]]
            return inverted(self.value, boundary, lambda level: trend_of_shares(counts, level))
        if test in ("welch", "stratified_bootstrap") and alike(self.sides):
            return alike_p(self.sides, data.get("episodes"), boundary)
        if test == "welch":
            return welch_p(self.sides, boundary, self.is_trend)
        if test == "mann_whitney":
            return mann_whitney_p(*(sum(side, []) for side in self.sides), boundary)
        if test == "stratified_bootstrap":
            return drawn_p(resampled(self.sides, mean_of_strata), boundary)
        if test == "probability_of_improvement":
            return None  # recomputed only as far as its record goes
        if test == "wilson":
            return score(*data[0], boundary)
        if test == "newcombe":
            if boundary == 0 and not self.is_trend:
                (a, n), (b, m) = data
                return stats.fisher_exact([[a, n - a], [b, m - b]]).pvalue
            return inverted(self.value, boundary, self.interval)
        if test == "mcnemar":
            if isinstance(data, list) and len(data) == 4 and not isinstance(data[0], list):
                if boundary == 0:
                    n = data[1] + data[2]
                    return min(2 * stats.binom.cdf(min(data[1], data[2]), n, 0.5), 1.0) if n else 1.0
                return inverted(self.value, boundary, self.interval)
            return None
        if test == "episode_bootstrap":
            sides = [np.array(values) for values in data["values"]]
            if min(map(len, sides)) < FEW:
                return None
            strata = [[sides[0] - sides[1]]] if data["paired"] and len(sides) == 2 else [[side] for side in sides]
            return drawn_p(resampled(strata, mean_of_strata), boundary)
        raise ValueError(test)

    def interval(self, level):
        if self.is_trend:
            return trend_of_shares(self.data, level)
        return paired(self.data, level) if self.test == "mcnemar" else newcombe(*self.data, level)

    def agrees(self, level, holds):
        """Whether an interval of another kind than the p value says the same."""
        if self.test not in ("mcnemar", "newcombe") or self.p(0.0) is None:
            return True
        return holds(self.interval(level))


def weigh(claim, case, levels):
    low, high = claim["bounds"]
    one = Comparison(claim, case)
    if one.value is None:
        return OPEN, None, None
    p_of = lambda bound, is_beyond: one.p(bound) if is_beyond else 1.0
    ends = [p_of(low, one.value > low)] if low is not None else []
    ends += [p_of(high, one.value < high)] if high is not None else []
    p_for = None if None in ends else max(ends)
    p_against = 1.0
    if low is not None and one.value < low:
        p_against = one.p(low)
    elif high is not None and one.value > high:
        p_against = one.p(high)
    holds = lambda ends: (low is None or ends[0] > low) and (high is None or ends[1] < high)
    opposes = lambda ends: (low is not None and ends[1] < low) or (high is not None and ends[0] > high)
    if p_for is not None and p_for <= levels[0] and one.agrees(levels[0], holds):
        return PASS, p_for, p_against
    if p_against is not None and p_against <= levels[1] and one.agrees(levels[1], opposes):
        return FAIL, p_for, p_against
    return OPEN, p_for, p_against


def judge(claim):
    """Verdict and p value of a claim before the correction for the number of claims."""
    over = claim.get("over", "")
    names = list(dict.fromkeys(case.get("alternative", "") for case in claim["cases"]))
    groups = [[at for at, case in enumerate(claim["cases"]) if case.get("alternative", "") == name] for name in names]
    negated = over.startswith(("no ", "at most "))
    needed = int(over.split()[-1]) + negated if over.startswith("at ") else 1
    refuting = max(len(groups) + 1 - needed, 0)
    found = [None] * len(claim["cases"])
    for group in groups:
        levels = [claim["alpha"] / max(refuting, 1), claim["alpha"] / (needed * len(group))]
        for at in group:
            found[at] = weigh(claim, claim["cases"][at], levels)
    for case, (verdict, p_for, p_against) in zip(claim["cases"], found):
        check(claim, f"comparison `{case['label']}`", case["verdict"], verdict, case, p_for, p_against)
    together = [
        FAIL if any(found[at][0] == FAIL for at in group) else OPEN if any(found[at][0] == OPEN for at in group) else PASS
        for group in groups
    ]
    verdict = OPEN
    if groups and together.count(PASS) >= needed:
        verdict = FAIL if negated else PASS
    elif groups and together.count(FAIL) >= refuting:
        verdict = PASS if negated else FAIL
    if all(p_for is None for _, p_for, _ in found):
        return verdict, None
    known = lambda p: 1.0 if p is None else p
    hold = sorted(max(known(found[at][1]) for at in group) for group in groups)
    opposed = sorted(min(len(group) * min(known(found[at][2]) for at in group), 1.0) for group in groups)
    conjunction = lambda p, count: min(p[count - 1] * (len(p) + 1 - count), 1.0) if 0 < count <= len(p) else 1.0
    return verdict, min(conjunction(hold, needed), conjunction(opposed, refuting))


MISTAKES = []


def check(claim, what, written, ours, case=None, p_for=None, p_against=None):
    if written == ours:
        return
    close = lambda p: p is not None and any(0.5 < p / (claim["alpha"] / k) < 2 for k in (1, 2, 3, 4, 8, 12))
    if claim["test"] == "probability_of_improvement" or claim["test"] in BOOTSTRAPS and (close(p_for) or close(p_against)):
        return
    MISTAKES.append(f"{claim['id']}, {what}: the page says {written}, scipy {ours}")


def holm(p):
    order, adjusted, largest = sorted(range(len(p)), key=lambda at: p[at]), [1.0] * len(p), 0.0
    for rank, at in enumerate(order):
        largest = max(largest, min((len(p) - rank) * p[at], 1.0))
        adjusted[at] = largest
    return adjusted


def compare_values(claim, runs):
    """The values of each comparison are those of the table of all runs."""
    head, *rest = claim["metric"].split(" ")
    stage, _, metric = head.rpartition(".")
    # What only a claim asks for stands in no table.
    asked = [rest.pop(0) + rest.pop(0) for _ in range(2) if rest and rest[0] in ("until", "along")]
    sign, other, twin = (rest + [None] * 3)[:2] + [" ".join(rest[3:]) if rest[2:3] == ["of"] else None]
    if asked:
        return
    for case in claim["cases"]:
        values = case["evidence"].get("runs", {}).get("values")
        if values is None or metric == "samples_to_threshold":
            continue
        sources, at = case["sources"], 0
        for stratum in range(len(values[0])):
            for side in values:
                for value in side[stratum]:
                    run = runs[sources[at]["arm"]]["stages"]
                    ours = run[stage]["values"][metric]
                    if other:
                        compared = twin_of(runs, runs[sources[at]["arm"]], twin)["stages"] if twin else run
                        own = compared[other]["values"][metric]
                        ours = ours / own if sign == "/" else ours - own
                    if not math.isclose(value, ours, rel_tol=1e-9, abs_tol=1e-12):
                        MISTAKES.append(f"{claim['id']}, {sources[at]['arm']}: {value} is not {ours}")
                    at += 1


def twin_of(runs, run, points):
    """The run of the same seed in the arm that has these points and else the same."""
    split = lambda arm: dict(term.split("=", 1) for term in arm.split(","))
    wanted = {**split(run["arm"]), **split(points)}
    return next(other for other in runs.values() if other["seed"] == run["seed"] and split(other["arm"]) == wanted)


def page(path):
    record = json.loads(path.read_text())
    claims = record.get("claims", [])
    if not claims:
        return None
    if record["rules"] != RULES:
        MISTAKES.append(f"it was judged by version {record['rules']} of the rules, not {RULES}: render it again")
        return None
    runs = {run["run"]: run for run in record["runs"]}
    judged = []
    for claim in claims:
        compare_values(claim, runs)
        verdict, p = judge(claim)
        if claim.get("failing"):
            verdict, p = MEANINGLESS, None
        elif claim["missing"]:
            verdict = OPEN
        judged.append([verdict, p])
        told = claim["p"]
        exact = claim["test"] not in BOOTSTRAPS
        if exact and ((told is None) != (p is None) or p is not None and not math.isclose(told, p, rel_tol=1e-4, abs_tol=1e-9)):
            MISTAKES.append(f"{claim['id']}: the page's p is {told}, scipy's {p}")
    told = [claim["p"] for claim in claims]
    adjusted = holm([1.0 if p is None else p for p in told])
    for claim, (verdict, _), p in zip(claims, judged, adjusted):
        if verdict in (PASS, FAIL) and p > claim["alpha"]:
            verdict = OPEN
        check(claim, "verdict", claim["verdict"], verdict)
    return f"{len(claims)} verdicts"


def main():
    root = Path(__file__).resolve().parents[2]
    folders = [Path(argument) for argument in sys.argv[1:]] or [root / "reports", root / "tests/golden/verdicts"]
    failed, count = False, 0
    # Below a folder of reports, a record of a page has the page beside it; records of single runs have none.
    below = (path for folder in folders for path in folder.glob("*/**/*.json") if path.with_suffix(".md").exists())
    for path in sorted([*(path for folder in folders for path in folder.glob("*.json")), *below]):
        MISTAKES.clear()
        outcome = page(path)
        if outcome:
            count += 1
            print(f"{path.stem}: {outcome}")
        for mistake in MISTAKES:
            failed = True
            print(f"{path.stem}: {mistake}")
    print(f"recomputed {count} pages")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
