"""Flow charts of the thesis's ideas and methods, redrawn: boxes and arrows on a sheet measured in inches.

Counterparts of Figures 1-1, 1-2, 1-3, 2-5, 2-11 and 2-12.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, FancyBboxPatch, Polygon

from tepsipe.reporting.figures.style import COLOURS, WIDTH_IN, in_style, new_figure

LINE = "#3a3a3a"
# kinds of boxes: what is given or recorded, what is computed, what results
GIVEN, COMPUTED, RESULT = "#f1ede2", "#e3edf4", "#e2efe3"
TEXT_PT = 8.0


@dataclass(frozen=True)
class Box:
    """A box of a flow chart; its edges are where arrows begin and end."""

    x: float
    y: float
    """Centre (in)."""
    width: float
    height: float
    """Size (in)."""

    @property
    def left(self) -> tuple[float, float]:
        """Middle of the left edge (in)."""
        return self.x - 0.5 * self.width, self.y

    @property
    def right(self) -> tuple[float, float]:
        """Middle of the right edge (in)."""
        return self.x + 0.5 * self.width, self.y

    @property
    def top(self) -> tuple[float, float]:
        """Middle of the upper edge (in)."""
        return self.x, self.y + 0.5 * self.height

    @property
    def bottom(self) -> tuple[float, float]:
        """Middle of the lower edge (in)."""
        return self.x, self.y - 0.5 * self.height


def _sheet(height_in: float) -> tuple[Figure, Axes]:
    """A figure without axes, whose coordinates are inches."""
    figure, axis = new_figure(1, 1, height_in)
    axis.set(xlim=(0.0, WIDTH_IN), ylim=(0.0, height_in))
    axis.grid(visible=False)
    axis.axis("off")
    return figure, axis


def _box(
    axis: Axes, x: float, y: float, width: float, height: float, text: str, colour: str, title: str = ""
) -> Box:
    """Rounded box around (x, y) with a text, below a bold title if there is one."""
    axis.add_patch(
        FancyBboxPatch(
            (x - 0.5 * width + 0.03, y - 0.5 * height + 0.03),
            width - 0.06,
            height - 0.06,
            boxstyle="round,pad=0.03",
            facecolor=colour,
            edgecolor=LINE,
            linewidth=0.7,
        )
    )
    if title and text:
        lines = title.count("\n") + 1
        top = y + 0.5 * height - 0.06
        axis.text(x, top, title, ha="center", va="top", fontsize=TEXT_PT, weight="bold", linespacing=1.1)
        middle = 0.5 * (top - 0.135 * lines + y - 0.5 * height)
        axis.text(x, middle, text, ha="center", va="center", fontsize=TEXT_PT - 0.5, linespacing=1.15)
    else:
        weight = "bold" if title else "normal"
        axis.text(
            x, y, title or text, ha="center", va="center", fontsize=TEXT_PT, weight=weight, linespacing=1.15
        )
    return Box(x, y, width, height)


def _arrow(axis: Axes, *points: tuple[float, float], colour: str = LINE, style: str = "-|>") -> None:
    """Arrow along a polyline (in)."""
    for begin, end in pairwise(points[:-1]):
        axis.plot(*zip(begin, end, strict=True), color=colour, linewidth=0.9, solid_capstyle="round")
    axis.annotate(
        "",
        points[-1],
        points[-2],
        arrowprops={"arrowstyle": style, "lw": 0.9, "color": colour, "shrinkA": 0.0, "shrinkB": 0.0},
    )


def _note(axis: Axes, x: float, y: float, text: str, colour: str = LINE, **keywords) -> None:
    axis.text(
        x, y, text, **({"fontsize": TEXT_PT, "ha": "center", "va": "center", "color": colour} | keywords)
    )


# ---- joint impedance and its identification


@in_style
def draw_identification() -> Figure:
    """Joint impedance as a system (Figure 1-1) and the loop of its identification (Figure 1-2)."""
    figure, axis = _sheet(2.9)
    _ankle(axis, 0.95, 1.35)
    box = _box(axis, 0.95, 0.42, 0.95, 0.5, "joint\nimpedance", COMPUTED)
    for begin, end in (((0.12, 0.42), box.left), (box.right, (1.78, 0.42))):
        _arrow(axis, begin, end)
    _note(axis, 0.24, 0.58, r"$\theta(t)$")
    _note(axis, 1.65, 0.58, r"$\tau(t)$")
    _note(axis, 0.95, 0.06, "torque as the response to a movement")
    axis.plot([2.08, 2.08], [0.1, 2.8], color="#cccccc", linewidth=0.7)
    prior = _box(axis, 3.0, 2.6, 1.45, 0.34, "prior knowledge", GIVEN)
    experiment = _box(axis, 3.0, 1.95, 1.45, 0.42, "design of the\nexperiment", GIVEN)
    data = _box(axis, 3.0, 1.25, 1.45, 0.34, "recorded data", GIVEN)
    model = _box(axis, 5.25, 1.95, 1.45, 0.42, "set of models", GIVEN)
    criterion = _box(axis, 5.25, 1.25, 1.45, 0.42, "criterion of fit", GIVEN)
    fit = _box(axis, 4.12, 0.72, 1.6, 0.34, "estimate of parameters", COMPUTED)
    check = _box(axis, 4.12, 0.2, 1.6, 0.34, "validation", COMPUTED)
    use = _box(axis, 5.72, 0.2, 0.8, 0.34, "use it", RESULT)
    _arrow(axis, prior.bottom, experiment.top)
    _arrow(axis, experiment.bottom, data.top)
    _arrow(axis, prior.right, (5.25, 2.6), model.top)
    _arrow(axis, model.bottom, criterion.top)
    _arrow(axis, data.bottom, (3.0, 0.72), fit.left)
    _arrow(axis, criterion.bottom, (5.25, 0.72), fit.right)
    _arrow(axis, fit.bottom, check.top)
    _arrow(axis, check.right, use.left)
    _note(axis, 5.12, 0.32, "good")
    red = COLOURS["model"]
    _arrow(axis, check.left, (2.18, 0.2), (2.18, 1.95), experiment.left, colour=red)
    _note(axis, 2.72, 0.32, "not good: revise", red)
    return figure


def _ankle(axis: Axes, x: float, y: float) -> None:
    """Shank and foot with angle and torque of the ankle at (x, y)."""
    body = {"facecolor": "#d9d3c4", "edgecolor": LINE, "linewidth": 0.8}
    axis.add_patch(
        Polygon(
            [(x - 0.22, y - 0.28), (x + 0.62, y - 0.28), (x + 0.5, y - 0.12), (x + 0.08, y + 0.06)], **body
        )
    )
    axis.add_patch(Polygon([(x - 0.1, y), (x + 0.1, y), (x + 0.42, y + 1.12), (x + 0.18, y + 1.19)], **body))
    axis.add_patch(Circle((x, y), 0.085, facecolor="white", edgecolor=LINE, linewidth=0.8))
    axis.plot([x, x], [y, y + 1.25], color="#999999", linewidth=0.7, linestyle="--")
    axis.add_patch(Arc((x, y), 1.9, 1.9, theta1=73.0, theta2=90.0, color=LINE, linewidth=0.9))
    _note(axis, x + 0.08, y + 1.08, r"$\theta$")
    blue = COLOURS["recommended"]
    axis.add_patch(Arc((x, y), 0.62, 0.62, theta1=130.0, theta2=235.0, color=blue, linewidth=1.2))
    _arrow(axis, (x - 0.215, y + 0.22), (x - 0.17, y + 0.262), colour=blue)
    _note(axis, x - 0.42, y + 0.05, r"$\tau$", blue)


# ---- summary of the methods

# experiment -> rig and subject, what is recorded, how it is identified, what results
METHODS = {
    "wristalyzer": (
        "Wristalyzer\ndummy",
        "motor torque,\nangle",
        "frequency domain:\nadmittance",
        "reference\n$I$, $B$, $K$",
    ),
    "dummy": (
        "Treadmill\ndummy",
        "markers, belt,\nforces",
        "time domain:\nTEP-SIPE",
        "$I$, $B$, $K$ by\nTEP-SIPE",
    ),
    "simulation": (
        "Simulation\ndummy",
        "simulated angle\nand torque",
        "time domain:\nTEP-SIPE",
        "agreement; effect\nof noise",
    ),
    "weight": (
        "Treadmill\nweight, nothing",
        "markers, belt,\nforces",
        "time domain: force\nof the treadmill",
        "dynamics of the\ntreadmill",
    ),
    "standing": (
        "Treadmill\nperson",
        "markers, forces,\nEMG",
        "angles, torque,\nactivity",
        "pilot data",
    ),
}


@in_style
def draw_methods(names: Sequence[str]) -> Figure:
    """Experiments from the rig to the result (Figure 1-3), a column for each of ``names`` in `METHODS`."""
    shown = [name for name in METHODS if name in names]
    figure, axis = _sheet(2.72)
    titles = ("Experiment", "Recorded", "Identified", "Result")
    rows, colours = (2.46, 1.83, 1.2, 0.57), (GIVEN, GIVEN, COMPUTED, RESULT)
    for y, title in zip(rows, titles, strict=True):
        _note(axis, 0.02, y, title, ha="left", weight="bold")
    step = (WIDTH_IN - 0.75) / len(shown)
    results = {}
    for k, name in enumerate(shown):
        x, above = 0.75 + (k + 0.5) * step, None
        for y, text, colour in zip(rows, METHODS[name], colours, strict=True):
            words = ("", text) if y == rows[0] else (text, "")
            box = _box(axis, x, y, min(step - 0.1, 1.5), 0.46, words[0], colour, words[1])
            if above is not None:
                _arrow(axis, above.bottom, box.top)
            above = box
        results[name] = above
    if "simulation" in results:
        blue, goal = COLOURS["recommended"], results["simulation"]
        gap = goal.left[0] - 0.05
        for name in ("wristalyzer", "dummy"):
            begin = results[name]
            _arrow(
                axis,
                begin.bottom,
                (begin.x, 0.2),
                (gap, 0.2),
                (gap, rows[0]),
                (goal.left[0], rows[0]),
                colour=blue,
            )
        _note(axis, results["wristalyzer"].x, 0.08, "parameters to simulate with", blue, ha="left")
    return figure


# ---- instruments and processing of the treadmill


@in_style
def draw_signal_chain(choices: Mapping) -> Figure:
    """Instruments of the treadmill, and the way from their files to a torque (Figure 2-5).

    choices: ``plate_rate_hz``, ``sampling_hz`` (of the markers within a frame, or None), ``cutoff_hz`` (all
    Hz), and ``emg``: whether the study has electromyograms.
    """
    figure, axis = _sheet(3.6)
    sampling_hz, blue = choices["sampling_hz"], COLOURS["recommended"]
    host = _box(axis, 0.75, 3.2, 1.3, 0.56, "profile, amplitude,\nintervals", GIVEN, "Host computer")
    control = _box(axis, 2.5, 3.2, 1.5, 0.56, "velocity command,\ntrigger", GIVEN, "Real-time controller")
    motors = _box(axis, 4.15, 3.2, 1.1, 0.56, "one per belt", GIVEN, "Servo motors")
    belt = _box(axis, 5.6, 3.2, 1.2, 0.56, "right belt,\nsubject on it", GIVEN, "Treadmill")
    _arrow(axis, host.right, control.left)
    _arrow(axis, control.right, motors.left)
    _arrow(axis, motors.right, belt.left)
    cells = _box(
        axis,
        5.1,
        2.2,
        2.1,
        0.66,
        "7 per belt; 14 voltages,\ncalibration matrix, $F$ and $M$",
        GIVEN,
        "Force transducers",
    )
    in_turn = "all at one instant" if sampling_hz is None else f"one after another at {sampling_hz:g} Hz"
    camera = _box(
        axis, 2.75, 2.2, 2.1, 0.66, f"active markers,\n{in_turn}", GIVEN, "Motion capture with strober"
    )
    _arrow(axis, (5.6, belt.bottom[1]), (5.6, cells.top[1]))
    _arrow(axis, (5.25, belt.bottom[1]), (5.25, 2.68), (3.4, 2.68), (3.4, camera.top[1]))
    _arrow(axis, (2.2, control.bottom[1]), (2.2, camera.top[1]), colour=blue)
    _note(axis, 1.62, 2.76, "trigger", blue)
    sources = [camera, cells]
    if choices["emg"]:
        emg = _box(axis, 0.805, 2.2, 1.4, 0.66, "electromyograms\nof the person", GIVEN, "EMG amplifier")
        _arrow(axis, (1.95, control.bottom[1]), (1.95, 2.68), (1.2, 2.68), (1.2, emg.top[1]), colour=blue)
        sources.insert(0, emg)
    files = ("EDF", "C3D", "log: belt velocity,\nvoltages, trigger")[-len(sources) :]
    steps = (
        ("align by the trigger;\nmarkers to one instant;\nvoltages to forces", COMPUTED),
        (f"resample at\n{choices['plate_rate_hz']:g} Hz:\none trial (HDF5)", COMPUTED),
        (f"zero-lag\nlow-pass,\n{choices['cutoff_hz']:g} Hz", COMPUTED),
        ("pathways: torque,\nwindows,\nestimator", COMPUTED),
        ("$I$, $B$, $K$\nwith intervals", RESULT),
    )
    widths, x, before = (1.55, 1.1, 0.9, 1.2, 0.9), 0.03, None
    for (text, colour), width in zip(steps, widths, strict=True):
        box = _box(axis, x + 0.5 * width, 0.42, width, 0.66, text, colour)
        if before is not None:
            _arrow(axis, before.right, box.left)
        else:
            for source, file in zip(sources, files, strict=True):
                _arrow(axis, source.bottom, (source.x, 1.1), (box.x, 1.1), box.top)
                _note(axis, source.x + 0.06, 1.45, file, ha="left")
        before, x = box, x + width + 0.145
    return figure


# ---- protocols of the simulation


@in_style
def draw_evaluation(sets: Sequence[str], trials: int) -> Figure:
    """First part of the simulation (Figure 2-11): parameters are evaluated by the movement that they produce.

    trials: number of trials on the treadmill.
    """
    step = 0.36
    height = max(1.75, step * len(sets) + 0.35)
    figure, axis = _sheet(height)
    middle = 0.5 * height - 0.08
    model = _box(
        axis, 3.0, middle, 1.35, 0.8, "of the dummy, moved\nby the recorded belt", COMPUTED, "Simulation"
    )
    _note(axis, 0.95, height - 0.1, "Sets of $I$, $B$, $K$", weight="bold")
    for k, name in enumerate(sets):
        box = _box(axis, 0.95, middle + step * (0.5 * (len(sets) - 1) - k), 1.85, step - 0.07, name, GIVEN)
        _arrow(axis, box.right, (2.1, box.y), (2.1, middle), model.left)
    simulated = _box(
        axis, 4.55, middle + 0.42, 1.1, 0.46, r"simulated" "\n" r"$\theta_A$, $\tau_A$", COMPUTED
    )
    measured = _box(axis, 4.55, middle - 0.42, 1.1, 0.46, r"measured" "\n" r"$\theta_A$, $\tau_A$", GIVEN)
    score = _box(axis, 5.83, middle, 0.85, 0.6, "VAF,\nstability", RESULT)
    _arrow(axis, model.right, (3.83, middle), (3.83, simulated.y), simulated.left)
    _arrow(axis, (3.0, middle - 0.72), model.bottom)
    _arrow(axis, simulated.right, (5.83, simulated.y), score.top)
    _arrow(axis, measured.right, (5.83, measured.y), score.bottom)
    _note(axis, 3.0, middle - 0.79, f"{trials} trials on the treadmill", va="top")
    return figure


@in_style
def draw_sensitivity(choices: Mapping) -> Figure:
    """Second part of the simulation (Figure 2-12): known parameters are estimated again, with noise.

    choices: ``snr_db``, ``draws`` (of the noise), ``cutoff_hz``.
    """
    figure, axis = _sheet(2.3)
    known = _box(axis, 0.6, 1.2, 1.1, 0.56, "$I$, $B$, $K$", GIVEN, "Known joint")
    model = _box(axis, 1.95, 1.2, 1.1, 0.56, r"$\theta_A$, $\tau_A$", COMPUTED, "Simulation")
    _arrow(axis, known.right, model.left)
    low, high = min(choices["snr_db"]), max(choices["snr_db"])
    _note(
        axis,
        3.35,
        2.2,
        f"Noise: SNR {low:g} to {high:g} dB, {choices['draws']} draws",
        weight="bold",
    )
    method = _box(
        axis,
        4.85,
        1.2,
        1.15,
        0.8,
        f"low-pass {choices['cutoff_hz']:g} Hz,\nwindows,\nfit",
        COMPUTED,
        "TEP-SIPE",
    )
    branches = ("none", r"a) on the torque $\tau_A$", r"b) on the angle $\theta_A$", "c) on both")
    for y, text in zip((1.86, 1.42, 0.98, 0.54), branches, strict=True):
        box = _box(axis, 3.35, y, 1.4, 0.36, text, GIVEN)
        _arrow(axis, model.right, (2.57, 1.2), (2.57, y), box.left)
        _arrow(axis, box.right, (4.16, y), (4.16, 1.2), method.left)
    found = _box(axis, 5.92, 1.2, 0.7, 0.56, "$I$, $B$, $K$", RESULT, "Found")
    _arrow(axis, method.right, found.left)
    _arrow(
        axis,
        known.bottom,
        (0.6, 0.15),
        (5.92, 0.15),
        found.bottom,
        colour=COLOURS["recommended"],
        style="<|-|>",
    )
    _note(axis, 3.35, 0.25, "bias, spread, VAF", COLOURS["recommended"])
    return figure
