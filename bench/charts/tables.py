# SPDX-License-Identifier: MIT
"""Markdown tables from the rows of work_precision.csv."""
import math

import chart_data as data
import chart_names as names
from chart_data import number


def seconds(value):
    if value < 1e-3:
        return f"{1e6 * value:.0f} us"
    return f"{1e3 * value:.3g} ms" if value < 1 else f"{value:.3g} s"


def percent(value, digits):
    return "" if math.isnan(value) else f"{100 * value:.{digits}f} %"


def cheapest_table(rows):
    """The run that comes to rest soonest within each error."""
    bounds = (0.10, 0.05, 0.02, 0.01)
    text = "| case | " + " | ".join(f"error to {100 * b:.0f} %" for b in bounds) + " |\n|---|" + "---|" * len(bounds) + "\n"
    for of_level in data.groups(rows, "case", "level").values():
        cells = []
        error = data.error_column(of_level)
        for bound in bounds:
            good = [r for r in of_level if r["status"] == "ok" and number(r, error) <= bound and number(r, "wall_to_rest") > 0]
            if not good:
                cells.append("none")
                continue
            best = min(good, key=lambda r: number(r, "wall_to_rest"))
            way = best["backend"] if best["rest"] == "steps" else best["rest"]
            cells.append(f"{best['label']}, {best['particles']} particles, {way}: {seconds(number(best, 'wall_to_rest'))}"
                         f" ({100 * number(best, error):.2g} %{'' if error == 'error' else ' of the force'})")
        text += f"| {names.case_text(of_level[0])} | " + " | ".join(cells) + " |\n"
    return text


def moved_fronts_table(before, rows):
    """Where the fronts of `rows` and `before` differ at some error below 5 %: how much sooner `rows` comes to it, most at
    that error, least over all such errors of the front before."""
    of_before = data.groups(before, "case", "level")
    text = "| case | error | before | now | sooner | least |\n|---|---|---|---|---|---|\n"
    for key, of_level in data.groups(rows, "case", "level").items():
        error = data.error_column(of_level)
        old = data.front(of_before.get(key, []), "wall_to_rest", error)
        now = data.front(of_level, "wall_to_rest", error)
        ratios = [(data.time_at(old, e) / data.time_at(now, e), e) for _, e in old if e <= 0.05]
        most, at = max(ratios, default=(1.0, 0.0))
        least = min(ratios, default=(1.0, 0.0))[0]
        if most > 1.05 or least < 0.95:
            text += (f"| {names.case_text(of_level[0])} | {percent(at, 2)} | {seconds(data.time_at(old, at))} "
                     f"| {seconds(data.time_at(now, at))} | {most:.1f} | {f'{least:.1f}' if least > 0.0 else 'does not reach all'} |\n")
    return text


def accuracy_table(rows, orders, most_particles=4096):
    """The material at its finest resolution within the particles: its errors and orders."""
    text = "| case | particles | error | force error | null model | order, own limit | left in the limit |\n"
    text += "|---|---|---|---|---|---|---|\n"
    for (case, level), of_level in data.groups(rows, "case", "level").items():
        error = data.error_column(of_level)
        good = [r for r in of_level if r["status"] == "ok" and r["method"] == "particle_averaged"
                and int(r["particles"]) <= most_particles and not math.isnan(number(r, error))]
        if not good:
            text += f"| {names.case_text(of_level[0])} | none at rest | | | | | |\n"
            continue
        finest = max(int(r["particles"]) for r in good)
        best = min((r for r in good if int(r["particles"]) == finest), key=lambda r: number(r, error))
        order, floor, _ = orders.get((case, level, best["method"]), (math.nan, math.nan, math.nan))
        text += (f"| {names.case_text(best)} | {best['particles']} "
                 f"| {percent(number(best, 'error'), 2)} | {percent(number(best, 'force_error'), 2)} "
                 f"| {percent(number(best, 'null_error'), 1)} | {'at its limit' if math.isinf(order) else '' if math.isnan(order) else f'{order:.1f}'} | {percent(floor, 2)} |\n")
    return text
