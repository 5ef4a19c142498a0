"""Pictures on shapes: plates, cylinders and lamp shades that bear one, and how well their prints show it."""
