"""Draws docs/rig.svg: the ankle dummy on the belt, and what two equations make of one recording of it.

python docs/draw_rig.py
"""

from pathlib import Path

from tepsipe import fit_impedance, joint_torque, load_example, segment_motion

INK, GREY, BLUE, RED = "#22303c", "#8a98a3", "#2f6f9f", "#b5482f"


def results() -> list[tuple[str, float, float, float]]:
    """Name, I (N·m·s²/rad), K (N·m/rad) and VAF (%) by the consistent equation and by mixed signs."""
    dummy = load_example("dummy")
    motion = segment_motion(dummy.time, dummy.positions, dummy.markers, dummy.leg.com_m, labels=dummy.labels)
    rows = []
    for name, mixed in (("consistent equation", False), ("mixed signs", True)):
        torque = joint_torque(motion, dummy.leg, thesis=mixed)
        fit = fit_impedance(
            dummy.time, motion.theta, torque, perturbations=dummy.perturbations, cutoff_hz=None
        )
        rows.append((name, fit.I, fit.K, fit.vaf))
    return rows


def text(x: float, y: float, words: str, colour: str = INK, anchor: str = "start", extra: str = "") -> str:
    """A line of text (px)."""
    return f'<text x="{x:g}" y="{y:g}" fill="{colour}" text-anchor="{anchor}"{extra}>{words}</text>'


def rig() -> list[str]:
    """Belt with its pulse, foot, leg that swings, markers, force plate."""
    leg = [(150, 205), (171, 145), (181, 115), (191, 87), (205, 47)]
    markers = [(118, 222), (182, 222), *leg]
    return [
        f'<path d="M60 240 H260" stroke="{INK}" stroke-width="5" stroke-linecap="round"/>',
        f'<circle cx="60" cy="252" r="12" fill="none" stroke="{INK}" stroke-width="2"/>',
        f'<circle cx="260" cy="252" r="12" fill="none" stroke="{INK}" stroke-width="2"/>',
        f'<rect x="90" y="250" width="140" height="10" fill="{GREY}" opacity="0.5"/>',
        text(160, 280, "force plate", GREY, "middle"),
        f'<path d="M105 236 V218 H150 L195 218 V236 Z" fill="{GREY}" opacity="0.35" stroke="{INK}"/>',
        f'<path d="M150 205 L212 28" stroke="{INK}" stroke-width="8" stroke-linecap="round" opacity="0.8"/>',
        f'<path d="M150 205 V28" stroke="{GREY}" stroke-dasharray="4 4"/>',
        f'<path d="M150 90 A115 115 0 0 1 188 96" fill="none" stroke="{RED}" stroke-width="2"/>',
        text(160, 80, "&#952;", RED),
        f'<circle cx="150" cy="205" r="13" fill="#fff" stroke="{BLUE}" stroke-width="3"/>',
        text(60, 200, "joint", BLUE),
        text(60, 216, "I, B, K", BLUE),
        *[f'<circle cx="{x}" cy="{y}" r="4.5" fill="#fff" stroke="{INK}"/>' for x, y in markers],
        text(222, 60, "markers", GREY),
        f'<path d="M275 222 h46" stroke="{RED}" stroke-width="3" marker-end="url(#tip)"/>',
        text(275, 212, "belt pulse", RED),
    ]


def table(rows: list[tuple[str, float, float, float]]) -> list[str]:
    """Truth and both estimates."""
    truth = load_example("dummy").truth
    drawn = [
        text(540, 70, "I", anchor="middle", extra=' font-style="italic"'),
        text(540, 86, "N&#183;m&#183;s&#178;/rad", GREY, "middle", ' font-size="10"'),
        text(650, 70, "K", anchor="middle", extra=' font-style="italic"'),
        text(650, 86, "N&#183;m/rad", GREY, "middle", ' font-size="10"'),
        text(735, 70, "VAF", anchor="middle"),
        text(735, 86, "%", GREY, "middle", ' font-size="10"'),
    ]
    lines = [("truth", truth["I"], truth["K"], None, GREY)]
    lines += [(*row, colour) for row, colour in zip(rows, (BLUE, RED), strict=True)]
    for k, (name, inertia, stiffness, vaf, colour) in enumerate(lines):
        y = 120 + 40 * k
        drawn += [
            f'<path d="M350 {y - 24} H770" stroke="{GREY}" stroke-width="0.5"/>',
            text(355, y, name, colour, extra=' font-weight="600"'),
            text(540, y, f"{inertia:.3f}", colour, "middle"),
            text(650, y, f"{stiffness:.1f}", colour, "middle"),
            text(735, y, "" if vaf is None else f"{vaf:.2f}", colour, "middle"),
        ]
    return [*drawn, text(355, 246, "The wrong equation fits better: the VAF cannot tell.", INK)]


def drawing() -> str:
    """The whole picture as SVG."""
    words = (
        "Left: a leg on an elastic joint stands on a treadmill belt, which makes a short pulse. Right: "
        "estimates of one recording by two equations beside the truth."
    )
    return "\n".join(
        [
            '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 790 300" role="img" '
            'font-family="Helvetica, Arial, sans-serif" font-size="14">',
            f"<title>{words}</title>",
            '<rect width="790" height="300" fill="#fff"/>',
            '<defs><marker id="tip" markerWidth="8" markerHeight="8" refX="4" refY="3" orient="auto">'
            f'<path d="M0 0 L6 3 L0 6 Z" fill="{RED}"/></marker></defs>',
            *rig(),
            *table(results()),
            "</svg>",
            "",
        ]
    )


if __name__ == "__main__":
    Path(__file__).with_name("rig.svg").write_text(drawing(), encoding="utf-8")
