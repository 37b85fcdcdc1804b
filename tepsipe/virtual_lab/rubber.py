"""The dummy's rubber joint."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Rubber:
    """A rubber joint that softens as it is bent further and loses more energy as it softens (Payne effect).

    With the part q = phi^2 / (phi^2 + softening_angle^2) of the softening that has taken place, the moment is
    ``stiffness * phi * (1 - softening * q) + (damping + softened_damping * q) * phi'``.

    Attributes
    ----------
    stiffness_Nm_per_rad : float
        Stiffness for small bending (N·m/rad).
    damping_Nms_per_rad : float
        Damping for small bending (N·m·s/rad).
    softening : float
        Part of the stiffness that is lost at large bending, 0 to 1 (-).
    softening_angle_rad : float
        Bending at which half of that is lost (rad).
    softened_damping_Nms_per_rad : float
        Damping that is gained at large bending (N·m·s/rad).
    """

    stiffness_Nm_per_rad: float
    damping_Nms_per_rad: float
    softening: float
    softening_angle_rad: float
    softened_damping_Nms_per_rad: float

    def moment(self, bending: float, rate: float) -> float:
        """Moment (N·m) that opposes a ``bending`` (rad) growing at ``rate`` (rad/s)."""
        square = bending * bending
        part = square / (square + self.softening_angle_rad**2)
        damping = self.damping_Nms_per_rad + self.softened_damping_Nms_per_rad * part
        return self.stiffness_Nm_per_rad * bending * (1.0 - self.softening * part) + damping * rate
