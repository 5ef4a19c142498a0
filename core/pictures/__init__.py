"""Pictures on shapes: plates, cylinders and lamp shades that bear one; how well prints show it, seen from how far."""
