"""Permutations taken apart into cycles, by pointer jumping."""

from __future__ import annotations

import numpy as np

from ..model import IntArray


def cycles(successor: IntArray) -> tuple[IntArray, IntArray]:
    """Take a permutation apart into its cycles.

    Args:
        successor: (S,) a permutation.

    Returns:
        (S,) the least member of each one's cycle, and (S,) how many steps after that member it comes.
    """
    root = np.arange(len(successor))
    jump = successor
    while True:
        # Once twice as far ahead nothing less is found, all of the cycle has been looked at.
        ahead = np.minimum(root, root[jump])
        if np.array_equal(ahead, root):
            break
        root, jump = ahead, jump[jump]
    is_root = root == np.arange(len(root))
    steps = np.where(is_root, 0, 1)
    jump = np.where(is_root, root, successor)
    while steps.size and (jump != root).any():
        steps = steps + steps[jump]
        jump = jump[jump]
    size = np.bincount(root, minlength=len(root))[root]
    return root, np.where(is_root, 0, size - steps)
