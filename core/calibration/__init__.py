"""Tone calibration: tiles whose tones are read, the tables made from the readings, and their use (paper, section 6).

- In the job: `calibrate.py` turns tones asked for into tones to print, by a `table.py` and the range to which
  `gamut_mapping.py` maps the picture. `provenance.py` says for which settings a table holds.
- From simulated prints: `tile.py` is printed, seen from many sides by `bridge/measuring/`, averaged by `readings.py`,
  kept by `sweep.py` and shown by `gamut_maps.py` (paper, Figure 7).
- From a photograph: `step_wedge.py` is printed and photographed; `read_photo.py` goes the whole way back, by
  `photograph.py`, `marks.py`, `homography.py` and `photo_table.py`.
"""
