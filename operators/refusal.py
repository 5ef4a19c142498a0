"""How an operator tells that something cannot be done."""

from __future__ import annotations

import bpy

from ..bridge.properties import as_shown
from ..core.errors import PrintError


def refused(operator: bpy.types.Operator, problem: PrintError) -> set[str]:
    """Report a problem, with settings named as the sidebar names them; what the operator returns."""
    operator.report({"ERROR"}, as_shown(str(problem)))
    return {"CANCELLED"}
