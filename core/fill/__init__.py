"""What lies behind the waved outline: straight walls, skins and sparse fill."""
