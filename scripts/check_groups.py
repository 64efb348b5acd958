"""Comparisons of groups and components of variance, derived anew with scipy and numpy: the part of check_statistics.py that is
about several groups. Tests of parameters must agree to 1e-9 of p; pixels come from pycolmap's rays, which leave 1e-8 of a spread
and, as a tail is a power of F, 1e-6 of a p."""

import math
from collections import defaultdict

import numpy as np
from scipy import stats

TAIL = 0.025
LEVEL, POWER, RATIO, MOST_SAMPLES = 0.05, 0.8, 2.0, 10_000
BROWN_FORSYTHE_FROM = 10
MOST_GROUPS = 24
LIMIT = 2.8
PARAMETER, PIXEL = 1e-9, 1e-6  # relative, of what is derived
SPREAD = 1e-8


def degrees_of(rows):
    """Box: (n - 1) (tr W)^2 / tr W^2 over the deviations' products."""
    rows = rows - rows.mean(axis=0)
    return (len(rows) - 1) * independent_columns(rows)


def independent_columns(residuals):
    products = residuals @ residuals.T
    return np.trace(products) ** 2 / (products**2).sum()


def std_of(rows):
    return math.sqrt(((rows - rows.mean(axis=0)) ** 2).sum() / (len(rows) - 1))


def holm(p):
    corrected, least = [0.0] * len(p), 0.0
    for rank, index in enumerate(np.argsort(p, kind="stable")):
        least = max(least, min(1.0, (len(p) - rank) * p[index]))
        corrected[index] = least
    return corrected


def f_power(ratio, degrees, level=LEVEL):
    f = stats.f(*degrees)
    return f.sf(f.isf(level / 2) / ratio**2) + f.cdf(f.ppf(level / 2) / ratio**2)


def test(rows):
    """Method, F, degrees, p of two samples."""
    if all(len(one) >= BROWN_FORSYTHE_FROM for one in rows):
        distances = [np.linalg.norm(one - np.median(one, axis=0), axis=1) for one in rows]
        if rows[0].shape[1] == 1:
            f, p = stats.levene(*(one[:, 0] for one in rows), center="median")
        else:
            f, p = stats.f_oneway(*distances)
        return "brown-forsythe", f, (1, sum(map(len, rows)) - 2), p
    f, degrees = (std_of(rows[0]) / std_of(rows[1])) ** 2, [degrees_of(one) for one in rows]
    return "f", f, degrees, min(1.0, 2 * min(stats.f.sf(f, *degrees), stats.f.cdf(f, *degrees)))


def relative(checks, what, got, want, tolerance):
    checks.near(what, got, float(want), tolerance * abs(float(want)))
    checks.group_count += 1


def check_test(checks, name, got, rows, tolerance):
    """One test, but for Holm's correction. The first of the rows varies more."""
    method, f, degrees, p = test(rows)
    checks.equal(f"{name} method", got["method"], method)
    checks.equal(f"{name} n", got["n"], [len(one) for one in rows])
    for side in (0, 1):
        relative(checks, f"{name} std", got["std"][side], std_of(rows[side]), tolerance)
        relative(checks, f"{name} degrees", got["degrees"][side], degrees[side], tolerance)
    relative(checks, f"{name} ratio", got["ratio"], std_of(rows[0]) / std_of(rows[1]), tolerance)
    relative(checks, f"{name} f", got["f"], f, tolerance)
    relative(checks, f"{name} p", got["p"], p, tolerance)
    check_outlook(checks, name, got, [degrees_of(one) for one in rows], tolerance)


def check_outlook(checks, name, got, own, tolerance):
    """The power, and the n that are needed, by the samples' own degrees."""
    relative(checks, f"{name} power", got["power_at_2"], f_power(RATIO, own), tolerance)
    columns = min(d / (n - 1) for d, n in zip(own, got["n"]))
    for key, ratio in (("n_for_2", RATIO), ("n_for_ratio", got["ratio"])):
        n = got[key]
        power = lambda n: f_power(ratio, [(n - 1) * columns] * 2)
        is_least = power(n) > POWER - 1e-9 and (n == 2 or power(n - 1) < POWER + 1e-9) if n else power(MOST_SAMPLES) < POWER
        checks.equal(f"{name} {key} = {n} is the least that will do", bool(is_least), True)


def check_holm(checks, name, tests):
    for got, want in zip(tests, holm([one["p"] for one in tests])):
        relative(checks, f"{name} p_holm", got["p_holm"], want, 1e-12)


def vectors_of(population):
    columns = [[s["value"] for s in p["samples"]] for p in population["parameters"]]
    return [list(row) for row in zip(*columns) if None not in row]


def estimated(parameter, states=("estimated",)):
    values = [s["value"] for s in parameter["samples"] if s["state"] in states]
    return np.array(values)[:, None]


class Rays:
    """Rays of cameras at the cells of an image, each derived once."""

    def __init__(self, lens_class, cell_centres):
        self.lens_class, self.cell_centres, self.known = lens_class, cell_centres, {}

    def of(self, population, params):
        key = (population["model"], population["width"], population["height"], *params)
        if key not in self.known:
            lens = self.lens_class(*key[:3])
            self.known[key] = lens.rays_at(params, self.cell_centres(*key[1:3]))
        return self.known[key]

    def deviations(self, populations, together):
        """Rows of raw deviations for each population, and the share of the image; None where pycolmap sees nothing in common."""
        first = populations[0]
        pixels = self.cell_centres(first["width"], first["height"])
        fields = [[self.of(one, params) for params in vectors_of(one)] for one in populations]
        seen = set(range(len(pixels)))
        for cells, _ in (field for of_group in fields for field in of_group):
            seen &= set(cells.tolist())
        cells = np.array(sorted(seen), int)
        if len(cells) == 0:
            return None, 0.0
        rays = [[ray[np.searchsorted(at, cells)] for at, ray in of_group] for of_group in fields]
        projects = [[self.projection(one, params) for params in vectors_of(one)] for one in populations]
        sets = [range(len(populations))] if together else [[i] for i in range(len(populations))]
        raw = [np.zeros((0, 2 * len(cells)))] * len(populations)
        for members in sets:
            seen_by = [ray for i in members for ray in rays[i]]
            for i in members:
                off = [(project(unit(sum(seen_by))) - pixels[cells]).ravel() for project in projects[i]]
                raw[i] = np.array(off).reshape(-1, 2 * len(cells)) / math.sqrt(len(cells))
        return raw, len(cells) / len(pixels)

    def projection(self, population, params):
        lens = self.lens_class(population["model"], population["width"], population["height"])
        return lambda rays: lens.project(params, rays)


def unit(rays):
    return rays / np.linalg.norm(rays, axis=-1, keepdims=True)


def check_stated_test(checks, name, got, degrees):
    """A test of aligned spreads: what follows from the std, degrees and method that are stated."""
    relative(checks, f"{name} ratio", got["ratio"], got["std"][0] / got["std"][1], PARAMETER)
    is_f = got["method"] == "f"
    checks.equal(f"{name} method", is_f, min(got["n"]) < BROWN_FORSYTHE_FROM)
    if is_f:
        relative(checks, f"{name} f", got["f"], got["ratio"] ** 2, PARAMETER)
        checks.equal(f"{name} degrees", got["degrees"], degrees)
    tails = stats.f.sf(got["f"], *got["degrees"]), stats.f.cdf(got["f"], *got["degrees"])
    relative(checks, f"{name} p", got["p"], min(1.0, 2 * min(tails)) if is_f else tails[0], PARAMETER)
    check_outlook(checks, name, got, degrees, PARAMETER)


def check_comparison(checks, name, comparison, population_of, rays, wide):
    """Raw spreads are derived from rays; of the aligned ones, whose search is not repeated here, what follows from them."""
    ranking = comparison["ranking"]
    size = (comparison["width"], comparison["height"])
    members = [population_of[one["group"], one["camera"], one["model"], *size] for one in ranking]
    raw, share = rays.deviations(members, together=False)
    if any(one["model"] in wide for one in members) and comparison["image_share"] != share:
        checks.skipped["groups with wide models"] += 1
        return
    checks.equal(f"{name} image_share", comparison["image_share"], share if raw else None)
    for one, of_group in zip(ranking, raw or []):
        what = f"{name} {one['group']}"
        checks.equal(f"{what} n", one["n"], len(of_group))
        if one["raw_spread_px"] is None or one["spread_px"] is None:
            checks.equal(f"{what} has too few for a spread", len(of_group) < 2 or std_of(of_group) == 0, True)
            continue
        relative(checks, f"{what} raw_spread_px", one["raw_spread_px"], std_of(of_group), SPREAD)
        checks.equal(f"{what} aligned is below raw", one["spread_px"] <= one["raw_spread_px"] * (1 + 1e-3), True)
        degrees = one["degrees"]
        checks.equal(f"{what} degrees are of one column at least, and of rows at most",
                     len(of_group) - 1 <= degrees * (1 + 1e-12) and degrees <= (len(of_group) - 1) ** 2 * (1 + 1e-12), True)
        for end, tail in enumerate((1 - TAIL, TAIL)):
            want = one["spread_px"] * math.sqrt(degrees / stats.chi2.ppf(tail, degrees))
            relative(checks, f"{what} interval", one["spread_interval_95"][end], want, PARAMETER)
    found = [one for one in ranking if one["spread_px"] is not None]
    spreads = [one["spread_px"] for one in found]
    checks.equal(f"{name} is ranked", spreads, sorted(spreads))
    checks.equal(f"{name} ranks those without a spread last", found, ranking[: len(found)])
    pairs = [(more, less) for i, less in enumerate(found) for more in found[i + 1 :] if len(ranking) <= MOST_GROUPS]
    checks.equal(f"{name} pairs", len(comparison["spreads"]), len(pairs))
    for got, pair in zip(comparison["spreads"], pairs):
        what = f"{name} spread of {got['groups']}"
        checks.equal(what, got["groups"], [one["group"] for one in pair])
        checks.equal(f"{what} std", got["std"], [one["spread_px"] for one in pair])
        checks.equal(f"{what} n", got["n"], [one["n"] for one in pair])
        check_stated_test(checks, what, got, [one["degrees"] for one in pair])
    check_holm(checks, f"{name} spreads", comparison["spreads"])
    check_parameter_tests(checks, name, comparison, members)


def check_parameter_tests(checks, name, comparison, members):
    is_few = len(members) <= MOST_GROUPS
    pairs = [(more, less) for i, less in enumerate(members) for more in members[i + 1 :] if is_few]
    want = []
    for more, less in pairs:
        for x, y in zip(more["parameters"], less["parameters"]) if more["model"] == less["model"] else ():
            if x["statistics"] and y["statistics"]:
                (_, a), (_, b) = sorted([(x["statistics"]["std"], 0), (y["statistics"]["std"], 1)], reverse=True)
                sides = [(more, x), (less, y)]
                want.append((x["name"], sides[a], sides[b]))
    checks.equal(f"{name} tests of parameters", len(comparison["parameters"]), len(want))
    for got, (parameter, (more, x), (less, y)) in zip(comparison["parameters"], want):
        what = f"{name} {parameter} of {got['groups']}"
        checks.equal(what, (got["parameter"], got["groups"]), (parameter, [more["group"], less["group"]]))
        check_test(checks, what, got, [estimated(x), estimated(y)], PARAMETER)
    check_holm(checks, f"{name} parameters", comparison["parameters"])


def one_way(groups):
    """Searle, Casella and McCulloch's estimates; Burdick and Graybill's intervals."""
    sizes = np.array([len(group) for group in groups])
    a, count = len(groups), sizes.sum()
    means = np.array([group.mean(axis=0) for group in groups])
    residuals = np.concatenate([group - mean for group, mean in zip(groups, means)])
    within = (residuals**2).sum() / (count - a)
    deviations = means - np.concatenate(groups).mean(axis=0)
    square_between = (sizes[:, None] * deviations**2).sum() / (a - 1)
    between = (square_between - within) / ((count - (sizes**2).sum() / count) / (a - 1))
    columns = independent_columns(residuals)
    degrees = [(a - 1) * columns, (count - a) * columns]
    size = stats.hmean(sizes)
    unweighted = size * ((means - means.mean(axis=0)) ** 2).sum() / (a - 1)
    d1, d2 = (a - 1) * independent_columns(means - means.mean(axis=0)), degrees[1]
    to_infinity = lambda tail, d: stats.chi2.isf(tail, d) / d
    g1, g2 = (1 - 1 / to_infinity(TAIL, d) for d in (d1, d2))
    h1, h2 = (1 / to_infinity(1 - TAIL, d) - 1 for d in (d1, d2))
    f1, f2 = stats.f.isf(TAIL, d1, d2), stats.f.isf(1 - TAIL, d1, d2)
    g12 = ((f1 - 1) ** 2 - (g1 * f1) ** 2 - h2**2) / f1
    h12 = ((1 - f2) ** 2 - (h1 * f2) ** 2 - g2**2) / f2
    x, y = unweighted / size, within / size
    low = x - y - math.sqrt(max(0, (g1 * x) ** 2 + (h2 * y) ** 2 + g12 * x * y))
    high = x - y + math.sqrt(max(0, (h1 * x) ** 2 + (g2 * y) ** 2 + h12 * x * y))
    y = (1 - 1 / size) * within
    total = within + max(between, 0)
    f = square_between / within
    return {
        "repeatability_std": math.sqrt(within),
        "repeatability_interval_95": [math.sqrt(within / to_infinity(tail, d2)) for tail in (TAIL, 1 - TAIL)],
        "between_variance": between,
        "between_std": math.sqrt(max(between, 0)),
        "between_interval_95": [math.sqrt(max(end, 0)) for end in (low, high)],
        "reproducibility_std": math.sqrt(total),
        "reproducibility_interval_95": [
            math.sqrt(x + y - math.hypot(g1 * x, g2 * y)), math.sqrt(x + y + math.hypot(h1 * x, h2 * y)),
        ],
        "repeatability_limit": LIMIT * math.sqrt(within),
        "reproducibility_limit": LIMIT * math.sqrt(total),
        "f": f,
        "degrees": degrees,
        "p": stats.f.sf(f, *degrees),
    }  # fmt: skip


def check_variance_components(checks, name, got, groups, tolerance):
    checks.equal(f"{name} n", got["n"], [len(group) for group in groups])
    want = one_way([group for group in groups if len(group)])
    checks.equal(f"{name} keys", set(got), set(want) | {"n"})
    # A component is a difference of mean squares: what is left of it may have lost digits, its root half of them.
    lost = tolerance * want["reproducibility_std"] ** 2
    for key, value in want.items():
        for one, other in zip(*(v if isinstance(v, list) else [v] for v in (got[key], value))):
            if key.startswith("between"):
                squares = (one, other) if key == "between_variance" else (one**2, other**2)
                checks.near(f"{name} {key}", float(squares[0]), float(squares[1]), max(lost, tolerance * abs(squares[1])))
                checks.group_count += 1
            else:
                relative(checks, f"{name} {key}", one, other, tolerance)


def shared_path(one, other):
    parts = []
    for a, b in zip(one.split("/"), other.split("/")):
        if a != b:
            break
        parts.append(a)
    return "/".join(parts)


def families(populations):
    """Populations of one camera, model and size, by the longest path that each shares with another."""
    kinds, parents = defaultdict(list), defaultdict(list)
    for one in populations:
        kinds[one["camera"], one["model"], one["width"], one["height"]].append(one)
    for kind, members in kinds.items():
        for one in members:
            paths = [shared_path(one["group"], other["group"]) for other in members if other is not one]
            if paths:
                parents[kind, max(paths, key=len)].append(one)
    return {key: members for key, members in parents.items() if len(members) > 1}


def check_components(checks, path, analysis, rays, wide):
    got_of = {}
    for one in analysis["components"]:
        got_of[(one["camera"], one["model"], one["width"], one["height"]), one["parent"]] = one
    checks.equal(f"{path}: components are listed once", len(got_of), len(analysis["components"]))
    for key, members in families(analysis["populations"]).items():
        name = f"{path}: components of {key}"
        values = {}
        for parameters in zip(*(one["parameters"] for one in members)):
            groups = [estimated(p, ("estimated", "unknown")) for p in parameters]
            present = [group for group in groups if len(group)]
            varies = any(len(set(group[:, 0])) > 1 for group in present)
            if len(present) > 1 and varies:
                values[parameters[0]["name"]] = groups
        checks.equal(f"{name} are there", key in got_of, bool(values))
        if not values or key not in got_of:
            continue
        got = got_of.pop(key)
        checks.equal(f"{name} groups", got["groups"], [one["group"] for one in members])
        checks.equal(f"{name} parameters", [one["parameter"] for one in got["parameters"]], list(values))
        for one in got["parameters"]:
            what = f"{name} {one['parameter']}"
            check_variance_components(checks, what, one["components"], values[one["parameter"]], PARAMETER)
        raw, share = rays.deviations(members, together=True)
        if key[0][1] in wide and (got["image"] or {"image_share": 0})["image_share"] != share:
            checks.skipped["components of wide models"] += 1
            continue
        checks.equal(f"{name} image", got["image"] is not None, raw is not None)
        if got["image"] and raw:
            checks.equal(f"{name} image_share", got["image"]["image_share"], share)
            check_variance_components(checks, f"{name} raw image", got["image"]["raw"], raw, PIXEL)
    checks.equal(f"{path}: components of what is no family", list(got_of), [])


def check_groups(checks, path, analysis, lens_class, cell_centres, wide):
    """All that analysis.json says of several groups."""
    rays = Rays(lens_class, cell_centres)
    keys = ("group", "camera", "model", "width", "height")
    population_of = {tuple(one[key] for key in keys): one for one in analysis["populations"]}
    cameras = defaultdict(set)
    for one in analysis["populations"]:
        cameras[one["camera"], one["width"], one["height"]].add((one["group"], one["model"]))
    compared = {(one["camera"], one["width"], one["height"]): one for one in analysis["comparisons"]}
    for camera, groups in cameras.items():
        if len(groups) > 1 and not camera[0].startswith("camera of "):
            ranked = {(one["group"], one["model"]) for one in compared.get(camera, {"ranking": []})["ranking"]}
            checks.equal(f"{path}: groups that have {camera} and are not compared", groups - ranked, set())
    for one in analysis["comparisons"]:
        check_comparison(checks, f"{path}: comparison of {one['camera']}", one, population_of, rays, wide)
    check_components(checks, path, analysis, rays, wide)
