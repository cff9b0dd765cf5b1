# SPDX-License-Identifier: MIT
"""Draws the pictures of docs/measurements/truth.md and writes the page: draw_truth.py IN PICTURES PAGE.
See bench/truth.sh."""
import argparse
import math
import os
import re
import textwrap

import chart_data as data
import chart_style as style
from chart_data import number
from chart_style import plt
from truth_text import CASES, FIRST, HEADS, LAST

INK = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"]


def error(row):
    """Ours over the mean of what is known, less 1; NaN where nothing is known."""
    known = (number(row, "low") + number(row, "high")) / 2
    return number(row, "ours") / known - 1 if known else math.nan


def spread(row):
    """Half the width of what is known beside its mean."""
    known = (number(row, "low") + number(row, "high")) / 2
    return abs(number(row, "high") - number(row, "low")) / 2 / abs(known) if known else math.nan


def percent(share, sign="+"):
    return "" if math.isnan(share) else f"{100 * share:{sign}.2f} %" if abs(share) < 0.1 else f"{100 * share:{sign}.0f} %"


def wrapped(text):
    """Paragraphs in lines of 120 columns."""
    return "\n\n".join(p if p.startswith("#") else textwrap.fill(" ".join(p.split()), 120, break_long_words=False,
                                                                  break_on_hyphens=False) for p in text.strip().split("\n\n"))


class Rows:
    def __init__(self, rows):
        self.all = rows
        self.by = {(r["case"], r["quantity"], r["mesh"]): r for r in rows}

    def of(self, case, quantity, mesh):
        if (case, quantity, mesh) not in self.by:
            raise SystemExit(f"draw_truth.py: no row of {case}; {quantity}; {mesh}: was bench/truth.sh cut short?")
        return self.by[case, quantity, mesh]

    def series(self, case, quantity, mesh):
        """Rows of the same quantity and kind of body, step 0.90, by particles: mesh convergence."""
        kind = re.sub(r"\d+( across| a side| x \d+)", "", mesh)
        return sorted((r for r in self.all if r["case"] == case and r["quantity"] == quantity
                       and re.sub(r"\d+( across| a side| x \d+)", "", r["mesh"]) == kind), key=lambda r: int(r["particles"]))

    def mesh_change(self, row):
        """From this mesh to the finest one; where this is the finest, from the one before it."""
        line = self.series(row["case"], row["quantity"], row["mesh"])
        if len(line) < 2:
            return math.nan
        before, after = (row, line[-1]) if line[-1] is not row else (line[-2], row)
        return number(after, "ours") / number(before, "ours") - 1

    def step_change(self, row):
        """From 0.90 to 0.45 of the stable step."""
        half = self.by.get((row["case"], row["quantity"], re.sub("step 0.90", "step 0.45", row["mesh"])))
        return number(half, "ours") / number(row, "ours") - 1 if half is not None and half is not row else math.nan


def summary(rows):
    lines = ["| | case | known | ours | error | particles | mesh | step | of the known | asked | |", "|" + "---|" * 11]
    for letter, case, quantity, mesh, words, asked in HEADS:
        row = rows.of(case, quantity, mesh)
        low, high, off = number(row, "low"), number(row, "high"), error(row)
        known = f"{low:.4g}" if low == high else f"{low:.5g} to {high:.5g}"
        verdict = "" if asked is None else "met" if abs(off) <= asked / 100 else "**missed**"
        if case == "roll-up":
            known, ours = "0", f"{number(row, 'ours') - 1:.4f}"
        else:
            ours = f"{number(row, 'ours'):.4g}"
        lines.append(f"| {letter} | {words} | {known} | {ours} | {percent(off)} | {int(row['particles']):,} | "
                     f"{percent(rows.mesh_change(row))} | {percent(rows.step_change(row))} | {'' if low == high else percent(spread(row), '')} | "
                     f"{'' if asked is None else f'{asked:g} %'} | {verdict} |")
    return "\n".join(lines)


def table(rows, case, wanted):
    """All rows of some quantities: a line a quantity and mesh."""
    lines = ["| | body | particles | known | ours | error |", "|---|---|---|---|---|---|"]
    for row in rows.all:
        if row["case"] != case or not re.fullmatch(wanted, row["quantity"]):
            continue
        low, high = number(row, "low"), number(row, "high")
        known = "" if math.isnan(low) else f"{low:.5g}" if low == high else f"{low:.5g} to {high:.5g}"
        off = "" if math.isnan(low) or abs(low + high) < 1e-6 else percent(error(row))
        lines.append(f"| {row['quantity']} | {row['mesh']} | {int(row['particles']):,} | {known} | {number(row, 'ours'):.5g} | {off} |")
    return "\n".join(lines)


def draw_beam(rows, curves, out, foot):
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3.6))
    loads = ["0", "0.51012", "1.0006"]
    for k, where in enumerate(("top mark", "left mark", "right mark")):
        found = [rows.of("beam", f"{load} N mark {k + 1}", "nu 0.490, 6 across") for load in loads]
        x = [float(load) + 0.012 * (k - 1) for load in loads]
        middle = [(number(r, "low") + number(r, "high")) / 2 for r in found]
        left.errorbar(x, middle, yerr=[(number(r, "high") - number(r, "low")) / 2 for r in found], fmt="o", color=INK[k],
                      markersize=3, capsize=4, linewidth=1.2, label=f"{where}, two recordings")
        left.plot(x, [number(r, "ours") for r in found], "-", color=INK[k], linewidth=1.0, label=f"{where}, ours")
    left.set(xlabel="load, N", ylabel="vertical displacement, mm", title="At rest; E fitted at 1.0 N to the top mark")
    left.legend(fontsize=7, loc="upper right")
    for k, ((law,), points) in enumerate(data.groups([c for c in curves if c["case"] == "beam period"], "curve").items()):
        right.plot([number(p, "x") for p in points], [number(p, "y") for p in points], color=INK[k], linewidth=1.0, label=law)
    right.set(xlabel="s", ylabel="top mark, mm", title="Released under gravity, 1,029 particles")
    right.legend(fontsize=7, loc="upper right")
    figure.tight_layout(rect=(0, 0.03, 1, 1))
    style.finish(figure, out, "truth_beam", foot)


def draw_brain(rows, out, foot):
    figure, panels = plt.subplots(1, 3, figsize=(9.5, 3.3))
    for axes, branch in zip(panels, ("compression", "tension", "shear")):
        for k, (fit, label) in enumerate((("fit of all", "neo-Hookean, fitted to all"),
                                          (f"fit of {branch}", "neo-Hookean, fitted to this branch alone"),
                                          ("all constants", "stiffening, fitted to all"))):
            found = [r for r in rows.all if r["case"] == "brain" and r["mesh"] == fit and r["quantity"].startswith(branch)]
            x = [float(r["quantity"].split()[1]) for r in found]
            axes.plot(x, [number(r, "ours") for r in found], "-s", markersize=3, color=INK[k], linewidth=1.1, label=label)
        axes.plot(x, [number(r, "low") for r in found], "o", color="#000000", markersize=5, label="measured")
        axes.set(title=branch, xlabel="amount of shear" if branch == "shear" else "stretch")
    panels[0].set_ylabel("nominal stress, kPa")
    panels[1].legend(fontsize=7)
    figure.tight_layout(rect=(0, 0.03, 1, 1))
    style.finish(figure, out, "truth_brain", foot)


def draw_convergence(rows, out, foot):
    figure, axes = plt.subplots(figsize=(7.5, 5.0))
    shown = {}  # a line a quantity and kind of body
    for letter, case, quantity, mesh, words, _ in HEADS:
        if letter in "CDEF" and "nu 0.45" not in quantity:
            shown.setdefault(tuple(map(id, rows.series(case, quantity, mesh))), (letter, case, quantity, mesh, words))
    for k, (letter, case, quantity, mesh, words) in enumerate(shown.values()):
        line = [r for r in rows.series(case, quantity, mesh) if abs(error(r)) > 1e-5]
        axes.plot([int(r["particles"]) for r in line], [100 * abs(error(r)) for r in line], color=INK[k % len(INK)],
                  marker=style.MARKERS[k % len(style.MARKERS)], markersize=5, linewidth=1.1, linestyle="-" if k < 7 else "--",
                  label=f"{letter} {words.split(', ')[0] if case != 'cook finite' else words.removesuffix(', mm')}")
    for level in (1, 2):
        axes.axhline(level, color="#999999", linewidth=0.8, linestyle=":")
    axes.set(xscale="log", yscale="log", xlabel="particles", ylabel="error, %", title="Error over the number of particles")
    axes.legend(fontsize=6.5, loc="center left", bbox_to_anchor=(1.0, 0.5))
    figure.tight_layout(rect=(0, 0.03, 1, 1))
    style.finish(figure, out, "truth_convergence", foot)


def draw_shapes(rows, curves, out, foot):
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3.8))
    strips = data.groups([c for c in curves if c["case"] == "roll-up"], "curve")
    for k, ((at,), points) in enumerate(strips.items()):
        t = float(at.split()[1]) * math.pi
        left.plot([number(p, "x") for p in points], [number(p, "y") for p in points], color=INK[k], linewidth=2.2, alpha=0.5,
                  label=f"ours, turned by {t / math.pi:g} pi")
        s = [j / 100 * t for j in range(101)]
        left.plot([math.sin(a) / t for a in s], [(1 - math.cos(a)) / t for a in s], color="#000000", linewidth=0.8)
    left.set(aspect="equal", xlabel="x / L", ylabel="z / L", title="Roll-up, 4 across; black: theory")
    left.legend(fontsize=7)
    cube = data.groups([c for c in curves if c["case"] == "truth cube"], "curve")
    for k, ((mesh,), points) in enumerate(cube.items()):
        right.plot([number(p, "x") for p in points], [number(p, "y") for p in points], color=INK[k], linewidth=1.2, label=mesh)
    right.set(xlabel="depth of the ball, mm", ylabel="force, N, of E = 10 kPa", title="Truth Cube: ball of 25.4 mm in a cube of 80 mm")
    right.legend(fontsize=7)
    figure.tight_layout(rect=(0, 0.03, 1, 1))
    style.finish(figure, out, "truth_shapes", foot)


def main(folder, pictures, page):
    found, about = data.read(f"{folder}/truth.csv")
    curves, _ = data.read(f"{folder}/truth_curves.csv")
    rows, foot = Rows(found), data.caption(about)
    os.makedirs(pictures, exist_ok=True)
    draw_beam(rows, curves, pictures, foot)
    draw_brain(rows, pictures, foot)
    draw_convergence(rows, pictures, foot)
    draw_shapes(rows, curves, pictures, foot)
    for name in ("beam", "brain", "convergence", "shapes"):  # the page shows the other kind
        os.remove(f"{pictures}/truth_{name}.svg")
    below = os.path.relpath(pictures, os.path.dirname(page))

    def value(match):
        """{case; quantity; mesh} is our value there, {%case; ...} its error, {~case; ...} the change to the finest mesh."""
        kind, case, quantity, mesh = re.fullmatch(
            r"\{([%~]?)([^;]*); ([^;]*); ([^;]*)\}", " ".join(match.group(0).split())).groups()  # lines may be broken
        row = rows.of(case, quantity, mesh)
        return percent(error(row)) if kind == "%" else percent(rows.mesh_change(row)) if kind == "~" else f"{number(row, 'ours'):.4g}"

    parts = [wrapped(FIRST.replace("CAPTION", foot)), summary(rows)]
    for title, picture, text, case, wanted in CASES:
        parts.append(f"## {title}")
        if picture:
            parts.append(f"![{title}]({below}/{picture}.png)")
        parts.append(wrapped(re.sub(r"\{[^{}]*\}", value, text)))
        if wanted:
            parts.append(table(rows, case, wanted))
    parts.append(LAST)
    with open(page, "w", encoding="utf-8") as file:
        file.write("\n\n".join(part.strip() for part in parts) + "\n")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="draw_truth.py draws the pictures of docs/measurements/truth.md and writes the page; bench/truth.sh measures.")
    parser.add_argument("folder", help="with truth.csv and truth_curves.csv of bench/truth")
    parser.add_argument("pictures", help="folder where the pictures go")
    parser.add_argument("page", help="the page to write")
    given = parser.parse_args()
    main(given.folder, given.pictures, given.page)
