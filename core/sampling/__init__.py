"""Where the waves sit on the contours: one sample for each wave, on all layers (paper, section 3.2).

The paper's Algorithm 1 is `paper.py`, step by step:

- assign initial samples on the base layer, insert samples in gaps larger than 2λ: `spacing.filled`
- project samples from layer ℓ - 1 onto layer ℓ: `projector.Projector.project`
- relax sample locations: `spacing.relaxed`
- remove samples closer than λ: `spacing.pruned`

`optimized.py` plans all layers at once instead, on a grid of places that are projected in the same way. Its steps are
told there, with the modules that do them. Both end in `samples.Samples`; `quality.py` measures their seams by the error
of section 6.4, and `visibility.py` says where seams matter less.

Three words are used throughout. The *phase* is a number that grows by 1 from one sample to the next, so waves are
counted by it; it is the paper's angle over 2π, without the flip after every pair of layers. A phase *slides* where it
differs from that of the place's image on the layer above. A wave is *born* or *dies* in between two layers where the
upper one has a sample more or less; there the checkerboard is broken, a *seam*.
"""
