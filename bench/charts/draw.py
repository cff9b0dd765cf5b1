# SPDX-License-Identifier: MIT
"""Draws every chart and table from the CSV files of a folder: draw.py FOLDER. See bench/charts.sh."""
import argparse
import math
import os
import sys

import chart_data as data
import chart_names as names
import chart_style as style
import numpy as np
from chart_data import number
from chart_style import plt
from tables import accuracy_table, cheapest_table, moved_fronts_table


def draw_front(axes, rows, before, time, error):
    """One line a method and way to rest through its resolutions; the front over all of them in bold, that of `before`, or
    without it that of steps alone, dashed."""
    failed = []
    for (method, label, way), of_method in data.groups(rows, "method", "label", "rest").items():
        by_steps = way == "steps"
        if not by_steps and time != "wall_to_rest":
            continue
        line = data.cheapest_by_resolution(of_method, time, error)
        text = label if by_steps else f"{label}, {way}"
        if not line:
            failed.append(f"{text}: {', '.join(sorted({row['status'] for row in of_method}))}")
            continue
        looks = style.style_of(method)
        if not by_steps:
            looks["fillstyle"] = "none"
        axes.plot([number(r, time) for r in line], [number(r, error) for r in line], label=text, **looks)
    other = data.front(before or [row for row in rows if row["rest"] == "steps"], time, error)
    if len(other) > 1:
        axes.plot(*zip(*other), color="black", linewidth=2, alpha=0.5, linestyle=(0, (3, 2)), zorder=1,
                  label="Pareto front before" if before else "Pareto front of steps")
    front = data.front(rows, time, error)
    if len(front) > 1 and front != other:
        axes.plot(*zip(*front), color="black", linewidth=5, alpha=0.18, solid_capstyle="round", zorder=1,
                  label="Pareto front")
    return failed


def work_precision(out, rows, before, about):
    before = data.groups(before, "case", "level")
    for (case,), of_case in data.groups(rows, "case").items():
        levels = list(data.groups(of_case, "level").items())
        error = data.error_column(of_case)
        figure, grid = plt.subplots(len(levels), 2, figsize=(10.5, 1.2 + 3.3 * len(levels)), sharey="row", squeeze=False)
        for (level, of_level), row_axes in zip(levels, grid):
            null = number(of_level[0], "null_error")
            floor = max(number(r, "floor" if error == "error" else "force_floor") for r in of_level)
            errors = [number(r, error) for r in of_level if r["status"] == "ok" and r[error]]
            highest = max(errors + ([] if math.isnan(null) else [null]), default=1.0)
            for axes, time in zip(row_axes, ("wall_per_s", "wall_to_rest")):
                failed = draw_front(axes, of_level, before.get((case, level[0]), []), time, error)
                axes.set(xscale="log", yscale="log")
                axes.set_ylim(max(min([floor, *errors]) / 2, 1e-5), min(1.5 * highest, 20))
                axes.axhspan(axes.get_ylim()[0], floor, color="#bbbbbb", alpha=0.5, linewidth=0)
                style.guide(axes, y=floor, text="error of the reference", below=True, linewidth=0)
                if not math.isnan(null):
                    style.guide(axes, y=null, text="null model", linestyle=":", linewidth=1.6)
                axes.margins(x=0.08)
            style.guide(row_axes[0], x=1.0, text="real time")
            style.guide(row_axes[1], x=1e-3, text="one 1 kHz frame")
            style.guide(row_axes[1], x=1.0, text="1 s", linestyle="--")
            quantity = "displacement error |u - u_ref| / |u_ref|" if error == "error" else "force error |R - R_ref| / |R_ref|"
            row_axes[0].set_ylabel(f"{names.level_text(level[0])}\n{quantity}")
            if failed:
                note = row_axes[0].annotate("not drawn: " + "; ".join(failed), (0.0, 1.015), xycoords="axes fraction",
                                            fontsize=6, color="#555555", ha="left", annotation_clip=False)
                note.set_in_layout(False)
        grid[-1][0].set_xlabel("measured seconds per simulated second")
        grid[-1][1].set_xlabel("measured seconds to rest")
        handles = {}
        for axes in grid.flat:
            handles.update({label: handle for handle, label in zip(*axes.get_legend_handles_labels())})
        figure.legend(handles.values(), handles.keys(), loc="center right", fontsize=8)
        figure.suptitle(of_case[0]["title"], x=0.01, ha="left", fontsize=11, fontweight="bold")
        figure.tight_layout(rect=(0, 0.02, 0.78, 0.99))
        backends = ", ".join(sorted({row["backend"] for row in of_case}))
        style.finish(figure, out, f"work_precision_{case}", data.caption(about) + f" · fastest of: {backends}")


def convergence(out, rows, samples, about):
    """Distance from the reference against spacing; the order is that towards the method's own limit, because a finite
    strain has a floor where the two material laws differ."""
    solutions = data.sample_solutions(samples)
    wanted = ["particle_averaged", "springs_18"]
    labels = {row["method"]: row["label"] for row in rows}
    resolved = [r for r in rows if r["status"] == "ok" and r["method"] in wanted and r["error"]]
    panels = {key: of_panel for key, of_panel in data.groups(resolved, "case", "level").items()
              if len({r["n"] for r in of_panel}) > 1}
    if not panels:
        return {}
    columns = 4
    figure, grid = plt.subplots(math.ceil(len(panels) / columns), columns, figsize=(12.5, 3.0 * math.ceil(len(panels) / columns)),
                                squeeze=False)
    orders = {}
    for (case, level), axes in zip(panels, grid.flat):
        for method in wanted:
            line = data.cheapest_by_resolution([r for r in panels[(case, level)] if r["method"] == method], "wall_to_rest")
            if len(line) < 2:
                continue
            h = [1e3 * number(r, "spacing") for r in line]
            of_method, reference = solutions.get((case, level, method), ({}, None))
            order, limit = data.own_limit(of_method, reference)
            text = ""
            if limit is not None:
                floor = float(np.linalg.norm(limit - reference) / np.linalg.norm(reference))
                orders[(case, level, method)] = (order, floor, data.fitted_slope(h, [number(r, "error") for r in line]))
                text = ": at its limit" if math.isinf(order) else f": order {order:.1f}" if order > 0.32 else ": saturates"
            short = labels[method].replace(" neighbours", "")
            axes.plot(h, [number(r, "error") for r in line], label=short + text, **style.style_of(method))
        axes.set(xscale="log", yscale="log")
        low, high = axes.get_ylim()
        if high < 12 * low:  # a decade at least, so that slopes look alike
            axes.set_ylim(math.sqrt(low * high / 12), math.sqrt(low * high * 12))
        axes.set_title(names.panel_title(panels[(case, level)][0]), fontsize=8, loc="left")
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter("{x:g}")
        axes.tick_params(labelsize=7, which="both")
        axes.legend(fontsize=6)
    for axes in list(grid.flat)[len(panels):]:
        axes.set_visible(False)
    for axes in grid[:, 0]:
        axes.set_ylabel("displacement error", fontsize=8)
    for axes in grid[-1]:
        axes.set_xlabel("spacing, mm", fontsize=8)
    figure.suptitle("Error against the reference, over particle spacing; order of convergence to the method's own limit",
                    x=0.01, ha="left", fontsize=11, fontweight="bold")
    figure.tight_layout(rect=(0, 0.02, 1, 0.98))
    style.finish(figure, out, "convergence_spacing", data.caption(about))
    return orders


def order_in_time(out):
    rows, about = data.read(f"{out}/order_in_time.csv")
    if not rows:
        return
    figure, axes = plt.subplots(figsize=(6.5, 4.4))
    for (backend, method, label), line in data.groups(rows, "backend", "method", "label").items():
        x, y = [number(r, "share_of_limit") for r in line], [number(r, "error") for r in line]
        slope = data.fitted_slope(x, y)
        looks = style.style_of(method)
        if backend != "reference":
            looks["fillstyle"] = "none"
        axes.plot(x, y, label=f"{label}, {backend}: order {slope:.2f}", **looks)
    x = np.array([0.05, 0.8])
    axes.plot(x, 0.02 * x**2, color="#777777", linewidth=1, linestyle=":", label="order 2")
    axes.set(xscale="log", yscale="log", xlabel="dt over the stable step", ylabel="error of the displacements after 200 limits")
    axes.set_title("A beam let go, against a step a quarter of the finest here", loc="left", fontsize=10, fontweight="bold")
    axes.legend(fontsize=7)
    figure.tight_layout(rect=(0, 0.025, 1, 1))
    style.finish(figure, out, "convergence_time", data.caption(about))


def equivalence(out):
    rows, about = data.read(f"{out}/equivalence.csv")
    figure, axes = plt.subplots(figsize=(6.5, 4.4))
    for k, ((backend, method, label), line) in enumerate(data.groups(rows, "backend", "method", "label").items()):
        looks = style.style_of(method)
        looks["fillstyle"] = "none" if backend.startswith("gl") else "full"
        axes.plot([int(r["steps"]) for r in line], [max(number(r, "max_over_spacing"), 1e-17) for r in line],
                  label=f"{label}, {backend}", **looks)
    if not rows:
        axes.text(0.5, 0.5, "this build has one backend only: nothing to compare", ha="center", transform=axes.transAxes)
        axes.set(xlim=(1, 1e4), ylim=(1e-9, 1))
    axes.set(xscale="log", yscale="log", xlabel="steps, undamped, at half the stable step",
             ylabel="largest distance from the double-precision\nreference, in spacings")
    axes.set_title("Backends against the double-precision reference", loc="left", fontsize=10, fontweight="bold")
    if rows:
        axes.legend(fontsize=7)
    figure.tight_layout(rect=(0, 0.025, 1, 1))
    style.finish(figure, out, "equivalence", data.caption(about))


def cost(out, rows, about):
    """Time a step against particles, by backend."""
    figure, axes = plt.subplots(figsize=(6.5, 4.4))
    wanted = {"springs_18": "springs, 18", "particle_averaged": "material"}
    timed = [r for r in rows if r["method"] in wanted and number(r, "wall_step") > 0]
    backends = list(dict.fromkeys(r["backend"] for r in timed))
    for (backend, method), line in data.groups(timed, "backend", "method").items():
        least = {}
        for row in line:
            n = int(row["particles"])
            least[n] = min(number(row, "wall_step"), least.get(n, math.inf))
        looks = style.style_of(method)
        looks["fillstyle"] = ("full", "none", "left", "right")[backends.index(backend) % 4]
        axes.plot(sorted(least), [1e3 * least[n] for n in sorted(least)], label=f"{wanted[method]}, {backend}", **looks)
    axes.set(xscale="log", yscale="log", xlabel="particles", ylabel="milliseconds a step")
    style.guide(axes, y=1.0, text="1 kHz: one step a frame")
    axes.set_title("Cost of a step, bodies of all cases", loc="left", fontsize=10, fontweight="bold")
    axes.legend(fontsize=7)
    figure.tight_layout(rect=(0, 0.025, 1, 1))
    style.finish(figure, out, "cost", data.caption(about))


METHOD_OF_PEERS = {"spring": "springs", "spring_vol": "springs_volume", "corot": "corotated FEM", "neohook": "neo-Hookean FEM",
                   "fem": "FEM", "polar": "polar FEM", "large": "corotated FEM"}


def soft_cube(out, quoted_path):
    measured, about = data.read(f"{out}/soft_cube.csv")
    if not measured:
        return
    quoted, _ = data.read(quoted_path)
    for name, with_quoted in (("soft_cube_measured", False), ("soft_cube_quoted", True)):
        figure, grid = plt.subplots(1, 2, figsize=(11, 5.6 if with_quoted else 5.0), sharey=True)
        for axes, method, title in zip(grid, ("springs", "springs_volume"), ("springs", "springs and volume")):
            ours = data.groups([r for r in measured if r["method"] == method and r["status"] == "ok"], "engine")
            lines = [(engine, [(1e3 * number(r, "cpu"), number(r, "error")) for r in line], "-") for (engine,), line in ours.items()
                     if not with_quoted or engine.startswith("phymul")]
            if with_quoted:
                theirs = [r for r in quoted if METHOD_OF_PEERS.get(r["method"], "") == method and r["sweeps"] in ("1", "25")]
                for (engine,), line in data.groups(theirs, "engine").items():
                    points = [(number(r, "cpu_ms"), number(r, "error")) for r in line]
                    lines.append((engine + ", quoted", points, (0, (3, 2))))
            for k, (engine, points, dashes) in enumerate(lines):
                points = [p for p in sorted(points) if p[1] > 0]
                if points:
                    axes.plot(*zip(*points), label=engine, color=style.ENGINES[k % 8], marker=style.MARKERS[k % 10],
                              linestyle=dashes, linewidth=1.3, markersize=6)
            axes.set(xscale="log", yscale="log", xlabel="processor milliseconds for 100 ms of physics")
            style.guide(axes, x=100, text="real time")
            style.guide(axes, y=0.01, text="1 %", linestyle=":")
            axes.set_title(f"Soft cube, 1,000 particles, {title}", loc="left", fontsize=9, fontweight="bold")
        grid[0].set_ylabel("error of the positions after 0.1 s")
        foot = data.caption(about)
        if with_quoted:
            foot += " · quoted: one core of another machine, see bench/reference/peers"
        # The left panel has every engine, in the colours of the right one.
        figure.legend(*grid[0].get_legend_handles_labels(), fontsize=7, loc="lower center", bbox_to_anchor=(0.5, 0.03),
                      ncol=5, frameon=False)
        figure.tight_layout(rect=(0, 0.1 if with_quoted else 0.07, 1, 1))
        style.finish(figure, out, name, foot)


def main(out, before):
    here = os.path.dirname(os.path.abspath(__file__))
    rows, about = data.read(f"{out}/work_precision.csv")
    samples, _ = data.read(f"{out}/samples.csv")
    if not rows:
        sys.exit(f"{out}/work_precision.csv: expected rows to draw")
    before, _ = data.read(before) if before else ([], {})
    work_precision(out, rows, before, about)
    orders = convergence(out, rows, samples, about)
    cost(out, rows, about)
    order_in_time(out)
    equivalence(out)
    soft_cube(out, os.path.join(here, "..", "reference", "peers", "soft_cube_quoted.csv"))
    with open(f"{out}/tables.md", "w", encoding="utf-8") as file:
        of_steps = [row for row in rows if row["rest"] == "steps"]
        file.write("\n".join((cheapest_table(rows), moved_fronts_table(of_steps, rows), accuracy_table(rows, orders),
                              moved_fronts_table(before, rows))))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Draws every chart and table from the CSV files of a folder; bench/charts.sh makes them.")
    parser.add_argument("folder", help="where the CSV files are, and the charts go")
    parser.add_argument("--before", help="work_precision.csv of another build, measured beside: its fronts are dashed")
    arguments = parser.parse_args()
    main(arguments.folder, arguments.before)
