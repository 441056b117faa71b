"""Point-cloud files: read one, write one, and say what a conversion would lose."""

from pcsmooth.formats.chunks import CloudChunks, open_chunks, write_chunks
from pcsmooth.formats.position_type import written_position_type
from pcsmooth.formats.registry import (
    FORMATS,
    format_of,
    lost_in,
    output_format,
    read_cloud,
    write_cloud,
)

__all__ = [
    "FORMATS",
    "CloudChunks",
    "format_of",
    "lost_in",
    "open_chunks",
    "output_format",
    "read_cloud",
    "write_chunks",
    "write_cloud",
    "written_position_type",
]
