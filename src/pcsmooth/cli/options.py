"""Arguments and options that commands share, and the types of their values."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import TYPE_CHECKING, Any, Literal

import click
from click.shell_completion import CompletionItem

if TYPE_CHECKING:
    from pcsmooth.files.output_columns import Convention, Dialect
    from pcsmooth.files.writing import Writing

STANDARD_STREAM = "-"

WRITTEN_SUFFIXES = ".ply .xyz .xy .txt .asc .csv .pts .las .laz .pcd .obj .off .stl"
"""Suffixes of `pcsmooth.formats.WRITTEN_FORMATS`, which help must not load."""

#: Fewest points to which a normal is fitted.
_SMALLEST_SUPPORT = 3

Command = Callable[..., Any]


class Named(click.ParamType[str]):
    """A file or a folder: checked when it is opened, offered by shells that complete words."""

    def __init__(self, kind: Literal["file", "dir"] = "file") -> None:
        self.name = kind

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Refuse what no file can be called; a file of options can say it."""
        if "\0" in str(value):
            self.fail(f"{value!r} has a null character, which no name has", param, ctx)
        return value

    def shell_complete(
        self, _context: click.Context, _param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Leave it to the shell, which knows the names."""
        return [CompletionItem(incomplete, type=self.name)]


class NameSuffix(click.ParamType[str]):
    """What is put behind the stem of a name: it leads to no other folder."""

    name = "text"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Refuse what would not stay within the name."""
        if any(sign in str(value) for sign in {"/", os.sep, "\0"}):
            self.fail(f"{value!r} is not part of a name; --output-dir names a folder", param, ctx)
        return value


inputs_argument = click.argument("names", metavar="INPUT...", type=Named(), nargs=-1, required=True)

recursive_option = click.option(
    "--recursive",
    is_flag=True,
    help="Folders stand for what is in their sub-folders, too; results go to sub-folders alike.",
)

jobs_option = click.option(
    "--jobs",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    metavar="N",
    help="Files that are worked on at a time, each by a process and its share of the threads.",
)

overwrite_option = click.option("--overwrite", is_flag=True, help="Replace files that exist.")

noise_class_option = click.option(
    "--keep-noise-class",
    "keeps_noise",
    is_flag=True,
    help="Let points of LAS classes 7 and 18 (noise), and withheld ones, take part. Without it "
    "they stay where they are and act on nothing.",
)

threads_option = click.option(
    "--threads",
    type=click.IntRange(min=1),
    metavar="N",
    help="Threads to use [default: all]. The result does not depend on it.",
)

quiet_option = click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors.")

json_option = click.option("--json", "as_json", is_flag=True, help="Summary as JSON on stdout.")


def whole_number(text: str) -> int | None:
    """Read a number without sign; None if it is none, or has more digits than any that is meant."""
    from pcsmooth.formats.number_text import is_whole

    return int(text) if is_whole(text) else None


class Radius(click.ParamType[str]):
    """A length, 3x, 2%, auto, local or local:3x; checked here, resolved when the cloud is known."""

    name = "value"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Check the value and hand it on."""
        from pcsmooth.errors import InvalidInputError

        try:
            self.check(value)
        except InvalidInputError as error:
            self.fail(str(error), param, ctx)
        return value

    def check(self, value: Any) -> None:
        """Raise `InvalidInputError` unless the value is understood."""
        from pcsmooth.lengths import check_radius

        check_radius(value)


class Length(Radius):
    """A length, 3x or 2%; like a radius, but never automatic."""

    def __init__(self, quantity: str) -> None:
        self.quantity = quantity

    def check(self, value: Any) -> None:
        """Raise `InvalidInputError` unless the value is understood."""
        from pcsmooth.lengths import check_length

        check_length(value, self.quantity)


class Positive(click.ParamType[float | str]):
    """A positive number."""

    name = "number"
    wanted = "not a positive number"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Turn the number into a float."""
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not (math.isfinite(number) and number > 0.0):
            self.fail(f"{value!r} is {self.wanted}", param, ctx)
        return number


class Step(Positive):
    """A positive number or auto."""

    name = "value"
    wanted = "neither a positive number nor auto"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Turn a number into a float and leave auto alone."""
        return value if value == "auto" else super().convert(value, param, ctx)


class Place(click.ParamType["tuple[float, ...]"]):
    """Two or three coordinates."""

    name = "place"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Turn the numbers into floats."""
        try:
            place = tuple(map(float, str(value).split(",")))
        except ValueError:
            place = ()
        if len(place) not in (2, 3) or not all(map(math.isfinite, place)):
            self.fail(f"{value!r} is not two or three numbers, such as 1.5,0,1.7", param, ctx)
        return place


class Support(click.ParamType[int | str]):
    """A number of points, or auto."""

    name = "points"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Turn a number into an int and leave auto alone."""
        if value == "auto":
            return value
        number = whole_number(str(value))
        if number is None or number < _SMALLEST_SUPPORT:
            self.fail(
                f"{value!r} is neither a number of points, {_SMALLEST_SUPPORT} or more, nor auto",
                param,
                ctx,
            )
        return number


class Orient(click.ParamType[str]):
    """Where normals point; checked here, without spaces, which a comment might break at."""

    name = "rule"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Check the rule and hand it on."""
        from pcsmooth.curvature.orientation import parse_orientation
        from pcsmooth.errors import InvalidInputError

        rule = "".join(str(value).split())
        try:
            parse_orientation(rule)
        except InvalidInputError as error:
            self.fail(str(error), param, ctx)
        return rule


class Colormap(click.ParamType[str]):
    """A color map that is there."""

    name = "name"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Check the name and hand it on."""
        from pcsmooth.errors import InvalidInputError
        from pcsmooth.files.colors import check_colormap

        try:
            check_colormap(value)
        except InvalidInputError as error:
            self.fail(str(error), param, ctx)
        return value


radius_option = click.option(
    "--radius",
    type=Radius(),
    default="auto",
    show_default=True,
    help="Radius of the balls, or what the polyhedron is scaled by: a length, 3x (times the mean "
    "spacing), 2% (of the bounding box's diagonal), auto (2x, or local where that is too small for "
    "much of a surface; flows 2x), or local or local:3x (2 or 3 times the spacing around each "
    "point).",
)

_PRESETS_OPTIONS = (
    click.option(
        "--presets",
        "presets_path",
        type=Named(),
        metavar="FILE",
        help="TOML file with further bodies, a table for each: normals and offsets, vertices, "
        "mesh, generator or base, and if wanted center, scale and rotate.",
    ),
    click.option(
        "--allow-outside",
        is_flag=True,
        help="With --presets: read meshes outside of the folder of the file too.",
    ),
)


def presets_options(command: Command) -> Command:
    """Give a command a file of presets, as the keywords `presets_path` and `allow_outside`."""

    @wraps(command)
    def collected(*, presets_path: str | None, allow_outside: bool, **others: Any) -> Any:
        if allow_outside and presets_path is None:
            raise click.UsageError("--allow-outside needs --presets")
        return command(presets_path=presets_path, allow_outside=allow_outside, **others)

    for option in reversed(_PRESETS_OPTIONS):
        collected = option(collected)
    return collected


support_option = click.option(
    "--support",
    type=Support(),
    default="auto",
    show_default=True,
    help="Points to which normal and curvature are fitted, 3 or more; auto chooses from the noise "
    "in the cloud.",
)

orient_option = click.option(
    "--orient",
    type=Orient(),
    default="auto",
    show_default=True,
    help="Where normals point: outward, propagate (the highest point's up), input (as the "
    "input's nx ny nz), viewpoint=X,Y,Z, direction=X,Y,Z; auto is input where there are normals, "
    "else outward, and open sheets along the positive leading axis.",
)


@dataclass(frozen=True)
class Reading:
    """How clouds are read.

    Attributes
    ----------
    dim : {"auto", 2, 3}
        Number of coordinates.
    columns : tuple of str or None
        Columns of the coordinates in a text file, by names or numbers; None if the file says.
    among_text : bool
        Whether there are text files among the inputs, so that others are read without `columns`.
    """

    dim: Literal["auto", 2, 3] = "auto"
    columns: tuple[str, ...] | None = None
    among_text: bool = False


class Columns(click.ParamType["tuple[str, ...]"]):
    """Names or numbers of the columns of two or three coordinates."""

    name = "x,y,z"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Part the names."""
        names = tuple(name.strip() for name in str(value).split(","))
        if len(names) not in (2, 3) or not all(names):
            self.fail(f"{value!r} does not name two or three columns, such as 2,3,4", param, ctx)
        return names


_READING_OPTIONS = (
    click.option(
        "--dim",
        type=click.Choice(["auto", "2", "3"]),
        default="auto",
        show_default=True,
        callback=lambda _context, _option, value: value if value == "auto" else int(value),
        help="Number of coordinates. auto takes what the file has; with 2, x and y are points of "
        "a plane curve and a third coordinate is kept like any other column.",
    ),
    click.option(
        "--columns",
        type=Columns(),
        help="Columns of the coordinates in a text file, names or numbers from 1, such as E,N,H or "
        "2,3,4; two are those of a plane curve, and other files among several keep theirs "
        "[default: as the header says, else the first].",
    ),
)


def reading_options(command: Command) -> Command:
    """Give a command the options of `Reading`, and one of these as the keyword `reading`."""

    @wraps(command)
    def collected(
        *, dim: Literal["auto", 2, 3], columns: tuple[str, ...] | None, **others: Any
    ) -> Any:
        if columns is not None and dim not in ("auto", len(columns)):
            raise click.UsageError(f"--columns names {len(columns)} coordinates, --dim wants {dim}")
        return command(reading=Reading(dim, columns), **others)

    for option in reversed(_READING_OPTIONS):
        collected = option(collected)
    return collected


@dataclass(frozen=True)
class Files:
    """The files of a command that writes a cloud for each.

    Attributes
    ----------
    names : tuple of str
        Files, folders or patterns; a single - is stdin.
    output : str or None
        Where the only one goes; - is stdout.
    folder : str or None
        Where each of many goes.
    suffix : str
        What is put behind the stems of their names.
    recursive : bool
        Whether folders stand for what is in their sub-folders, too.
    skip_existing : bool
        Whether those whose result is there are left alone.
    jobs : int
        How many are worked on at a time.
    """

    names: tuple[str, ...]
    output: str | None = None
    folder: str | None = None
    suffix: str = ""
    recursive: bool = False
    skip_existing: bool = False
    jobs: int = 1


_FILES_OPTIONS = (
    inputs_argument,
    click.option(
        "-o",
        "--output",
        "output",
        type=Named(),
        metavar="OUTPUT",
        help=f"File to write; its suffix chooses the format ({WRITTEN_SUFFIXES}), "
        "with .gz or .zst behind it compressed. "
        "- is stdout, in the format of the input.",
    ),
    click.option(
        "--output-dir",
        "folder",
        type=Named("dir"),
        metavar="DIR",
        help="Folder for the results of many inputs, under their names (.e57 and .ptx become "
        ".ply, .copc.laz .laz); made if it is not there. A file that fails does not stop the "
        "others.",
    ),
    click.option(
        "--suffix",
        type=NameSuffix(),
        default="",
        metavar="TEXT",
        help="With --output-dir: what to put behind the stem of each name, such as _smooth; "
        "_smooth.ply also chooses the format.",
    ),
    recursive_option,
    click.option(
        "--skip-existing",
        is_flag=True,
        help="With --output-dir: leave files alone whose result is there and up to date, to resume "
        "a batch. Results that pcsmooth made of another input or by other options are made anew; "
        "those that it does not know are left alone without --overwrite.",
    ),
    jobs_option,
)


def files_options(command: Command) -> Command:
    """Give a command the options of `Files`, and one of these as the keyword `files`."""

    @wraps(command)
    def collected(
        *,
        names: tuple[str, ...],
        output: str | None,
        folder: str | None,
        suffix: str,
        recursive: bool,
        skip_existing: bool,
        jobs: int,
        **others: Any,
    ) -> Any:
        if folder is None:
            if output is None:
                raise click.UsageError("give -o OUTPUT, or --output-dir DIR for many files")
            if len(names) > 1:
                raise click.UsageError("-o is for one input; give --output-dir DIR for many")
            for name, is_given in (
                ("--suffix", suffix), ("--recursive", recursive),
                ("--skip-existing", skip_existing), ("--jobs", jobs > 1),
            ):  # fmt: skip
                if is_given:
                    raise click.UsageError(f"{name} needs --output-dir")
        elif output is not None:
            raise click.UsageError("-o and --output-dir exclude each other")
        files = Files(names, output, folder, suffix, recursive, skip_existing, jobs)
        return command(files=files, **others)

    for option in reversed(_FILES_OPTIONS):
        collected = option(collected)
    return collected


position_type_option = click.option(
    "--float/--double",
    "single",
    default=None,
    help="Type of the positions in the output [default: as in the input, float in a new PCD file].",
)

_WRITING_OPTIONS = (
    click.option(
        "--mean-convention",
        "convention",
        type=click.Choice(["half", "sum"]),
        default="half",
        show_default=True,
        help="Mean curvature written: half is (k1+k2)/2, sum is k1+k2. In 2D there is only k.",
    ),
    click.option(
        "--dialect",
        type=click.Choice(["generic", "meshlab", "cloudcompare", "pcl"]),
        default="generic",
        show_default=True,
        help="Columns of a PLY file: all, or only those that one program reads. pcl makes the "
        "positions float, unless --double is given. Files of other formats get the same in any "
        "dialect.",
    ),
    click.option(
        "--colormap",
        type=Colormap(),
        help="Write red green blue too, by this color map of matplotlib, such as coolwarm.",
    ),
    click.option(
        "--color-by",
        type=click.Choice(["mean", "gaussian", "k1", "k2", "confidence"]),
        help="Estimate that --colormap shows [default: mean].",
    ),
    position_type_option,
    click.option(
        "--columns-extra",
        "extra_columns",
        type=click.Choice(["spacing", "sigma", "sigma_after"]),
        multiple=True,
        help="Write this column, too: spacing, how far points are apart along the surface around "
        "each of them, which needs the whole cloud in memory; sigma, the noise that the filter of "
        "denoise found of each; sigma_after, the error along the normal that it leaves.",
    ),
)


def check_writing(writing: Writing, scheme: str) -> None:
    """Refuse columns that a scheme, "" if no point moves, does not find."""
    from pcsmooth.errors import InvalidInputError

    try:
        writing.check_moved_by(scheme)
    except InvalidInputError as error:
        raise click.UsageError(str(error)) from error


def writing_options(command: Command) -> Command:
    """Give a command the options of `Writing`, and one of these as the keyword `writing`."""

    @wraps(command)
    def collected(
        *,
        convention: Convention,
        dialect: Dialect,
        colormap: str | None,
        color_by: str | None,
        single: bool | None,
        extra_columns: tuple[str, ...],
        **others: Any,
    ) -> Any:
        if color_by is not None and colormap is None:
            raise click.UsageError("--color-by needs --colormap")
        from pcsmooth.files.writing import Writing

        writing = Writing(convention, dialect, colormap, color_by or "mean", single, extra_columns)
        return command(writing=writing, **others)

    for option in reversed(_WRITING_OPTIONS):
        collected = option(collected)
    return collected
