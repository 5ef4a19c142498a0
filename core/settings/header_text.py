"""Texts in the comments of a G-code file: characters that converters may misread are percent-encoded, as in URLs."""

from __future__ import annotations

import re
from urllib.parse import quote, unquote

# Anything but printable ASCII, characters with a meaning for converters, and blanks at the ends.
_RISKY = re.compile(r"[^ -~]|[#@;()%]|^ | $")


def written(text: str) -> str:
    """The text as it may stand in a comment."""
    return _RISKY.sub(lambda sign: quote(sign.group().encode("utf-8", "surrogatepass"), safe=""), text)


def read_back(text: str) -> str:
    """The inverse of `written`; a text that is no such thing stays as it is."""
    try:
        return unquote(text, errors="surrogatepass")
    except UnicodeDecodeError:
        return text
