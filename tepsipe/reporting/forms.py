"""Forms of the analysis for the mechanisms of the virtual laboratory, and the table of what both share.

The laboratory declares its forms in a module of its own, under the same names and in the same symbols; the
analysis neither imports it nor is imported by it. Both declarations are compared here:

    same            the equations are the same
    special case    they are the same where some terms of one or both are 0 or equal
    different       they are not
    none            the analysis has no such mechanism
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from tepsipe.io.tables import Table


class Form(NamedTuple):
    """Form of the analysis for one mechanism."""

    equations: tuple[str, ...]
    """Its equation, and then those to which it reduces where some of its terms are 0 or equal."""
    module: str
    """Module of the library that has it."""
    written: str
    """Part of the same equation or sentence as it is written in that module."""


BRISTLES = "tepsipe.treadmill.bristle_frame"
LIKELIHOOD = "tepsipe.identification.likelihood.likelihood"
REFLEX = "tepsipe.experiments.standing.muscle_torque"

FORMS = {
    "friction of the belt": Form(
        ("F = (f_0 + f_1 M) w / √(v_0² + w²) + (b_0 + b_1 M) z + c w",),
        BRISTLES,
        "c w + (f_0 + f_1 M) w / sqrt(v_0^2 + w^2) + (b_0 + b_1 M) z",
    ),
    "bristles of the belt": Form(
        ("d z' = w − |w| z / (1 + u exp(−(w / v_s)²))", "d z' = w − |w| z"),
        "tepsipe.treadmill.pulse_windows",
        "d z' = w - |w| z / g(w), g(w) = 1 + u exp(-(w / v_s)^2)",
    ),
    "height at which belt friction acts": Form(("M_x = h F",), BRISTLES, "lever F_friction"),
    "lag of the belt": Form(("w = v + T v'",), BRISTLES, "w = v + T a"),
    "modes of the frame": Form(
        ("F_t = Σ_i q_i (1 + r_i d p) / (1 + r_i d p + r_i² e p²) F",),
        BRISTLES,
        "R_0(s) = (1 - p) (1 + d s) / D_0 + p (1 + r d s) / (1 + r d s + r^2 e_0 s^2)",
    ),
    # F_y / (R_0 S) is all that presses on the frame: the load, its friction and the felt mass of the belt
    "frame under load": Form(
        ("m (x'' + c x' + k x) = −(F + f_r + m_b v')",),
        BRISTLES,
        "which adds -e_1 s^2 F_y / (R_0 S D_0) to a",
    ),
    "mounts of the deck": Form(
        ("F_t = [1 − s T p / (1 + T p)] F",), BRISTLES, "S(s) = 1 - k t s / (1 + t s)"
    ),
    "marker noise": Form(
        ("white and Gaussian, with one standard deviation",),
        "tepsipe.identification.likelihood.channels",
        "with white noise e_j of one standard deviation sigma",
    ),
    "sampling instants of the markers": Form(
        ("t_j = t + j / f",),
        "tepsipe.signals.resampling",
        "Marker k of frame n is sampled at n / rate + k / strober",
    ),
    "clocks of the instruments": Form(
        ("t_2 = (1 + ε) t_1 + t_0",),
        LIKELIHOOD,
        "the relative difference between the clocks of log and markers",
    ),
    "law of the dummy's joint": Form(
        ("R = K φ (1 − S q) + (B + B_s q) φ', q = φ² / (φ² + φ_h²)",),
        LIKELIHOOD,
        "tau = I phi'' + B phi' + K phi - C q phi + B_s q phi', q = phi^2 / (phi^2 + phi_h^2)",
    ),
    "motion of the leg": Form(
        ("(I_l + m r²) θ'' + m r cos θ y'' = m g r sin θ − R",),
        "tepsipe.identification.regression.output_error",
        "J theta'' = m g r sin(theta) - p y'' cos(theta) - B theta' - K (theta - theta_ref)",
    ),
    "tilt of the dummy's foot": Form(
        ("ψ = c R (a source of uncertainty)",),
        "tepsipe.identification.budgets.leg",
        "A compliance c in series turns Z = I s^2 + B s + K into Z / (1 + c Z)",
    ),
    "bending of the rod": Form(
        ("x = −c a (a source of uncertainty)",),
        "tepsipe.identification.budgets.leg",
        "A rod that bends lags behind the acceleration a of its foot by c a in angle",
    ),
    "load of a weight": Form(
        ("F = M (v' + x'')",),
        BRISTLES,
        "whose load is known as M times the acceleration of the belt, and which moves with the frame",
    ),
    "friction and hardening of the manipulator": Form(
        ("τ = J θ'' + R + F_c tanh(θ' / w_0) + K_3 θ³",),
        "tepsipe.identification.regression.pooled",
        "tau(t - d) = I th'' + B th' + K th + Fc tanh(th' / w0) + K3 th^3 + q (Bs th' - Ks th)",
    ),
    "torque ripple of the manipulator": Form(
        ("noise that is unrelated to the command",),
        "tepsipe.identification.regression.pooled",
        "Noise and torque ripple are unrelated between periods of the perturbation",
    ),
    "soft tissue": Form(
        ("x'' + 2 ζ ω x' + ω² x = −a",),
        "tepsipe.experiments.standing.free_reflex.free_body",
        "([-1.0], [1.0, 2.0 * TISSUE_DAMPING * width, width**2])",
    ),
    "intrinsic torque of the ankle": Form(
        ("τ = B φ' + K φ",),
        "tepsipe.experiments.standing.free_reflex.fit",
        "tau(t) = B phi'(t) + K phi(t) + r(t) + d(t) + s(t)",
    ),
    "drive of a reflex": Form(
        ("u = G_+ [s(t − L)]_+ − G_− [−s(t − L)]_+ + balance", "u = G [s(t − L)]_+"),
        REFLEX,
        "tau_active = h * [ G_+ [phi'(t - L)]_+ - G_- [-phi'(t - L)]_+",
    ),
    "twitch of a muscle": Form(("T² x'' + 2 T x' + x = u",), REFLEX, "T^2 x'' + 2 T x' + x = u"),
    "masses of segments": Form(
        ("shares of the body's mass by Winter (2009)",),
        "tepsipe.mechanics.anthropometry",
        "Source: D. A. Winter (2009)",
    ),
    "electromyogram": Form(
        ("e = low-pass |band-pass(u)|",), "tepsipe.signals.emg", "b = band-pass(x), r = |b|, e = low-pass(r)"
    ),
    "response of a walking ankle": Form(
        ("ΔM = −[I Δθ'' + B Δθ' + K Δθ]",),
        "tepsipe.experiments.walking.impedance",
        "-DM + d m_f Dx'' = I Dtheta'' + B Dtheta' + K Dtheta + e",
    ),
    "torque of ankle and hip": Form(
        ("τ_i = Σ_j [K_ij + B_ij p + (D_ij + E_ij p) exp(−p d_i)] θ_j + n_i",),
        "tepsipe.identification.several_joints.closed_loop",
        "tau_i = sum_j [ K_ij + B_ij s + (D_ij + E_ij s) exp(-s d_i) ] theta_j + n_i",
    ),
    "torque of ankle, knee and hip": Form(
        ("τ = K q + B q'",),
        "tepsipe.identification.several_joints.matrices",
        "M q'' + B q' + (K + G) q = b u(t)",
    ),
}
# mechanisms of the laboratory that the analysis does not have
WITHOUT = (
    "vibration of the floor",
    "drive of the belt",
    "slip of the dummy's markers",
    "further terms of the rubber",
    "skin over the ankle",
    "soft feet",
    "short-range stiffness",
)
SAME, SPECIAL, DIFFERENT, NONE = "same", "special case", "different", "none"


@dataclass(frozen=True)
class SharedRow:
    """One mechanism in the laboratory and in the analysis."""

    section: str
    mechanism: str
    """Experiment that has it, and its name."""
    laboratory: str
    analysis: str
    """Forms of both; empty where the analysis has none."""
    shared: str
    """{"same", "special case", "different", "none"}: How the forms compare."""
    drawn: int
    """Number of its constants that differ from those of the analysis, because they are drawn."""
    other_forms: int
    """Number of other forms under which the analysis is examined."""


SHARED = Table(SharedRow, "forms of laboratory and analysis")


def how_shared(laboratory: tuple[str, ...], analysis: tuple[str, ...]) -> str:
    """Comparison of the equations of both, each with the special cases that follow it."""
    if not analysis:
        return NONE
    if laboratory[0] == analysis[0]:
        return SAME
    return SPECIAL if set(laboratory) & set(analysis) else DIFFERENT


def shared_rows(
    laboratory: Mapping[str, Any], drawn: list[str], experiments: list[str], other_laws: int
) -> list[SharedRow]:
    """Table of what laboratory and analysis share.

    laboratory: forms of the laboratory by mechanism: ``section``, ``equations``, ``constants``.
    drawn: paths of the constants that were drawn.
    experiments: sections to list, in their order.
    other_laws: number of other laws of the dummy's joint.
    """
    rows = []
    for name, form in laboratory.items():
        own = FORMS[name].equations if name in FORMS else ()
        varied = sum(any(f"{path}.".startswith(f"{start}.") for start in form.constants) for path in drawn)
        others = other_laws if name == "law of the dummy's joint" else 0
        equation = own[0] if own else ""
        shared = how_shared(form.equations, own)
        rows.append(SharedRow(form.section, name, form.equations[0], equation, shared, varied, others))
    kept = [row for row in rows if row.section in experiments]
    return sorted(kept, key=lambda row: experiments.index(row.section))
