# SPDX-License-Identifier: MIT
"""Draws phymul as measured beside SOFA as quoted: draw_peers.py FOLDER. See bench/charts.sh."""
import glob
import math
import os
import sys

import chart_data as data
import chart_style as style
from chart_data import number
from chart_style import plt

QUOTED = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "reference", "peers", "sofa_quoted.csv")
SOFA = {  # setting: colour, marker
    "large, 10 ms, 25 iterations": ("#0072B2", "s"),
    "direct solver, 10 ms": ("#999999", "X"),
    "fast, 1 ms, 25 iterations": ("#009E73", "^"),
    "fast, 10 ms, to 1e-2": ("#CC79A7", "D"),
    "fast, 10 ms, 25 iterations": ("#E69F00", "o"),
    "fast, 20 ms, 25 iterations": ("#56B4E9", "v"),
}
THEN = {"default, 0.9 of the limit": ("#D55E00", "*")}  # ours in the run that is quoted: what the machines differ by
METHOD, MARKER = "particle_averaged", "*"
SHARES = {0.5: "none", 0.9: "full"}


def points_of(measured, title, method, share):
    """(particles, cost, error) of phymul: the least cost of all rounds. The rest shape is the same for all steps; its
    error is NaN where none of them came to rest."""
    points = []
    rows = sorted((r for r in measured if (r["title"], r["method"]) == (title, method)), key=lambda r: int(r["particles"]))
    for (particles,), line in data.groups(rows, "particles").items():
        errors = [100 * number(r, "error") for r in line if r["status"] == "ok"]
        costs = [number(r, "cpu_per_s") for r in line if number(r, "step_share") == share and r["cpu_per_s"]]
        points.append((int(particles), min(costs, default=math.nan), errors[0] if errors else math.nan))
    return points


def lines_of(measured, quoted, body):
    """[(label, looks, points)]: ours, then what is quoted."""
    lines = []
    title = next(r["title"] for r in measured if body in r["title"].lower())
    for share, fill in SHARES.items():
        looks = {**style.style_of(METHOD), "linestyle": "-", "marker": MARKER, "fillstyle": fill}
        lines.append((f"phymul, {share} of the limit, measured", looks, points_of(measured, title, METHOD, share)))
    for setting, (colour, marker) in {**THEN, **SOFA}.items():
        rows = [r for r in quoted if (r["body"], r["setting"]) == (body, setting)]
        if rows:
            looks = {"color": colour, "marker": marker, "linestyle": (0, (3, 2)), "linewidth": 1.3, "markersize": 5.5}
            points = [(int(r["particles"]), number(r, "cpu_per_s"), number(r, "error_percent")) for r in rows]
            lines.append((f"{rows[0]['engine']}, {setting}, quoted", looks, points))
    return lines


def table(all_lines, quoted):
    """Markdown: a row a body."""
    yield "| particles | phymul: error, cost at 0.5 / 0.9 of the limit | SOFA: error | " + " | ".join(SOFA) + " |"
    yield "|---" * (3 + len(SOFA)) + "|"
    for body, lines in all_lines.items():
        for ours in zip(*(points for _, _, points in lines[:2])):
            theirs = {r["setting"]: r for r in quoted
                      if (r["body"], r["particles"], r["engine"]) == (body, str(ours[0][0]), "SOFA")}
            errors = ["-" if math.isnan(error) else f"{error:.2g} %" for _, _, error in ours]
            their_error = next((r["error_percent"] + " %" for r in theirs.values() if r["error_percent"]), "-")
            cells = [f"{body}, {ours[0][0]:,}", f"{errors[0]}, {ours[0][1]:.2g} / {ours[1][1]:.2g}", their_error]
            yield "| " + " | ".join(cells + [theirs[s]["cpu_per_s"] if s in theirs else "-" for s in SOFA]) + " |"


def main(out):
    measured, about = [], {}
    for path in sorted(glob.glob(f"{out}/peers_*.csv")):
        rows, about = data.read(path)
        measured += rows
    quoted, _ = data.read(QUOTED)
    all_lines = {body: lines_of(measured, quoted, body) for body in ("cantilever", "bean")
                 if any(body in r["title"].lower() for r in measured)}
    if not all_lines:
        sys.exit(f"{out}/peers_*.csv: expected rows to draw")
    figure, (cantilever, bean, size) = plt.subplots(1, 3, figsize=(13.5, 5.6))
    for axes, body in ((cantilever, "cantilever"), (bean, "bean")):
        for label, looks, points in all_lines.get(body, []):
            if "direct" not in label:
                axes.plot([cost for _, cost, _ in points], [error for _, _, error in points], label=label, **looks)
        axes.set(xscale="log", yscale="log", xlabel="seconds of processor per second of physics")
        axes.yaxis.set_major_formatter("{x:g}")
        style.guide(axes, x=1, text="real time on one core")
    for label, looks, points in all_lines.get("cantilever", []):
        size.plot([n for n, _, _ in points], [cost for _, cost, _ in points], label=label, **looks)
    bean.set_ylim(1, 50)
    bean.axhspan(1, 3.4, color="#bbbbbb", alpha=0.5, linewidth=0)
    style.guide(bean, y=3.4, text="the reference is known to this", below=True, linewidth=0)
    cantilever.set_ylabel("error of the displacement at rest, %")
    size.set(xscale="log", yscale="log", xlabel="particles", ylabel="seconds of processor per second of physics")
    style.guide(size, y=1, text="real time on one core", below=True)
    for axes, title in ((cantilever, "Cantilever under 0.1 of gravity, 425 to 10,388 particles"),
                        (bean, "Bean-shaped organ under gravity, 404 to 10,025"), (size, "Cantilever: cost over size")):
        axes.set_title(title, loc="left", fontsize=9, fontweight="bold")
    figure.legend(*size.get_legend_handles_labels(), fontsize=7.5, loc="lower center", bbox_to_anchor=(0.5, 0.03), ncol=4)
    figure.tight_layout(rect=(0, 0.14, 1, 1))
    style.finish(figure, out, "beside_sofa", data.caption(about) + " · quoted: another machine, see bench/reference/peers")
    with open(f"{out}/beside_sofa.md", "w", encoding="utf-8") as file:
        file.write("\n".join(table(all_lines, quoted)) + "\n")


if __name__ == "__main__":
    main(sys.argv[1])
