"""Supports: columns that hold up overhangs during the print and are broken away afterwards."""
