"""From tone to shape (paper, section 3.1).

`modulation.py` says how deep each color's wave is and how far its line is set back; `strand_edges.py` and
`solid_regions.py` change that where a strand needs room or no pattern is wanted. `wave.py` draws the outer wall, in as
few points as `chords.py` can.
"""
