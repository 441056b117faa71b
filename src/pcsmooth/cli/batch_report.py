"""The report on a batch: a page for each file, and one on all of them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from pcsmooth.cli.batch_table import Column, number_column
from pcsmooth.cli.batch_workers import Done
from pcsmooth.cli.sources import Job
from pcsmooth.errors import CloudFileError

if TYPE_CHECKING:
    from pcsmooth.plots.batch_page import FileOnPage

_INDEX = "index.html"
_SECONDS = number_column("seconds", "seconds")


class BatchReport:
    """The pages on a batch in a folder.

    Parameters
    ----------
    folder : str
        Where they are written.
    results : str
        Where the results of the batch are written.
    """

    def __init__(self, folder: str, results: str) -> None:
        self.folder = folder
        self._results = results

    def check(self, *, overwrite: bool) -> None:
        """Raise an error if the pages cannot be written, or would take the place of others."""
        from pcsmooth.plots.figures import check_matplotlib
        from pcsmooth.plots.page import is_own_page

        check_matplotlib()
        index = self._path(_INDEX)
        if os.path.exists(self.folder) and not os.path.isdir(self.folder):
            raise CloudFileError(self.folder, "is no folder", "name a folder for the pages")
        if os.path.lexists(index) and not (overwrite or is_own_page(index)):
            raise CloudFileError(
                index, "exists already and is no report", "name another folder, or pass --overwrite"
            )

    def page_for(self, job: Job) -> str:
        """Path of the page on a file."""
        assert job.target is not None
        return self._path(os.path.relpath(job.target, self._results) + ".html")

    def thumbnail_for(self, job: Job) -> str:
        """Path of the picture of a file."""
        return str(Path(self.page_for(job)).with_suffix(".png"))

    def with_pages(self, job: Job) -> Job:
        """Tell a job to write a page and a picture, and make the folder for them."""
        from pcsmooth.formats.system_errors import named_system_errors

        with named_system_errors(self.folder):
            os.makedirs(os.path.dirname(self.page_for(job)), exist_ok=True)
        pages = {"report_path": self.page_for(job), "thumbnail_path": self.thumbnail_for(job)}
        return replace(job, options=job.options | pages, beside=tuple(pages.values()))

    def write_index(
        self, jobs: Sequence[Job], told: Sequence[Done], columns: Sequence[Column], seconds: float
    ) -> None:
        """Write the page on all files, with what is known of them so far.

        Raises
        ------
        CloudFileError
            If it cannot be written.
        """
        from pcsmooth.formats.atomic import atomic_write
        from pcsmooth.formats.system_errors import named_system_errors
        from pcsmooth.plots.batch_page import FileOnPage, batch_page

        files = [self._shown(done, columns) for done in told]
        ended = {done.job.source for done in told}
        files += [FileOnPage(job.source, "not done") for job in jobs if job.source not in ended]
        titles = [column.title for column in (*columns, _SECONDS)]
        path = self._path(_INDEX)
        with named_system_errors(path), atomic_write(path) as file:
            file.write(batch_page(files, titles, seconds).encode())

    def _shown(self, done: Done, columns: Sequence[Column]) -> FileOnPage:
        from pcsmooth.plots.batch_page import FileOnPage

        page, picture = self.page_for(done.job), self.thumbnail_for(done.job)
        summary = done.summary
        if done.skipped_as == "current" and done.job.known is not None:
            summary = done.job.known.summary
        cells: tuple[str, ...] = ()
        if summary is not None:
            cells = tuple(column.cell(summary) for column in (*columns, _SECONDS))
        return FileOnPage(
            done.job.source,
            done.outcome,
            cells,
            self._beside(page) if summary is not None else "",
            self._beside(picture) if summary is not None else "",
            done.warnings,
            done.failure,
        )

    def _beside(self, path: str) -> str:
        """Name a file from the index on; nothing if there is none."""
        return Path(os.path.relpath(path, self.folder)).as_posix() if os.path.exists(path) else ""

    def _path(self, name: str) -> str:
        return os.path.join(self.folder, name)
