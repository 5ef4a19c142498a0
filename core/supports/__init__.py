"""Supports: what holds up the overhangs while they are printed and is broken away afterwards."""
