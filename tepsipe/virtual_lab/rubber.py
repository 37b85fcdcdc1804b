"""The dummy's rubber joint."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Rubber:
    """A rubber joint that softens a little as it is bent further (the Payne effect).

    The elastic moment is ``stiffness * phi * (1 - softening * phi^2 / (phi^2 + softening_angle^2))``.

    Attributes
    ----------
    stiffness_Nm_per_rad : float
        Stiffness for small bending (N·m/rad).
    damping_Nms_per_rad : float
        Viscous damping (N·m·s/rad).
    softening : float
        Part of the stiffness that is lost at large bending, 0 to 1 (-).
    softening_angle_rad : float
        Bending at which half of that is lost (rad).
    """

    stiffness_Nm_per_rad: float
    damping_Nms_per_rad: float
    softening: float
    softening_angle_rad: float

    def moment(self, bending: float, rate: float) -> float:
        """Moment (N·m) that opposes a ``bending`` (rad) growing at ``rate`` (rad/s)."""
        square = bending * bending
        lost = self.softening * square / (square + self.softening_angle_rad**2)
        return self.stiffness_Nm_per_rad * bending * (1.0 - lost) + self.damping_Nms_per_rad * rate
