"""Texts of small models, and settings that print them fast."""

OPEN_BOX = "v 0 0 0\nv 20 0 0\nv 20 0 20\nv 0 0 20\nv 0 20 0\nv 20 20 0\nv 20 20 20\nv 0 20 20\n"
OPEN_BOX += "f 5 6 7 8\nf 1 4 3 2\nf 2 3 7 6\nf 3 4 8 7\nf 1 5 8 4\n"
CLOSED_BOX = OPEN_BOX + "f 1 2 6 5\n"
FAST = ["--set", "layer_height=0.5", "--set", "first_layer_height=0.5"]
