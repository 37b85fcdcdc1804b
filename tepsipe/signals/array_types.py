"""Types of the arguments of public functions, for editors and type checkers."""

from typing import Any, Protocol

import numpy.typing as npt


class WithUnit(Protocol):
    """Samples that name their unit, such as `tepsipe.Signal`."""

    @property
    def values(self) -> Any:
        """The samples (``unit``)."""

    @property
    def unit(self) -> Any:
        """Unit of the samples."""


Samples = npt.ArrayLike | WithUnit
