"""Draws docs/architecture.svg: the flow from raw files to the report, and the floors of the packages.

python docs/draw_architecture.py
"""

from pathlib import Path

WIDTH, HEIGHT = 940, 610
INK, LINE, FAINT = "#22303c", "#5b6b78", "#8a98a3"
FILL = {"source": "#f4efe2", "file": "#e8f0f6", "model": "#e7f3ea", "library": "#ffffff", "report": "#f3e9ee"}

# name -> (x, y, width, height, kind, lines)
FLOW = {
    "lab": (20, 52, 150, 52, "source", ["virtual laboratory", "simulated rigs"]),
    "own": (20, 132, 150, 52, "source", ["your recordings", "log, C3D, EDF, table"]),
    "raw": (215, 92, 110, 52, "file", ["raw files", "of the instruments"]),
    "trials": (390, 92, 120, 52, "file", ["trials/*.h5", "one clock, SI units"]),
    "fits": (575, 92, 140, 52, "file", ["fits, estimates", "I, B, K, intervals"]),
    "tables": (790, 52, 130, 40, "file", ["tables, figures"]),
    "report": (790, 132, 130, 40, "report", ["report (PDF, HTML)"]),
    "models": (475, 192, 140, 44, "model", ["treadmill_models/", "belt-induced load"]),
}
# from, to, label, where the label is relative to the middle of the arrow
ARROWS = [
    ("lab", "raw", "", 0, 0),
    ("own", "raw", "", 0, 0),
    ("raw", "trials", "ingest", 0, -7),
    ("trials", "fits", "fit", 0, -7),
    ("fits", "tables", "collect", -4, -14),
    ("tables", "report", "", 0, 0),
    ("trials", "models", "calibrate", -34, 4),
    ("models", "fits", "compensate", 42, 6),
]
# floor (from the ground up) -> packages with what they hold
FLOORS = [
    [
        ("errors", "one sentence per refusal"),
        ("flags", "checks that an estimate failed"),
        ("quantities", "kinds of values and their ranges"),
    ],
    [("arguments", "units, shapes and ranges of what users give")],
    [
        ("signals", "filters, resampling, spectra, epochs, EMG"),
        ("io", "trials, results, tables, readers"),
        ("statistics", "least squares, bootstrap, VAF"),
    ],
    [
        ("mechanics", "inverse and forward dynamics"),
        ("ingest", "raw contents to one trial"),
        ("treadmill", "models of the belt-induced load"),
    ],
    [
        ("identification", "least squares, output error, IV, admittance, parallel cascade"),
        ("drawing", "style of figures, pages of trials"),
    ],
    [("experiments", "wristalyzer, dummy, weight, standing, ...: analysis, figures, pages")],
    [
        ("reporting", "tables and claims of the thesis, recovery, figures"),
        ("new_study", "settings from your recordings"),
    ],
    [("cli", "command line"), ("workflow", "Snakemake rules and scripts, configuration")],
]


def text(x: float, y: float, words: str, size: float = 12.5, colour: str = INK, extra: str = "") -> str:
    """A line of text, centred at x (px)."""
    return (
        f'<text x="{x:g}" y="{y:g}" font-size="{size:g}" fill="{colour}" text-anchor="middle"{extra}>'
        f"{words}</text>"
    )


def box(x: float, y: float, width: float, height: float, kind: str, lines: list[str]) -> list[str]:
    """A rounded box with one or two lines of text (px)."""
    drawn = [
        f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="6" fill="{FILL[kind]}" '
        f'stroke="{LINE}" stroke-width="1"/>'
    ]
    middle, first = x + width / 2, y + height / 2 + (4.5 if len(lines) == 1 else -3.5)
    drawn.append(text(middle, first, lines[0], extra=' font-weight="600"'))
    if len(lines) > 1:
        drawn.append(text(middle, first + 16, lines[1], 11, LINE))
    return drawn


def edge(name: str, towards: str) -> tuple[float, float]:
    """Point on the border of a box of the flow that faces another box (px)."""
    (x, y, w, h, *_), (u, v, a, b, *_) = FLOW[name], FLOW[towards]
    dx, dy = u + a / 2 - (x + w / 2), v + b / 2 - (y + h / 2)
    scale = min(w / 2 / abs(dx) if dx else 1e9, h / 2 / abs(dy) if dy else 1e9)
    return x + w / 2 + dx * scale, y + h / 2 + dy * scale


def flow() -> list[str]:
    """The upper panel."""
    drawn = [text(WIDTH / 2, 28, "From raw files to the report", 15, extra=' font-weight="600"')]
    for start, end, label, right, down in ARROWS:
        (x, y), (u, v) = edge(start, end), edge(end, start)
        drawn.append(
            f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{u:.1f}" y2="{v:.1f}" stroke="{LINE}" '
            f'stroke-width="1.4" marker-end="url(#tip)"/>'
        )
        if label:
            drawn.append(text((x + u) / 2 + right, (y + v) / 2 + down, label, 11, LINE))
    for place in FLOW.values():
        drawn += box(*place)
    return drawn


def floors(top: float) -> list[str]:
    """The lower panel, the ground floor at the bottom, starting at ``top`` (px)."""
    drawn = [
        text(
            WIDTH / 2,
            top,
            "Packages of tepsipe: each imports from the floors below it only",
            15,
            extra=' font-weight="600"',
        )
    ]
    height, gap, left, width = 38, 6, 20, WIDTH - 210
    for floor, packages in enumerate(reversed(FLOORS)):
        y = top + 14 + floor * (height + gap)
        each = (width - gap * (len(packages) - 1)) / len(packages)
        for k, (name, holds) in enumerate(packages):
            drawn += box(left + k * (each + gap), y, each, height, "library", [name, holds])
    total = len(FLOORS) * (height + gap) - gap
    drawn += box(WIDTH - 170, top + 14, 150, total, "source", ["virtual_lab", "imports nothing of these"])
    drawn.append(text(WIDTH - 95, top + 14 + total / 2 + 30, "and vice versa", 11, LINE))
    return drawn


def drawing() -> str:
    """The whole picture as SVG."""
    tip = (
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" '
        f'orient="auto"><path d="M0,0 L8,4 L0,8 z" fill="{LINE}"/></marker></defs>'
    )
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" '
        f'height="{HEIGHT}" font-family="Helvetica, Arial, sans-serif">'
    )
    ground = f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>'
    return "\n".join([head, tip, ground, *flow(), *floors(275), "</svg>", ""])


if __name__ == "__main__":
    (Path(__file__).parent / "architecture.svg").write_text(drawing(), encoding="utf-8")
