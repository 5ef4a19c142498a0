"""Dual-Color Print: pictures on shapes for printers with two nozzles.

Nothing heavy is imported before `register()`.
"""

from __future__ import annotations


def register() -> None:
    """Add the operators, panels and properties to Blender."""
    from . import registration

    registration.register()


def unregister() -> None:
    """Remove all that `register` added."""
    from . import registration

    registration.unregister()
