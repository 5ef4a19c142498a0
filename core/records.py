"""Frozen dataclasses that share their methods, since a hundred of them are defined when the program starts.

The standard library writes and compiles six functions for every class, which is nearly half of the time that importing
the program takes. Here the fields are the standard library's own, with all that works on them (`fields`, `replace`,
`asdict`), and only the functions that fill, compare and print instances are shared by all classes.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar

Made = TypeVar("Made")

if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:

    def dataclass(*, frozen: bool) -> Callable[[type[Made]], type[Made]]:
        """As `dataclasses.dataclass`, for classes whose instances do not change.

        Args:
            frozen: must be True; it is there for type checkers and readers.
        """

        def decorated(cls: type[Made]) -> type[Made]:
            made = dataclasses.dataclass(init=False, repr=False, eq=False)(cls)
            made.__init__ = _init_of(made)
            made.__setattr__ = made.__delattr__ = _refused
            made.__eq__, made.__hash__, made.__repr__ = _equal, _hashed, _shown
            return made

        if not frozen:
            raise TypeError("only for frozen dataclasses")
        return decorated


def _init_of(made: type[Any]) -> Callable[..., None]:
    """The `__init__` of a class, from its fields and their defaults."""
    known = {field.name: field for field in dataclasses.fields(made)}
    names = tuple(known)
    usual = {name: field.default for name, field in known.items() if field.default is not dataclasses.MISSING}
    factories = {
        name: field.default_factory for name, field in known.items() if field.default_factory is not dataclasses.MISSING
    }
    checks = hasattr(made, "__post_init__")

    def init(self: Any, *values: Any, **named: Any) -> None:
        given = dict(zip(names, values, strict=False))
        held = usual | {name: make() for name, make in factories.items()} | given | named
        if held.keys() != known.keys() or len(values) > len(names) or not given.keys().isdisjoint(named):
            raise TypeError(f"{made.__name__} takes {', '.join(names)}")
        vars(self).update(held)
        if checks:
            self.__post_init__()

    return init


def _refused(self: Any, name: str, *_: Any) -> NoReturn:
    raise dataclasses.FrozenInstanceError(f"cannot change {name!r} of {type(self).__name__}")


def _values(self: Any) -> tuple[Any, ...]:
    return tuple(getattr(self, field.name) for field in dataclasses.fields(self))


def _equal(self: Any, other: object) -> Any:
    return _values(self) == _values(other) if type(other) is type(self) else NotImplemented


def _hashed(self: Any) -> int:
    return hash(_values(self))


def _shown(self: Any) -> str:
    held = ", ".join(f"{field.name}={getattr(self, field.name)!r}" for field in dataclasses.fields(self) if field.repr)
    return f"{type(self).__qualname__}({held})"
