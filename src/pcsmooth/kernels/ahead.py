"""Kernels compiled ahead, or by other processes while this one works, before they are needed."""

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from multiprocessing import parent_process
from multiprocessing.process import BaseProcess
from pathlib import Path

from pcsmooth import machine
from pcsmooth.child_processes import deaf_to_interrupts, spawning, when_parent_ends
from pcsmooth.kernels.cache import is_kept
from pcsmooth.kernels.claims import is_claimed
from pcsmooth.kernels.compiled import KERNELS, Kernel, on_compilation

#: What a run needs that is asked for nothing special, in the order in which it does.
USUAL = (
    "grid/grid._bounding_boxes",
    "grid/grid._code_points",
    "grid/radix_sort._count_digits",
    "grid/radix_sort._move_pairs",
    "grid/grid.gather_points",
    "grid/k_nearest.mean_k_nearest_distances",
    "surface/neighborhood_planes.fit_planes",
    "surface/neighborhood_means.neighborhood_means",
    "surface/neighbor_lists.list_neighbors",
    "grid/grid.match_in_cells",
    "surface/tangential_repulsion.repel",
    "balls/restricted_cells.measure_restricted_cells",
    "surface/cell_normals.gather_terms",
    "surface/cell_normals.normals_from_cells",
    "surface/nested_supports.fit_nested_supports",
    "surface/spanning_forest._join_blocks",
    "surface/parity_union_find.refer_to_lowest",
    "surface/spanning_forest._note_exits",
    "surface/forest_pieces._collect_edges",
    "surface/forest_pieces._join_in_order",
    "surface/component_sums.add_places",
    "surface/component_sums.add_fluxes",
    "surface/shape_operators._count_clusters",
    "surface/shape_operators._sum_clusters",
    "surface/shape_operators.fit_shape_operators",
)

#: Which of these only the filter needs.
_OF_FILTER = (
    "surface/neighborhood_planes.fit_planes",
    "surface/neighborhood_means.neighborhood_means",
    "surface/neighbor_lists.list_neighbors",
    "surface/tangential_repulsion.repel",
)

#: What a flow on unions of polyhedra needs in place of the filter's, by how the union is computed.
_OF_UNIONS = {
    "naive": ("polyhedra/polyhedral_cells.measure_polyhedral_cells",),
    "inclusion-exclusion": (
        "polyhedra/polyhedron_intersections.list_simplices",
        "polyhedra/polyhedron_intersections.measure_intersections",
        "polyhedra/polyhedral_cells.measure_polyhedral_cells",
    ),
    "exact": (
        "polyhedra/visible_facets.measure_visible_facets",
        "polyhedra/polyhedral_cells.measure_polyhedral_cells",
    ),
}
_OF_ALL_UNIONS = ("polyhedra/union_rows.add_spilled",)

#: That which takes longest, half of the time of all: others begin with it.
_LONGEST = "balls/restricted_cells.measure_restricted_cells"

#: Processes that help at most.
_MOST_HELPERS = 3

#: Missing kernels that are worth a process.
_WORTH_HELP = 3


def usual_kernels(union: str | None = None) -> tuple[str, ...]:
    """List what a run needs, in the order in which it does: with polyhedra, by their union."""
    if union is None:
        return USUAL
    of_flow = [name for name in USUAL if name not in _OF_FILTER]
    place = of_flow.index(_LONGEST)
    return (*of_flow[:place], *_OF_UNIONS[union], *_OF_ALL_UNIONS, *of_flow[place:])


def missing(names: Sequence[str]) -> list[str]:
    """List which of some kernels have not been compiled and kept for the usual arguments."""
    return [name for name in names if not is_kept(*name.split("/"))]


def missing_of_all() -> list[str]:
    """List which kernels have not been compiled and kept for all their signatures."""
    for module in Path(__file__).parent.glob("*/*.py"):
        if module.stem != "__init__":
            import_module(f"pcsmooth.kernels.{module.parent.name}.{module.stem}")
    others = sorted(set(map("/".join, KERNELS)) - set(USUAL))
    return [
        name
        for name in [*USUAL, *others]
        if not is_kept(*name.split("/"), len(_kernel(name).signatures))
    ]


@contextmanager
def compiling_ahead(
    announce: Callable[[int, int], None], union: str | None = None
) -> Iterator[None]:
    """Have other processes compile the kernels that a usual run needs, from the last one on.

    The longest they begin with. If this process needs one that another is at, it compiles others
    meanwhile.

    Parameters
    ----------
    announce : callable
        Told when this process has to compile a kernel, or to wait for it: how many of the usual
        ones have been compiled, and how many there are.
    union : str, optional
        How the union of polyhedra is computed, if there are any.
    """
    names = usual_kernels(union)

    def listener(kernel: Kernel) -> None:
        announce(len(names) - len(missing(names)), len(names))
        _compile_meanwhile(kernel, names)

    helpers = [] if parent_process() is not None else _start_helpers(missing(names))
    try:
        with on_compilation(listener):
            yield
    finally:
        for helper in helpers:
            helper.terminate()


def _compile_meanwhile(awaited: Kernel, names: Sequence[str]) -> None:
    """Compile other kernels, as long as another process is at the one that is needed."""
    for name in names:
        if not is_claimed(awaited.family, awaited.name):
            return
        kernel = _kernel(name)
        place = kernel.family, kernel.name
        if kernel is not awaited and not is_kept(*place) and not is_claimed(*place):
            kernel.make_ready(wait=False)


def warm_up(names: Sequence[str], done: Callable[[], object]) -> None:
    """Compile kernels for all their signatures, by several processes.

    Parameters
    ----------
    names : sequence of str
        Those that are missing.
    done : callable
        Called when one is there.
    """
    helpers = _start_helpers(names, for_all=True)
    for name in names:
        _kernel(name).make_ready(for_all=True)
        done()
    for helper in helpers:
        helper.join()


def _start_helpers(names: Sequence[str], *, for_all: bool = False) -> list[BaseProcess]:
    """Start processes that compile kernels, if that is worth while."""
    count = min(machine.cores() - 1, _MOST_HELPERS)
    if len(names) < _WORTH_HELP or count < 1:
        return []
    context = spawning()
    helpers = [
        context.Process(target=_help, args=(names, for_all), name="compiler", daemon=True)
        for _ in range(count)
    ]
    started: list[BaseProcess] = []
    with deaf_to_interrupts(), suppress(OSError):  # where there are no more processes to be had
        for helper in helpers:
            helper.start()
            started.append(helper)
    return started


def _help(names: Sequence[str], for_all: bool) -> None:
    """Compile kernels, the longest and then from the last one on, but for what others are at."""
    when_parent_ends(lambda: os._exit(0))
    first = [name for name in names if name == _LONGEST]
    for name in [*first, *(name for name in reversed(names) if name not in first)]:
        kernel = _kernel(name)
        if not is_kept(kernel.family, kernel.name, len(kernel.signatures) if for_all else 1):
            with suppress(Exception):  # of which the process that needs it will hear, too
                kernel.make_ready(for_all=for_all, wait=False)


def _kernel(name: str) -> Kernel:
    family, qualified = name.split("/")
    import_module(f"pcsmooth.kernels.{family}.{qualified.split('.')[0]}")
    return KERNELS[family, qualified]
