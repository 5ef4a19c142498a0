"""Where the waves sit on the contours: the paper's sampling and the planned one, and the seams that each leaves."""
