# SPDX-License-Identifier: MIT
"""Looks shared by all charts. Colours are Okabe and Ito's, told apart by colour-blind eyes; families have dashes of
their own and every method its marker, so that a grey print reads as well."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

plt.rcParams.update({
    "font.size": 9, "axes.grid": True, "grid.color": "#dddddd", "grid.linewidth": 0.6, "axes.axisbelow": True,
    "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False, "svg.fonttype": "none",
    "svg.hashsalt": "phymul", "figure.dpi": 110,
})

# method: colour, marker, dashes
METHODS = {
    "springs_6": ("#56B4E9", "1", (4, 2)),
    "springs_18": ("#0072B2", "s", (4, 2)),
    "springs_26": ("#56B4E9", "D", (4, 2)),
    "springs_18_volume": ("#0072B2", "P", (4, 2)),
    "full": ("#CC79A7", "x", (1, 1.5)),
    "shared": ("#E69F00", "<", (1, 1.5)),
    "barycentric": ("#E69F00", ">", (1, 1.5)),
    "averaged": ("#CC79A7", "v", (1, 1.5)),
    "particle_averaged": ("#D55E00", "*", ()),
}
ENGINES = ["#D55E00", "#0072B2", "#009E73", "#E69F00", "#CC79A7", "#56B4E9", "#000000", "#999999"]
MARKERS = ["*", "s", "o", "^", "v", "D", "P", "X", "<", ">"]


def style_of(method):
    colour, marker, dashes = METHODS.get(method, ("#000000", ".", (2, 2)))
    return {"color": colour, "marker": marker, "markersize": 8 if marker == "*" else 5.5,
            "linestyle": (0, dashes) if dashes else "-", "linewidth": 1.3}


def finish(figure, out, name, foot):
    """Writes NAME.svg and NAME.png with a foot line of where the figures come from."""
    figure.text(0.01, 0.004, foot, fontsize=6.5, color="#555555", ha="left", va="bottom")
    for kind in ("svg", "png"):
        figure.savefig(f"{out}/{name}.{kind}", metadata={"Date": None} if kind == "svg" else None)
    plt.close(figure)


def guide(axes, x=None, y=None, text="", below=False, **line):
    """A marked line across the chart, unless all that is drawn lies to the right of its x; the text of a level line
    stands above its right end, or below its left one."""
    if x is not None and x < 1.05 * axes.get_xlim()[0]:
        return
    looks = {"color": "#777777", "linewidth": 1.0, **line}
    if x is not None:
        axes.axvline(x, **looks)
        axes.annotate(text, (x, 0.02), xycoords=("data", "axes fraction"), rotation=90, fontsize=7, color="#555555",
                      ha="right", va="bottom")
    else:
        axes.axhline(y, **looks)
        end, ha, va = (0.005, "left", "top") if below else (0.995, "right", "bottom")
        axes.annotate(text, (end, y), xycoords=("axes fraction", "data"), fontsize=7, color="#555555", ha=ha, va=va)
