"""Union-find with parity: sets that are joined, each member with a sign relative to the root.

Members name one nearer to the root; a root names itself. It is the lowest number of its set.
"""

import numpy as np

from pcsmooth.kernels.compiled import inner, kernel


@inner
def find(i, roots, signs):
    """Root of a member and its sign relative to it; halves the path on the way."""
    sign = 1
    while roots[i] != i:
        above = roots[i]
        signs[i] *= signs[above]
        roots[i] = roots[above]
        sign *= signs[i]
        i = roots[i]
    return i, sign


@inner
def join(i, j, relation, roots, signs):
    """Join the sets of i and j, if they are two, so that sign_i sign_j = relation.

    Returns whether they were two.
    """
    root_i, sign_i = find(i, roots, signs)
    root_j, sign_j = find(j, roots, signs)
    if root_i == root_j:
        return False
    if root_i > root_j:
        root_i, root_j = root_j, root_i
    roots[root_j] = root_i
    signs[root_j] = sign_i * sign_j * relation
    return True


@inner
def flatten(start, stop, roots, signs):
    """Let the members from start on name their roots; those before them do so already."""
    for i in range(start, stop):
        signs[i] *= signs[roots[i]]
        roots[i] = roots[roots[i]]


@inner
def lowest_members(roots, numbers):
    """Member with the lowest number (n,) of the set of each root; any for the others, (n,)."""
    members = np.empty(roots.size, roots.dtype)
    for i in range(roots.size):
        members[i] = i
    for i in range(roots.size):
        if numbers[i] < numbers[members[roots[i]]]:
            members[roots[i]] = i
    return members


@kernel("j1 s1 i1")
def refer_to_lowest(roots, signs, numbers):
    """Lowest number (n,) in the set of each member, and its sign relative to that member's.

    Unlike a root, this member is the same whatever order the members are in.
    """
    members = lowest_members(roots, numbers)
    names = np.empty(roots.size, np.int64)
    relations = np.empty(roots.size, np.int8)
    for i in range(roots.size):
        member = members[roots[i]]
        names[i] = numbers[member]
        relations[i] = signs[i] * signs[member]
    return names, relations
