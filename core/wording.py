"""Numbers of things in sentences."""


def counted(count: int, noun: str) -> str:
    """How many there are of what: "1 layer", "2 layers"; for nouns whose plural ends in s."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
