"""Point-cloud files: read one, write one, and say what a conversion would lose."""

from pcsmooth.formats.chunks import WRITTEN_IN_PIECES, open_chunks, write_chunks, write_template
from pcsmooth.formats.cloud_file import CloudChunks
from pcsmooth.formats.position_type import written_position_type
from pcsmooth.formats.registry import (
    FORMATS,
    WRITTEN_FORMATS,
    Naming,
    check_cloud,
    format_of,
    format_of_file,
    has_known_suffix,
    is_text,
    lost_in,
    naming_of,
    output_format,
    read_cloud,
    result_name,
    stored_positions,
    write_cloud,
)
from pcsmooth.formats.text.layout import coordinate_columns

__all__ = [
    "FORMATS",
    "WRITTEN_FORMATS",
    "WRITTEN_IN_PIECES",
    "CloudChunks",
    "Naming",
    "check_cloud",
    "coordinate_columns",
    "format_of",
    "format_of_file",
    "has_known_suffix",
    "is_text",
    "lost_in",
    "naming_of",
    "open_chunks",
    "output_format",
    "read_cloud",
    "result_name",
    "stored_positions",
    "write_chunks",
    "write_cloud",
    "write_template",
    "written_position_type",
]
