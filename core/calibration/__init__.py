"""Tone calibration: the tile that is measured, the readings, and the table made from them (paper, section 6)."""
