"""Connected components of stars, chains and pairs, however their nodes are numbered."""

import numpy as np
from dualcolor.core.mesh.components import components, connected


def test_components_of_a_star():
    """Whichever number its middle has."""
    for middle in (0, 700, 1999):
        others = np.setdiff1d(np.arange(2000), middle)
        for order in (others, others[::-1]):
            root = components(np.stack([order, np.full(1999, middle)], axis=1))
            assert len(set(root)) == 1


def test_components_of_a_long_shuffled_chain():
    rng = np.random.default_rng(10)
    names = rng.permutation(30000)
    links = np.stack([names[:-1], names[1:]], axis=1)
    cut = np.arange(len(links)) % 100 != 99
    root = components(rng.permutation(links[cut]))
    assert len(np.unique(root)) == 300
    assert components(np.zeros((0, 3), np.int64)).shape == (0,)


def test_nodes_are_connected_along_edges():
    number = connected(7, np.array([5, 1, 3, 2]), np.array([3, 2, 1, 6]))
    assert len(set(number.tolist())) == 3 and len(set(number[[1, 2, 3, 5, 6]])) == 1
    chain = np.arange(999)
    assert (connected(1000, chain, chain + 1) == 0).all()
    assert connected(3, np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)).tolist() == [0, 1, 2]
