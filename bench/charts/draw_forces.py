# SPDX-License-Identifier: MIT
"""Draws the force curves of docs/measurements/surgery.md from the CSV files of the examples: draw_forces.py FOLDER. See
examples/surgery.sh."""
import argparse
import sys

import chart_data as data
import chart_style as style
from chart_data import number
from chart_style import plt

BLUE, RED, GREEN, GREY = "#0072B2", "#D55E00", "#009E73", "#777777"


def columns(rows, *keys):
    return [[number(r, key) for r in rows] for key in keys]


def rows_of(out, name):
    rows, _ = data.read(f"{out}/{name}.csv")
    if not rows:
        sys.exit(f"{out}/{name}.csv: expected the rows that the example writes")
    return rows


def sheet(title, *labels, height=3.6):
    """A figure with a panel for each pair of labels, x and y."""
    figure, grid = plt.subplots(1, len(labels), figsize=(3.6 + 3.4 * len(labels), height), squeeze=False)
    for axes, (x, y) in zip(grid[0], labels):
        axes.set(xlabel=x, ylabel=y)
    figure.suptitle(title, x=0.01, ha="left", fontsize=10.5, fontweight="bold")
    return figure, list(grid[0])


def finish(figure, out, name):
    figure.tight_layout(rect=(0, 0.03, 1, 1))
    style.finish(figure, out, name, "by examples/surgery.sh · phymul, backend cpu")


def zero(axes):
    axes.axhline(0, color="#999999", linewidth=0.8)


def needle(out):
    figure, (axes,) = sheet("A needle in a soft block: 40 mm in, a rest, and out", ("depth of the tip under the surface at rest, mm",
                            "force on the hand, N"))
    for (name,), rows in data.groups(rows_of(out, "needle"), "needle").items():
        depth, force = columns(rows, "depth_mm", "force_N")
        turning = name == "turning"
        axes.plot(depth, force, color=RED if turning else BLUE, linewidth=1.2, linestyle=(0, (4, 2)) if turning else "-",
                  label="turns 10 times a second" if turning else "straight")
        if not turning:
            top = max(range(len(force)), key=lambda k: force[k] if depth[k] < 20 else -1)
            axes.annotate("the skin gives way: 2 N", (depth[top], force[top]), (12, 2), textcoords="offset points", fontsize=8)
            deepest = max(depth)
            last = max(k for k in range(len(depth)) if depth[k] > deepest - 1e-6)
            axes.annotate("stops: it sticks,\nand stays drawn in", (depth[last], force[last]), (-92, -34),
                          textcoords="offset points", fontsize=8, arrowprops={"arrowstyle": "-", "color": GREY})
            low = min(range(len(force)), key=lambda k: force[k])
            axes.annotate("drawn out: the tissue holds it", (depth[low], force[low]), (-170, -4),
                          textcoords="offset points", fontsize=8)
    zero(axes)
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, 0.42))
    finish(figure, out, "needle_force")


def probe(out):
    figure, (left, right) = sheet("A probe pressed on the prostate from behind",
                                  ("depth of the probe, mm", "force on the probe, N"),
                                  ("depth of the probe, mm", "the gland's middle has moved, mm"))
    rows = rows_of(out, "prostate_probe")
    depth, force, moved = columns(rows, "depth_mm", "force_N", "gland_moved_mm")
    turn = max(k for k in range(len(depth)) if depth[k] > max(depth) - 1e-6)
    for axes, values in ((left, force), (right, moved)):
        axes.plot(depth[:turn + 1], values[:turn + 1], color=BLUE, label="in")
        axes.plot(depth[turn:], values[turn:], color=RED, linestyle=(0, (4, 2)), label="back")
        zero(axes)
    left.legend()
    finish(figure, out, "prostate_probe_force")


def orders(out):
    looks = dict(zip(("middle first", "middle second", "middle last"), ((BLUE, "-"), (RED, (0, (4, 2))), (GREEN, (0, (1, 1))))))
    figure, (left, right) = sheet("Three needles into the prostate, in three orders: the middle needle and its target",
                                  ("depth of the tip under the skin, mm", "force on the middle needle's hub, N"),
                                  ("time, s", "the middle target has moved, mm"))
    for (order, needle), rows in data.groups(rows_of(out, "prostate_needles_force"), "order", "needle").items():
        if needle == "middle":
            depth, force = columns(rows, "depth_mm", "force_N")
            left.plot(depth, force, color=looks[order][0], linestyle=looks[order][1], label=order)
    arrivals = {r["order"]: r for r in rows_of(out, "prostate_needles") if r["needle"] == "middle"}
    for (order,), rows in data.groups(rows_of(out, "prostate_needles_moved"), "order").items():
        time, moved = columns(rows, "time_s", "middle_mm")
        right.plot(time, moved, color=looks[order][0], linestyle=looks[order][1], label=order)
        at = round(len(time) * number(arrivals[order], "turn") / 3) - 1
        right.plot(time[at], moved[at], "o", color=looks[order][0], markersize=6)
    right.plot([], [], "o", color=GREY, label="its needle is there")
    zero(left)
    right.set_ylim(bottom=0)
    right.legend()
    finish(figure, out, "prostate_needles_force")


def cloth(out):
    figure, (axes,) = sheet("A cloth falls on a ball and the floor", ("time, s", "force downward, N"))
    time, ball, floor = columns(rows_of(out, "cloth_on_sphere"), "time_s", "ball_N", "floor_N")
    axes.plot(time, ball, color=BLUE, label="on the ball")
    axes.plot(time, floor, color=RED, linestyle=(0, (4, 2)), label="on the floor")
    axes.plot(time, [b + f for b, f in zip(ball, floor)], color=GREY, linewidth=0.8, label="both")
    style.guide(axes, y=0.2 * 9.81 * (0.32 * 33 / 32) ** 2, text="weight of the cloth")
    axes.legend()
    finish(figure, out, "cloth_on_sphere_force")


def two_forces(out, name, title, lines):
    """`lines`: of the CSV file NAME, two pairs of a column and its label."""
    figure, (axes,) = sheet(title, ("time, s", "force, N"))
    time, first, second = columns(rows_of(out, name), "time_s", *(column for column, _ in lines))
    axes.plot(time, first, color=BLUE, label=lines[0][1])
    axes.plot(time, second, color=RED, linestyle=(0, (4, 2)), label=lines[1][1])
    zero(axes)
    axes.legend()
    finish(figure, out, f"{name}_force")


def organs(out):
    two_forces(out, "two_organs", "Two organs: a probe presses, a needle goes in, both go away",
               [("probe_N", "on the probe, upward"), ("needle_N", "on the needle's hub, back")])


def liver(out):
    two_forces(out, "liver", "A probe presses on a tumour, slides off it and goes back",
               [("force_N", "on the probe"), ("ligament_N", "of the ligament")])


def main(out):
    for draw in (needle, liver, probe, orders, cloth, organs):
        draw(out)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Draws the force curves of docs/measurements/surgery.md from the CSV files of a folder; examples/surgery.sh makes them.")
    parser.add_argument("folder", help="where the CSV files are, and the charts go")
    main(parser.parse_args().folder)
