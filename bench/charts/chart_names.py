# SPDX-License-Identifier: MIT
"""What the charts call cases, methods and bodies, for readers who have no table of codes beside them."""
import textwrap

# A level of a case is named as nu0.30_c0.1250: Poisson's ratio, and how much of the case's load.
LOADS = {
    "s": lambda x: f"strain {100 * x:g} %",
    "c": lambda x: f"strain {100 * x:g} %",
    "d": lambda x: f"{1e3 * x:g} mm deep",
    "ux": lambda x: f"{1e3 * x:g} mm to the side",
    "g": lambda x: f"{x:g} of gravity",
}

# As the stability atlas has them in its CSV files.
STABILITY_METHODS = {
    "springs 6": "springs, 6 neighbours",
    "springs 18": "springs, 18 neighbours",
    "springs 26": "springs, 26 neighbours",
    "springs 18, volume": "springs, 18, and volume",
    "full": "shape memory, full reaction",
    "shared": "shape memory, shared reaction",
    "barycentric": "shape memory, barycentric reaction",
    "averaged": "shape memory, averaged",
}

SWEEP_VARIANTS = {
    "springs": "Springs along the edges of tetrahedra",
    "shared_6_all": "Shared reaction, 6 neighbours, all 20 bases",
    "shared_14_all": "Shared reaction, 14 neighbours, all bases",
    "averaged_6": "Averaged reaction, 6 neighbours",
    "material_lattice": "Material on a lattice",
    "material_tetrahedra": "Material on tetrahedra",
}


def load_text(part):
    """Of a part such as "ux0.010"; what is none stays as it is."""
    kind = part.rstrip("0123456789.")
    try:
        amount = float(part[len(kind):])
    except ValueError:
        return part
    if kind == "nu":
        return f"Poisson's ratio {amount:.2f}"
    return LOADS[kind](amount) if kind in LOADS else part


def level_text(level):
    return ", ".join(load_text(part) for part in level.split("_"))


def case_text(row):
    """Of a row of work_precision.csv."""
    return f"{row['title']}, {level_text(row['level'])}"


def panel_title(row, width=46):
    """The same on lines short enough for a panel of four side by side."""
    return "\n".join(textwrap.wrap(row["title"], width) + [level_text(row["level"])])


def stability_text(method):
    """ "shared" or "material, nu 0.45" written out."""
    if ", nu " in method:
        return f"material, Poisson's ratio {float(method.split(', nu ')[1]):.2f}"
    return STABILITY_METHODS.get(method, method)
