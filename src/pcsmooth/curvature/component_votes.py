"""One sign for each connected component, from sums over points that may come in parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.orientation import Orientation
from pcsmooth.kernels.surface.component_sums import add_fluxes, add_places, add_terms, products

#: A component is closed if its mean normal is shorter than this, and bulges if its normals' flux
#: exceeds this share of the largest possible.
_SHARE = 0.25

#: Sums that differ by less than this share of what they are made of are equal: the order of the
#: points, which decides about rounding, must not decide about signs.
_EQUAL = 1e-9

#: Keeps a division by nothing from being one by 0.
_TINY = np.finfo(float).tiny


@dataclass(frozen=True)
class ComponentSigns:
    """What was decided for the connected components of a cloud.

    Attributes
    ----------
    signs : ndarray, shape (c,)
        1 or -1, what normals that agree with each other are multiplied by.
    reasons : ndarray of str, shape (c,)
        outward, axis, input, viewpoint, direction or propagate.
    has_normals : ndarray of bool, shape (c,)
        Whether any point has a normal.
    follows_given : bool
        Whether the rule is one that takes over the normals of the input.
    """

    signs: npt.NDArray[np.float64]
    reasons: npt.NDArray[np.object_]
    has_normals: npt.NDArray[np.bool_]
    follows_given: bool

    def flips_of(
        self,
        normals: npt.NDArray[np.float64],
        labels: npt.NDArray[np.integer],
        given: npt.NDArray[np.float64] | None = None,
    ) -> npt.NDArray[np.float64]:
        """Return what each of some points' normals is to be multiplied by.

        Parameters
        ----------
        normals : ndarray, shape (n, d)
            Their normals, as they were when the votes were added.
        labels : ndarray of int, shape (n,)
            Their components.
        given : ndarray, shape (n, d), optional
            Normals of the input, zero where there is none; these override the components' signs.

        Returns
        -------
        ndarray, shape (n,)
            1 or -1.
        """
        flips: npt.NDArray[np.float64] = self.signs[labels]
        if self.follows_given and given is not None:
            agreement = np.sign(products(given, normals))
            np.copyto(flips, agreement, where=agreement != 0.0)
        return flips

    def counts(self) -> dict[str, int]:
        """Return how many components that have normals got their sign for which reason."""
        names, numbers = np.unique(self.reasons[self.has_normals].astype(str), return_counts=True)
        return dict(zip(names.tolist(), numbers.tolist(), strict=True))


class ComponentVotes:
    """Sums over the components of a cloud that decide which way their normals look.

    First `add_places` goes over all points, then `add_votes`, both in any number of parts and in
    any order; then `decide` says what came out. Within each component normals must agree already
    (see `join_parts`).

    Parameters
    ----------
    orientation : Orientation
        The rule; a viewpoint is in the frame of the points. See `find_oriented_normals`.
    dimension : int
        d.
    count : int
        Number of components, c.

    Raises
    ------
    InvalidInputError
        If the rule's vector has another dimension.

    Notes
    -----
    Votes that cancel up to a share of 1e-9 leave the sign as it is, and of axes along which the
    mean normal is equally long, up to the same share, the first leads: so the order of the points
    does not matter.
    """

    def __init__(self, orientation: Orientation, dimension: int, count: int) -> None:
        self._rule = orientation.rule
        self._vector = np.zeros(dimension)
        if self._rule in ("viewpoint", "direction"):
            self._vector = orientation.vector_in(dimension)
        self._follows_given = self._rule in ("input", "auto")
        self._by_flux = self._follows_given or self._rule == "outward"
        # Sums over each component, and the sums of their terms' absolute values.
        self._votes, self._sizes = np.zeros(count), np.zeros(count)
        self._given_votes, self._given_sizes = np.zeros(count), np.zeros(count)
        self._has_normals = np.zeros(count, np.bool_)
        self._is_given = np.zeros(count, np.bool_)
        self._highest = np.full(count, -np.inf)
        self._totals = np.zeros(count)
        self._moments = np.zeros((dimension, count))
        self._normal_sums = np.zeros((dimension, count))
        self._centers: npt.NDArray[np.float64] | None = None

    def add_places(
        self,
        points: npt.NDArray[np.float64],
        areas: npt.NDArray[np.float64],
        labels: npt.NDArray[np.integer],
    ) -> None:
        """Add where some points are.

        Parameters
        ----------
        points : ndarray, shape (n, d)
            Positions, L.
        areas : ndarray, shape (n,)
            Weight of each in its component.
        labels : ndarray of int, shape (n,)
            Their components, from 0.
        """
        if self._by_flux:
            add_places(points, areas, labels, self._totals, self._moments)
        elif self._rule == "propagate":
            np.maximum.at(self._highest, labels, points[:, -1])

    def add_votes(
        self,
        points: npt.NDArray[np.float64],
        normals: npt.NDArray[np.float64],
        areas: npt.NDArray[np.float64],
        labels: npt.NDArray[np.integer],
        given: npt.NDArray[np.float64] | None = None,
    ) -> None:
        """Add which way some points' normals look, after all places are known.

        Parameters
        ----------
        points, areas, labels : ndarray
            As in `add_places`.
        normals : ndarray, shape (n, d)
            Unit normals or zero; those of a component agree.
        given : ndarray, shape (n, d), optional
            Normals of the input, zero where there is none.
        """
        self._has_normals[labels[normals.any(axis=1)]] = True
        if self._by_flux:
            add_fluxes(
                points,
                normals,
                areas,
                labels,
                self._centroids(),
                self._votes,
                self._sizes,
                self._normal_sums,
            )
        else:
            terms = self._terms_of(points, normals, labels)
            add_terms(terms, areas, labels, self._votes, self._sizes)
        if self._follows_given and given is not None:
            agreement = np.sign(products(given, normals))
            self._is_given[labels[(agreement != 0.0) & (areas > 0.0)]] = True
            add_terms(agreement, areas, labels, self._given_votes, self._given_sizes)

    def decide(self) -> ComponentSigns:
        """Return the signs of the components and why they have them.

        Returns
        -------
        ComponentSigns
        """
        count = len(self._votes)
        votes, sizes = self._votes, self._sizes
        reasons = np.full(count, self._rule, object)
        if self._follows_given:
            sums = self._normal_sums
            # Where a sum is just the share that is asked for, rounding must not decide either.
            share = _SHARE * (1.0 + _EQUAL)
            is_sheet = np.linalg.norm(sums, axis=0) > share * self._totals
            is_sheet &= np.abs(votes) <= share * sizes
            lengths = np.abs(sums)
            leading = (lengths >= (1.0 - _EQUAL) * lengths.max(axis=0)).argmax(axis=0)
            votes = np.where(is_sheet, sums[leading, np.arange(count)], votes)
            sizes = np.where(is_sheet, self._totals, sizes)
            reasons[:] = np.where(is_sheet, "axis", "outward")
            votes = np.where(self._is_given, self._given_votes, votes)
            sizes = np.where(self._is_given, self._given_sizes, sizes)
            reasons[self._is_given] = "input"
        signs = np.where(votes < -_EQUAL * sizes, -1.0, 1.0)
        return ComponentSigns(signs, reasons, self._has_normals, self._follows_given)

    def _centroids(self) -> npt.NDArray[np.float64]:
        """Centroids of the components, (d, c)."""
        if self._centers is None:
            self._centers = self._moments / np.where(self._totals > 0.0, self._totals, 1.0)
        return self._centers

    def _terms_of(
        self,
        points: npt.NDArray[np.float64],
        normals: npt.NDArray[np.float64],
        labels: npt.NDArray[np.integer],
    ) -> npt.NDArray[np.float64]:
        """How far each normal (n, d) looks where the rule wants it to, (n,)."""
        if self._rule == "propagate":
            return np.where(points[:, -1] == self._highest[labels], normals[:, -1], 0.0)
        if self._rule == "direction":
            return np.asarray(products(np.tile(self._vector, (len(normals), 1)), normals))
        aims = self._vector - points
        lengths = np.maximum(np.linalg.norm(aims, axis=1), _TINY)
        return np.asarray(products(aims, normals) / lengths)
