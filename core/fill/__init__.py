"""The inside of the waved outline: straight walls, gap fill, skins, bridges and sparse fill."""
