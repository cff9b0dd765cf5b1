# SPDX-License-Identifier: MIT
"""Reading the chart programs' CSV files, and what is computed from their rows."""
import csv
import math
import os

import numpy as np


def read(path):
    """Rows as dictionaries, and the "# key: value" lines at the top."""
    if not os.path.exists(path):
        return [], {}
    with open(path, encoding="utf-8") as file:
        lines = file.readlines()
    about = dict(line[2:].strip().split(": ", 1) for line in lines if line.startswith("# ") and ": " in line)
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    for row in rows:
        row.setdefault("rest", "steps")  # of builds that knew no other way
    for row in rows:  # a software renderer's time is never taken for a GPU's
        if "software renderer" in row.get("device", ""):
            for key in ("backend", "engine"):
                if key in row:
                    row[key] += " (software renderer)"
    return rows, about


def number(row, key):
    """NaN where the field is empty."""
    text = row.get(key, "")
    return float(text) if text else math.nan


def groups(rows, *keys):
    """Rows by the values of some columns, in order of first appearance."""
    result = {}
    for row in rows:
        result.setdefault(tuple(row[key] for key in keys), []).append(row)
    return result


def caption(about):
    return f"{about.get('machine', '?')} · {about.get('compiler', '?')} {about.get('flags', '').strip()} · {about.get('date', '?')}"


def error_column(rows):
    """The column of a case's errors: of the force where it has no samples of the displacement."""
    return "error" if any(row["error"] for row in rows) or not any(row["force_error"] for row in rows) else "force_error"


def cheapest_by_resolution(rows, time, error="error"):
    """Of each resolution the fastest run that came to rest: over steps and backends."""
    best = {}
    for row in rows:
        if row["status"] != "ok" or math.isnan(number(row, time)) or math.isnan(number(row, error)):
            continue
        n = int(row["n"])
        if n not in best or number(row, time) < number(best[n], time):
            best[n] = row
    return [best[n] for n in sorted(best)]


GAIN = 0.95


def front(rows, time, error):
    """(time, error) of the fastest runs of each method, way to rest and resolution that no other beats in both. An error
    less by under a twentieth is no gain: how near to rest a run came makes such differences."""
    points = [(number(row, time), number(row, error)) for of_one in groups(rows, "method", "rest").values()
              for row in cheapest_by_resolution(of_one, time, error)]
    result = []
    for point in sorted(points):
        if not result or point[1] < GAIN * result[-1][1]:
            result.append(point)
    return result


def time_at(points, error):
    """When a front, read along straight lines on the logarithmic chart, comes below an error; infinite where never."""
    before = None
    for time, reached in points:
        if reached <= error / GAIN:
            if before is None:
                return time
            share = min(1.0, math.log(before[1] / error) / math.log(before[1] / max(reached, 1e-12)))
            return before[0] * (time / before[0]) ** share
        before = (time, reached)
    return math.inf


def fitted_slope(x, y):
    """Slope of log y over log x; NaN with fewer than two points."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    good = (x > 0) & (y > 0)
    if good.sum() < 2:
        return math.nan
    return float(np.polyfit(np.log(x[good]), np.log(y[good]), 1)[0])


def own_limit(solutions, reference):
    """The solution a family of refinements tends to, and its order, from u(h) = u_0 + a h^p by least squares over all
    sample points; p is searched. u_0 is drawn towards the reference by a tenth of the finest mesh's weight: where the
    meshes do not tell p and u_0 apart, that decides. Needs three resolutions. Returns p (infinite where nothing changes
    with h) and u_0."""
    spacings = sorted(solutions, reverse=True)
    if len(spacings) < 3:
        return math.nan, None
    u = np.array([solutions[h] for h in spacings])
    size = np.linalg.norm(reference)
    if np.linalg.norm(u - u[-1], axis=1).max() < 1e-4 * size:
        return math.inf, u[-1]
    h = np.array(spacings)
    weight = (h / h[-1])[:, None] ** -2.0  # the finest meshes say most about the limit
    best = (math.inf, math.nan, None)
    for p in np.arange(0.3, 4.01, 0.02):
        basis = np.stack([np.ones(len(h)), (h / h[0]) ** p], axis=1) * weight
        basis = np.vstack([basis, [[0.1, 0.0]]])
        wanted = np.vstack([u * weight, 0.1 * reference[None]])
        solution, *_ = np.linalg.lstsq(basis, wanted, rcond=None)
        rest = np.linalg.norm(basis @ solution - wanted)
        if rest < best[0]:
            best = (rest, float(p), solution[0])
    return best[1], best[2]


def sample_solutions(rows):
    """{(case, level, method): ({spacing: u of all samples}, reference)} of the runs in the samples file. Of several
    backends and steps the first double-precision one counts: they differ by far less than the resolutions do."""
    solutions = {}
    for (case, level, method, _, spacing, _, _), points in groups(
            rows, "case", "level", "method", "n", "spacing", "step_share", "backend").items():
        of_method, _ = solutions.setdefault((case, level, method), ({}, None))
        h = float(spacing)
        if h in of_method:
            continue
        of_method[h] = np.array([[number(p, k) for k in ("ux", "uy", "uz")] for p in points]).ravel()
        reference = np.array([[number(p, k) for k in ("rx", "ry", "rz")] for p in points]).ravel()
        solutions[(case, level, method)] = (of_method, reference)
    return solutions
