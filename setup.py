"""Build of the wheel, with the files of studies that lie beside the library: rules, defaults, report.

The wheel contains them below ``tepsipe/_study``, with the paths of a checkout
(`workflow/support/places.py`).
"""

import os
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

STUDY = (
    *("Snakefile", "CITATION.cff", "profiles/*/config.yaml", "config/*.yaml", "docs/decisions/0*.md"),
    *("workflow/**/*.py", "workflow/**/*.smk", "workflow/envs/*.yaml"),
    *("report/**/*.typ", "report/*.yaml", "report/*.bib"),
)


def study_files() -> list[str]:
    """Files of studies, by their paths in the checkout."""
    found = {path.as_posix() for pattern in STUDY for path in Path().glob(pattern)}
    return sorted(found)


class BuildWithStudy(build_py):
    """Build of the library with copies of the files of studies; editable installations use the checkout."""

    def run(self):
        """Build and copy."""
        super().run()
        if not self.editable_mode:
            for path in study_files():
                self.mkpath(str(self._target(path).parent))
                self.copy_file(path, str(self._target(path)))

    def get_source_files(self):
        """Files of which the source distribution consists, too."""
        return [*super().get_source_files(), *study_files()]

    def get_outputs(self, include_bytecode=True):
        """Files in the wheel."""
        copied = [] if self.editable_mode else [os.fspath(self._target(path)) for path in study_files()]
        return [*super().get_outputs(include_bytecode), *copied]

    def _target(self, path: str) -> Path:
        return Path(self.build_lib, "tepsipe", "_study", path)


if __name__ == "__main__":
    setup(cmdclass={"build_py": BuildWithStudy})
