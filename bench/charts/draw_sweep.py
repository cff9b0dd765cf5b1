# SPDX-License-Identifier: MIT
"""Draws the charts of docs/measurements/speed.md from the CSV file of bench/sweep: draw_sweep.py FILE FOLDER. See bench/sweep.sh."""
import argparse
import math

import chart_data as data
import chart_names as names
import chart_style as style
from chart_data import number
from chart_style import plt
from matplotlib.lines import Line2D

# The 2007 thesis, table 3.1: 275 particles, microseconds a step.
THESIS = {"thesis 2007, CPU": (275, 270e-6, "x"), "thesis 2007, GPU": (275, 314e-6, "+")}
COLOURS = {"reference": "#000000", "cpu": "#0072B2", "gl": "#D55E00", "gl-compute": "#009E73"}
MARKERS = {"reference": "o", "cpu": "s", "gl": "^", "gl-compute": "D"}


def label_of(row):
    threads = int(row["threads"])
    if row["backend"].startswith("cpu"):
        return f"{row['backend']}, {threads} thread{'s' if threads > 1 else ''}"
    return row["backend"]


def style_of(label):
    backend = label.split(",")[0].split(" ")[0]
    several = ", " in label and not label.endswith("1 thread")
    software = "software" in label
    return {"color": COLOURS.get(backend, "#999999"), "marker": MARKERS.get(backend, "v"), "markersize": 4.5,
            "linestyle": ":" if software else "--" if several else "-", "linewidth": 1.3,
            "markerfacecolor": "white" if software or several else None}


def draw(rows, about, out, name, title, value, label, scale="log"):
    """A panel a model; value(row) over particles, one line a backend, bars from the least to the greatest."""
    panels = data.groups(rows, "variant")
    across = min(4, len(panels))
    down = math.ceil((len(panels) + 1) / across)  # one more, for the legend
    figure, grid = plt.subplots(down, across, figsize=(3.1 * across, 0.9 + 2.5 * down), sharex=True, sharey=True,
                                squeeze=False)
    cells = list(grid.flat)
    labels = {}
    for axes, ((variant,), of_variant) in zip(cells, panels.items()):
        lines = {}
        for row in of_variant:
            if row["status"] == "ok":
                lines.setdefault(label_of(row), []).append(row)
        for line, points in lines.items():
            looks = style_of(line)
            n = [number(r, "particles") for r in points]
            time = "cpu_s" if points[0]["threads"] == "1" else "s"
            middle, low, high = ([value(r, number(r, f"{time}_{k}")) for r in points]
                                 for k in ("per_step", "least", "greatest"))
            bars = [[abs(m - min(a, b)) for m, a, b in zip(middle, low, high)],
                    [abs(max(a, b) - m) for m, a, b in zip(middle, low, high)]]
            axes.errorbar(n, middle, yerr=bars, elinewidth=0.6, capsize=1.5, **looks)
            labels[line] = Line2D([], [], **looks)
        for line, (n, seconds, marker) in THESIS.items() if "275" in {r["particles"] for r in of_variant} else ():
            looks = {"color": "#CC79A7", "marker": marker, "markersize": 7, "markeredgewidth": 1.6, "linestyle": "none"}
            axes.plot([n], [value({"particles": str(n)}, seconds)], **looks)
            labels[line] = Line2D([], [], **looks)
        axes.set(xscale="log", yscale=scale)
        axes.set_title(names.SWEEP_VARIANTS.get(variant, variant), fontsize=8.5, loc="left")
    for axes in cells[len(panels):]:
        axes.axis("off")
    cells[len(panels)].legend(labels.values(), labels.keys(), loc="center left", fontsize=8)
    for row_axes in grid:
        row_axes[0].set_ylabel(label)
    for k, axes in enumerate(cells[:len(panels)]):
        if k + across >= len(panels):
            axes.set_xlabel("particles")
            axes.tick_params(labelbottom=True)
    figure.suptitle(title, x=0.01, ha="left", fontsize=11, fontweight="bold")
    figure.tight_layout(rect=(0, 0.03, 1, 0.98))
    loads = [number(r, "load") for r in rows if r["load"]]
    foot = f"{data.caption(about)} · load {min(loads):.1f} to {max(loads):.1f} (1 is quiet) · one thread: processor time, others: wall clock; median, least, greatest" if loads else ""
    style.finish(figure, out, name, foot)


def left_out(rows, path):
    """What is not in the charts, and why, for who reads them."""
    lines = [f"- {names.SWEEP_VARIANTS.get(r['variant'], r['variant'])}, {int(r['particles']):,} particles"
             f"{', ' + r['backend'] if r['backend'] else ''}: {r['status']}" for r in rows if r["status"] != "ok"]
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + ("\n" if lines else ""))


def main(file, out):
    rows, about = data.read(file)
    draw(rows, about, out, "speed_rate", "Particle-steps a second, by model and backend, over the number of particles",
         lambda r, s: number(r, "particles") / s, "particle-steps / s")
    draw(rows, about, out, "speed_step", "Time of a step, by model and backend, over the number of particles", lambda r, s: s, "s")
    draw(rows, about, out, "speed_cost", "Cost of a particle-step, by model and backend, over the number of particles",
         lambda r, s: 1e9 * s / number(r, "particles"), "ns")
    left_out(rows, f"{out}/speed_left_out.md")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Draws the charts of docs/measurements/speed.md; bench/sweep.sh measures them.")
    parser.add_argument("file", help="the CSV file of bench/sweep")
    parser.add_argument("folder", help="where the charts go")
    given = parser.parse_args()
    main(given.file, given.folder)
