# SPDX-License-Identifier: MIT
"""Draws the stability atlas from the CSV files of a folder: draw_stability.py FOLDER. See bench/charts.sh."""
import argparse
import math
import sys

import chart_data as data
import chart_names as names
import chart_style as style
from chart_data import number
from chart_style import plt

QUESTIONS = {
    "stiffness": ("Step limit over the stiffness of one half of a cube", "stiffness of the half over that of the other"),
    "mass": ("Step limit over the mass of every second particle", "mass of every second particle over its own"),
    "valence": ("Step limit over the number of neighbours", "neighbours inside the lattice"),
    "damping": ("Step limit over the damping factor", "1 - d, d the factor of velocity a step"),
}
# How a start ended: marker, filled.
VERDICTS = {"returned": ("o", True), "rests collapsed": ("s", False), "rests folded": ("D", False),
            "rests elsewhere": ("P", True), "moves": ("o", False), "ran away": ("x", True)}


def key_of(method):
    """The name that chart_style knows, of "springs 18, volume" or "material, nu 0.45"."""
    if ", nu" in method:
        return "particle_averaged"
    return method.replace(", ", "_").replace(" ", "_")


def limits(out, rows, about):
    for (question,), of_question in data.groups(rows, "question").items():
        title, label = QUESTIONS[question]
        materials = [r for r in of_question if "nu 0" in r["method"]]
        others = [r for r in of_question if "nu 0" not in r["method"]]
        panels = [panel for panel in (("Stiffness given, N/m", others), ("Stiffness by E and Poisson's ratio", materials)) if panel[1]]
        figure, grid = plt.subplots(1, len(panels), figsize=(5.4 * len(panels), 4.4), sharey=True, squeeze=False)
        for axes, (name, of_panel) in zip(grid[0], panels):
            for (method,), line in data.groups(of_panel, "method").items():
                x = [1 - number(r, "value") if question == "damping" else number(r, "value") for r in line]
                unit = [number(r, "unit") for r in line]
                looks = style.style_of(key_of(method))
                if "0.45" in method:
                    looks["markerfacecolor"] = "white"
                marker = {k: looks.pop(k) for k in ("marker", "markersize", "markerfacecolor") if k in looks}
                found = [number(r, "found") / u for r, u in zip(line, unit)]
                grows = all(math.isnan(f) for f in found)
                axes.plot(x, [number(r, "predicted") / u for r, u in zip(line, unit)], **looks)
                axes.plot(x, found, color=looks["color"], linestyle="none", **marker)
                axes.plot([], [], label=names.stability_text(method) + (" (grows at any step)" if grows else ""), **looks, **marker)
            axes.set(xlabel=label)
            if question in ("stiffness", "mass"):
                axes.set(xscale="log", yscale="log")
            elif question == "damping":
                axes.set_xscale("symlog", linthresh=0.01)
                axes.set_xlim(-0.002, 1.3)
            axes.set_title(name, loc="left", fontsize=9)
            axes.legend(fontsize=6.5)
        if question in ("valence", "damping"):
            grid[0][0].set_ylim(bottom=0)
        grid[0][0].set_ylabel("limit of dt, in times of a wave across a spacing\nline: predicted, mark: found by bisection")
        figure.suptitle(title, x=0.01, ha="left", fontsize=10, fontweight="bold")
        figure.tight_layout(rect=(0, 0.025, 1, 1))
        style.finish(figure, out, f"stability_limit_{question}", data.caption(about))


def recovery(out, rows, about):
    states = list(dict.fromkeys(r["state"] for r in rows))
    lines = list(data.groups(rows, "method", "backend").items())
    several = len({backend for (_, backend), _ in lines}) > 1
    figure, axes = plt.subplots(figsize=(9.5, 1.9 + 0.27 * len(lines)))
    labels = []
    for y, ((method, backend), of_line) in enumerate(lines):
        for row in of_line:
            marker, filled = VERDICTS[row["verdict"]]
            axes.plot(states.index(row["state"]), y, marker=marker, color="black", markersize=6, linestyle="none",
                      markerfacecolor="black" if filled else "white", markeredgecolor="black" if row["verdict"] == "returned" else "#666666")
        worst = [number(r, "distance") for r in of_line if r["verdict"] == "returned"]
        count = f"{len(worst)} of {len(of_line)}"
        labels.append(f"{names.stability_text(method)}{', ' + backend if several else ''}   {count}")
    for verdict, (marker, filled) in VERDICTS.items():
        axes.plot([], [], marker=marker, color="black", linestyle="none", label=verdict,
                  markerfacecolor="black" if filled else "white")
    axes.set_yticks(range(len(lines)), labels, fontsize=7.5)
    axes.set_xticks(range(len(states)), states, rotation=40, ha="right", fontsize=7.5)
    axes.invert_yaxis()
    axes.set_title("What becomes of a cube that starts broken", loc="left", fontsize=10, fontweight="bold")
    axes.legend(fontsize=7, ncols=6, loc="lower left", bbox_to_anchor=(-0.02, 1.06), columnspacing=1)
    figure.tight_layout(rect=(0, 0.025, 1, 1))
    share = rows[0]["step_share"]
    style.finish(figure, out, "stability_recovery", f"{share} of the step limit, d = 0.99 · {data.caption(about)}")


def recovery_table(rows):
    """Which states a method returns from, and to what error, as Markdown."""
    text = "| method | backend | returns from | largest distance then | others |\n|---|---|---|---|---|\n"
    for (method, backend), of_line in data.groups(rows, "method", "backend").items():
        back = [r for r in of_line if r["verdict"] == "returned"]
        worst = max((number(r, "distance") for r in back), default=math.nan)
        others = "; ".join(f"{verdict}: {', '.join(r['state'].replace(', ', ' ') for r in some)}" for (verdict,), some in
                           data.groups([r for r in of_line if r["verdict"] != "returned"], "verdict").items())
        text += f"| {names.stability_text(method)} | {backend} | {len(back)} of {len(of_line)} | {'' if math.isnan(worst) else f'{worst:.1g}'} | {others} |\n"
    return text


def rates_table(rows):
    text = "| body | " + " | ".join(reaction for (reaction,), _ in data.groups(rows, "reaction").items()) + " |\n"
    text += "|---" * (1 + len(data.groups(rows, "reaction"))) + "|\n"
    for (body, particles), of_body in data.groups(rows, "body", "particles").items():
        cells = []
        for row in of_body:
            highest, rate = number(row, "highest"), number(row, "predicted")
            cells.append("none" if rate == 0 else f"{rate / highest:.2g} ({number(row, 'measured') / rate:.4f})")
        text += f"| {body}, {particles} particles | " + " | ".join(cells) + " |\n"
    return text


def main(out):
    rows, about = data.read(f"{out}/stability_limits.csv")
    starts, about_starts = data.read(f"{out}/stability_recovery.csv")
    rates, _ = data.read(f"{out}/stability_rates.csv")
    if not rows or not starts or not rates:
        sys.exit(f"{out}: expected stability_limits.csv, stability_recovery.csv and stability_rates.csv")
    limits(out, rows, about)
    recovery(out, starts, about_starts)
    with open(f"{out}/stability_tables.md", "w", encoding="utf-8") as file:
        file.write(rates_table(rates) + "\n" + recovery_table(starts))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Draws the stability atlas from the CSV files of a folder; bench/charts.sh makes them.")
    parser.add_argument("folder", help="where the CSV files are, and the charts go")
    main(parser.parse_args().folder)
