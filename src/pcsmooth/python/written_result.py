"""Results that write themselves into files, and draw themselves."""

from __future__ import annotations

import os
from abc import abstractmethod
from typing import TYPE_CHECKING

from pcsmooth.cloud import PointCloud
from pcsmooth.files.writing import Writing
from pcsmooth.formats import write_cloud
from pcsmooth.python.fact_table import FactTable

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class WrittenResult(FactTable):
    """What becomes a cloud with columns, in memory or in a file, and a figure."""

    @abstractmethod
    def _cloud(self, path: str, writing: Writing | None) -> PointCloud:
        """Make the cloud that is written there."""

    @abstractmethod
    def _figure(self) -> Figure:
        """Draw it."""

    def plot(self) -> Figure:
        """Draw it: surfaces before and after, or what was estimated, in colours.

        Returns
        -------
        matplotlib.figure.Figure
            Notebooks show it; ``.savefig(path)`` writes it.

        Raises
        ------
        PcsmoothError
            If matplotlib is not installed.
        """
        return self._figure()

    def to_cloud(self, writing: Writing | None = None) -> PointCloud:
        """Make the cloud that `save` writes: columns have the names that they have in PLY files.

        Parameters
        ----------
        writing : Writing, optional
            How estimates are written.
        """
        return self._cloud("cloud.ply", writing)

    def save(
        self,
        path: str | os.PathLike[str],
        writing: Writing | None = None,
        *,
        overwrite: bool = True,
    ) -> None:
        """Write the cloud with all that it had, and the columns of the result.

        Parameters
        ----------
        path : path
            The file; its suffix says the format.
        writing : Writing, optional
            How estimates are written.
        overwrite : bool
            Whether a file that is there is replaced, as a whole or not at all.

        Raises
        ------
        CloudFileError
            The file cannot, or must not, be written, or its format cannot hold the cloud.
        """
        write_cloud(self._cloud(os.fspath(path), writing), path, overwrite=overwrite)
