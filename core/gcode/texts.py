"""Texts in the comments of a G-code file: what a converter might stumble over is written as %23, as in an address."""

from __future__ import annotations

import re
from urllib.parse import quote, unquote

# No sign but printable ASCII, none that means something to a converter, no blanks that a reader would strip.
_RISKY = re.compile(r"[^ -~]|[#@;()%]|^ | $")


def written(text: str) -> str:
    """The text as it may stand in a comment."""
    return _RISKY.sub(lambda sign: quote(sign.group().encode("utf-8", "surrogatepass"), safe=""), text)


def read_back(text: str) -> str:
    """The text that `written` was given."""
    return unquote(text, errors="surrogatepass")
