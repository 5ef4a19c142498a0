"""The objects as they are sliced: several on one plate, unwrapped, triangulated, on the bed."""
