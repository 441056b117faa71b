"""Inclusion-exclusion over the alpha-complex, and its error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import polyhedron_oracles as expect
from pcsmooth_experiments.space.triple_complexes import sum_over
from pcsmooth_experiments.space.union_of_polyhedra import (
    Inclusion,
    judge,
    measure_inclusion,
    outcome_of,
)

pytestmark = pytest.mark.slow

#: Just beyond the spacings at which triangles and edges leave the complex.
BEYOND = (2**0.5 + 1e-6, 2.0 + 1e-6)


@pytest.fixture(scope="module")
def found() -> Inclusion:
    return measure_inclusion((1.2, *BEYOND), (0.0, 45.0), (1.0, 2.0), 60, 40)


def test_triples(found: Inclusion) -> None:
    for triple in found.triples:
        exact = expect.box_union(triple.points, 1.0).volume
        assert triple.exact == pytest.approx(exact, rel=1e-12)
        assert triple.computed == pytest.approx(
            sum_over(triple.alpha_complex, triple.points, 1.0), rel=1e-12
        )
        assert triple.alpha_complex <= triple.nerve


def test_the_case_of_the_report_has_no_error(found: Inclusion) -> None:
    report, triangle, edge = found.triples
    assert (0, 1, 2) in report.alpha_complex - report.square_complex
    assert report.error == pytest.approx(0.0, abs=1e-12)
    assert sum_over(report.square_complex, report.points, 1.0) == pytest.approx(report.exact)
    assert triangle.nerve - triangle.alpha_complex == {(0, 1, 2)}
    shared = np.prod(2 - np.ptp(triangle.points, axis=0))
    assert triangle.computed - triangle.exact == pytest.approx(-shared, rel=1e-9)
    assert edge.nerve - edge.alpha_complex == {(0, 1), (0, 1, 2)}
    overlap = np.prod(2 - np.ptp(edge.points[:2], axis=0))
    in_all = np.prod(2 - np.ptp(edge.points, axis=0))
    assert edge.computed - edge.exact == pytest.approx(overlap - in_all, rel=1e-9)


def test_lattices(found: Inclusion) -> None:
    """Closed forms: a corner that four squares share is missing, or each overlap of two."""
    along, across = found.lattice_errors
    corner, overlap = (2 - BEYOND[0]) ** 2, (2 - 2**0.5) ** 2
    assert along == pytest.approx([0.0, -corner / BEYOND[0] ** 2, 0.0], abs=1e-5)
    assert across == pytest.approx([0.0, 0.0, 2 * overlap / (4 - 2 * overlap)], abs=1e-5)
    assert -corner / 2 == pytest.approx(-0.172, abs=1e-3)
    assert across[2] == pytest.approx(0.207, abs=1e-3)


def test_random_points(found: Inclusion) -> None:
    """Squares at random, against a grid of boxes and a sum over simplices by definition."""
    points, radius = np.random.default_rng(0).random((40, 2)), 40**-0.5
    simplices = expect.alpha_complex(points, radius)
    summed = expect.sum_over_simplices(points, radius, expect.solid("square"), simplices)
    error = summed.volume / expect.box_union(points, radius).volume - 1
    assert found.cloud_errors["random in a square, square"][0] == pytest.approx(error, rel=1e-6)
    assert error > 1e-3


def test_verdict(found: Inclusion) -> None:
    assert judge(found) == "agrees in part"
    report, *others = found.triples
    wrong = replace(report, computed=report.exact + 0.1)
    assert judge(replace(found, triples=(wrong, *others))) == "agrees"
    right = tuple(replace(triple, computed=triple.exact) for triple in found.triples)
    assert judge(replace(found, triples=right)) == "disagrees"


def test_outcome(found: Inclusion) -> None:
    outcome = outcome_of(found)
    assert len(outcome.caption) <= 200
    assert f"-{17.2:.1f} to +{20.7:.1f} % on lattices" in outcome.caption
    triples = outcome.tables["inclusion-exclusion-triples"]
    assert triples["nerve"][0] == "0 1 2 01 02 12 012"
    assert triples["maximum_norm"][0] == "0 1 2 01 12"
