"""Methods of every treadmill model, as a model without knowledge of the load on the belt has them."""

from abc import ABC, abstractmethod

import numpy as np

from tepsipe.treadmill.recording import BeltRecording


class BeltModel(ABC):
    """Base of the treadmill models, which predict the belt-induced load (N or N·m)."""

    @property
    def holds_errors(self) -> bool:
        """True if it holds draws of its constants' errors, and residuals of held-out trials."""
        return False

    @property
    def untracked(self) -> "BeltModel | None":
        """The model below one that tracks ripple (N or N·m); None where no ripple is tracked."""
        return None

    @abstractmethod
    def predict(self, recording: BeltRecording) -> np.ndarray:
        """Belt-induced load (N or N·m), shape (n,)."""

    def compensate(
        self, recording: BeltRecording, force: np.ndarray | None = None, friction: np.ndarray | None = None
    ) -> np.ndarray:
        """Measured load less the belt-induced one (N or N·m), shape (n,).

        ``force`` is the true fore-aft force (N), ``friction`` the belt's friction (N) where known already,
        both of shape (n,), for models that need them.
        """
        return recording.load - self.predict(recording)

    def added_per_kg(self, recording: BeltRecording) -> np.ndarray:
        """Load that another kg on the belt would add, before the frame's response (N or N·m), shape (n,)."""
        return np.zeros(recording.load.size)

    def shared_friction(self, other: "BeltModel", recording: BeltRecording) -> np.ndarray | None:
        """Friction of the belt (N), shape (n,), if ``other`` has the same; None without such friction."""
        return None
