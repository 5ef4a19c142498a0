"""The extruded plastic: strands from moves, oval on material, rounder and sagging over air; as rods and as a mesh."""
