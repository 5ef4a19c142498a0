"""How much plastic strands hold, worked out from their points alone."""

import numpy as np


def volume_mm3(laid):
    """(K,) mm³ of each strand: length × width × height, the width at a point being that of the line up to it."""
    step = np.linalg.norm(np.diff(laid.points, axis=0, prepend=laid.points[:1]), axis=1)
    step[laid.start[:-1]] = 0.0
    strand = np.repeat(np.arange(len(laid)), np.diff(laid.start))
    return np.bincount(strand, step * laid.width, minlength=len(laid)) * laid.height
