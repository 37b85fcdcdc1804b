"""Forms of the mechanisms that the laboratory simulates, as its modules state them.

The analysis declares its forms under the same names (`tepsipe.reporting.forms`). `tables/shared.csv` compares
the equations, which are written in common symbols for that purpose: p is the operator of Laplace, R the
moment of the joint, tau a torque, [x]_+ the positive part of x.
"""

from typing import NamedTuple


class Form(NamedTuple):
    """Form of one mechanism."""

    section: str
    """Experiment that has it; ``treadmill`` is every experiment on the treadmill."""
    equations: tuple[str, ...]
    """Its equation, and then those to which it reduces where some of its terms are 0 or equal."""
    module: str
    """Module of this package that computes it."""
    written: str
    """Part of the same equation or sentence as it is written in that module."""
    constants: tuple[str, ...]
    """Its constants among those of the laboratory; a path stands for all below it."""


PAYNE = "R = K φ (1 − S q) + (B + B_s q) φ', q = φ² / (φ² + φ_h²)"
RUBBER = tuple(
    f"dummy.rubber.{name}"
    for name in ("stiffness_Nm_per_rad", "damping_Nms_per_rad", "softening", "softened_damping_Nms_per_rad")
)

FORMS = {
    "friction of the belt": Form(
        "treadmill",
        ("F = (F_0 + μ N) [(1 − b) tanh(w / v_0) + b z] + c w",),
        "force_plate",
        "F_friction = (F_0 + mu N) ((1 - b) tanh(v_r / v_0) + b z) + c v_r",
        tuple(
            f"treadmill.plate.{name}"
            for name in (
                *("friction_N", "friction_coefficient", "friction_speed_m_per_s"),
                *("friction_Ns_per_m", "bristle_share"),
            )
        ),
    ),
    "bristles of the belt": Form(
        "treadmill",
        ("d z' = w − |w| z",),
        "force_plate",
        "z' = (x' - |x'| z) / d",
        ("treadmill.plate.bristle_m",),
    ),
    "height at which belt friction acts": Form(
        "treadmill",
        ("M_x = h F",),
        "force_plate",
        "a lever arm below the surface of the belt, and so causes a moment M_x",
        ("treadmill.plate.friction_lever_m",),
    ),
    "lag of the belt": Form(
        "treadmill",
        ("w = v + φ(t) T v'", "w = v + T v'"),
        "force_plate",
        "v_r = v + phi T v'",
        ("treadmill.plate.belt_lag_s", "treadmill.plate.belt_lag_wander"),
    ),
    "modes of the frame": Form(
        "treadmill",
        (
            "F_t = Σ_i q_i (1 + d_i p) / (1 + d_i p + e_i p²) F",
            "F_t = Σ_i q_i (1 + r_i d p) / (1 + r_i d p + r_i² e p²) F",
        ),
        "force_plate",
        "has a mass on a spring and a damper, and the transducers show the forces of both",
        tuple(
            f"treadmill.plate.{name}"
            for name in (
                *("resonance_hz", "resonance_damping", "second_share", "second_hz", "second_damping"),
            )
        ),
    ),
    "frame under load": Form(
        "treadmill",
        ("m (x'' + c x' + k x) = −(F + f_r + m_b v')",),
        "moving_belt",
        "m (x'' + c x' + k x) = -(F + f_r + m_b v')",
        ("treadmill.plate.resonance_mass_kg", "treadmill.plate.felt_belt_mass_kg"),
    ),
    "mounts of the deck": Form(
        "treadmill",
        ("F_t = [1 − s T p / (1 + T p)] F",),
        "force_plate",
        "F_transducer = F - s (T_m d/dt) / (1 + T_m d/dt) F",
        ("treadmill.plate.mount_share", "treadmill.plate.mount_relaxation_s"),
    ),
    "vibration of the floor": Form(
        "treadmill",
        ("F_t = F + m a, a'' + 2 ζ ω a' + ω² a = noise",),
        "force_plate",
        "a fore-aft force that is independent of the perturbations",
        ("treadmill.plate.floor_m_per_s2", "treadmill.plate.floor_hz", "treadmill.plate.floor_damping"),
    ),
    "drive of the belt": Form(
        "treadmill",
        ("u = P e + Q ∫ e dt, e = v_command(t − T) − v",),
        "belt",
        "u = clip(P e + Q q, -u_max, u_max)",
        ("treadmill.drive",),
    ),
    "marker noise": Form(
        "treadmill",
        ("white and Gaussian, with one standard deviation",),
        "treadmill_trial",
        "positions += capture.noise_m * rng.standard_normal(positions.shape)",
        ("treadmill.capture.noise_m",),
    ),
    "sampling instants of the markers": Form(
        "treadmill",
        ("t_j = t + j / f",),
        "treadmill_trial",
        "path(first + k / capture.marker_sampling_hz)",
        ("treadmill.capture.marker_sampling_hz",),
    ),
    "clocks of the instruments": Form(
        "treadmill",
        ("t_2 = (1 + ε) t_1 + t_0",),
        "treadmill_trial",
        "faster = 1.0 + 1e-6 * capture.clock_ppm",
        ("treadmill.capture.clock_ppm", "treadmill.capture.latency_s"),
    ),
    "law of the dummy's joint": Form(
        "dummy",
        (PAYNE,),
        "rubber",
        "R = k phi (1 - S q) (1 + phi^2 / phi_h^2)^(-p/2) + (b + b_s q) phi'",
        (*RUBBER, "dummy.rubber.softening_angle_rad"),
    ),
    "motion of the leg": Form(
        "dummy",
        (
            "(I_l + m r²) θ'' + m r cos θ (y'' + h ψ'') = m g r sin θ − R",
            "(I_l + m r²) θ'' + m r cos θ y'' = m g r sin θ − R",
        ),
        "dummy",
        "m r cos th y'' + (Il + m r^2) th'' + m h r cos th ph'' = m g r sin th - R",
        ("dummy.subject",),
    ),
    "tilt of the dummy's foot": Form(
        "dummy",
        ("J ψ'' + d ψ' + k ψ = R − R_rest + ... (with the motion of belt and leg)",),
        "dummy",
        "= R - R_rest + a g ph - k ph - d ph'",
        ("dummy.foot_tilt",),
    ),
    "bending of the rod": Form(
        "dummy",
        ("x'' + 2 ζ ω x' + ω² x = −a",),
        "dummy_trial",
        "d'' + 2 z w d' + w² d = -a",
        ("dummy.wobble",),
    ),
    "slip of the dummy's markers": Form(
        "dummy", ("random steps, 1 − exp(−t / T)",), "dummy_trial", "1.0 - np.exp(-since)", ("dummy.slip",)
    ),
    "further terms of the rubber": Form(
        "dummy",
        ("R + k_d z + Σ c (φ − s_i), z' = φ' − |φ'| z / φ_d, s_i' = (φ − s_i) / T_i, and a power of φ",),
        "rubber",
        "z' = phi' - |phi'| z / phi_d, s_i' = (phi - s_i) / T_i",
        tuple(
            f"dummy.rubber.{name}"
            for name in ("softening_power", "bristle_Nm_per_rad", "relaxation_share", "relaxation_s")
        ),
    ),
    "load of a weight": Form(
        "weight",
        ("F = M (v' + x'')",),
        "weight_trial",
        "F = m (v' + x'')",
        ("weight.mass_kg", "heavy_weight.mass_kg"),
    ),
    "friction and hardening of the manipulator": Form(
        "wristalyzer",
        ("τ = J θ'' + R + F_c tanh(θ' / w_0) + K_3 θ³",),
        "wristalyzer_trial",
        "J w' = tau + ripple - rubber(th, w) - contact * th^3 - Fc tanh(w / ws)",
        tuple(
            f"wristalyzer.manipulator.{name}"
            for name in ("contact_Nm_per_rad3", "friction_Nm", "friction_rate_rad_per_s")
        ),
    ),
    "torque ripple of the manipulator": Form(
        "wristalyzer",
        ("noise that is unrelated to the command",),
        "wristalyzer_trial",
        "white = trial_rng.standard_normal(applied.size)",
        ("wristalyzer.manipulator.ripple_Nm", "wristalyzer.manipulator.ripple_bandwidth_hz"),
    ),
    "soft tissue": Form(
        "standing",
        ("x'' + 2 ζ ω x' + ω² x = −a",),
        "standing_trial",
        "x'' + 2 d w x' + w^2 x = -a",
        tuple(f"standing.skin.{name}" for name in ("shank_share", "thigh_share", "frequency_hz", "damping")),
    ),
    "skin over the ankle": Form(
        "standing",
        ("x = c φ",),
        "standing_trial",
        "slides forward by a length per rotation of the ankle",
        ("standing.skin.slip_m_per_rad",),
    ),
    "soft feet": Form(
        "standing",
        ("J ψ'' + B_f ψ' + K_f ψ = τ − τ_0 + m_f h_f y''",),
        "person",
        "J psi'' = tau_ankle - tau_0 - K_f psi - B_f psi' + m_f h_f y''",
        tuple(
            f"standing.person.{name}"
            for name in ("foot_stiffness_Nm_per_rad", "foot_damping_Nms_per_rad", "forefoot_share")
        ),
    ),
    "intrinsic torque of the ankle": Form(
        "standing",
        ("τ = B φ' + K φ + K_s z", "τ = B φ' + K φ"),
        "person",
        "tau = tau_0 + K (phi - phi_0) + B phi' intrinsic: without delay",
        ("standing.tasks",),
    ),
    "short-range stiffness": Form(
        "standing",
        ("z' = φ' − |φ'| z / r",),
        "person",
        "z' = phi' - |phi'| z / r",
        (
            "standing.person.short_range_rad",
            "standing.tasks.relax.short_range_Nm_per_rad",
            "standing.tasks.stiff.short_range_Nm_per_rad",
        ),
    ),
    "drive of a reflex": Form(
        "standing",
        ("u = [tone + Σ_i G_i [s(t − L_i) − s_0]_+ + balance]_+", "u = G [s(t − L)]_+"),
        "person",
        "e_m = [tone_m + G_m [s(t - L_m) - s_0]_+ + G_2m [s(t - L_2m) - s_0]_+ + balance]_+",
        (
            "standing.muscles",
            "standing.tasks.relax.medium_reflex_s_per_rad",
            "standing.tasks.stiff.medium_reflex_s_per_rad",
        ),
    ),
    "twitch of a muscle": Form(
        "standing",
        ("T T_2 x'' + (T + T_2) x' + x = u", "T² x'' + 2 T x' + x = u"),
        "person",
        "T T_2 x'' + (T + T_2) x' + x = e",
        ("standing.nerves.twitch_s", "standing.nerves.relaxation_s"),
    ),
    "masses of segments": Form(
        "standing",
        ("shares of the body's mass by de Leva (1996)",),
        "person_constants",
        "Source: P. de Leva (1996)",
        tuple(f"standing.person.{name}" for name in ("foot_mass", "shank_mass", "thigh_mass")),
    ),
    "electromyogram": Form(
        "standing",
        ("u = Σ_j C_j A d_j w_j + artefact + hum + drift + noise",),
        "electromyography",
        "u_i = sum_j C_ij A d_j w_j + G_i (h * a) + H_i (hum) + b_i + n_i",
        ("standing.emg",),
    ),
    "response of a walking ankle": Form(
        "walking",
        ("ΔM = −[I Δθ'' + B(t) Δθ' + K(t) Δθ] + reflex", "ΔM = −[I Δθ'' + B Δθ' + K Δθ]"),
        "walker",
        "dM = -[ I dtheta'' + B(t) dtheta' + K(t) dtheta ] + reflex",
        ("walking.joint",),
    ),
    "torque of ankle and hip": Form(
        "platform",
        ("τ_i = Σ_j [K_ij + B_ij p + (D_ij + E_ij p) exp(−p d_i)] θ_j + n_i",),
        "platform_person",
        "resist their angles (p, q - p) at once and with a delay",
        (),
    ),
    "torque of ankle, knee and hip": Form(
        "several-joints",
        ("τ = K q + B q'",),
        "standing_chain",
        "resist deviations from a posture by a 3 x 3 stiffness and a 3 x 3 damping",
        (),
    ),
}
