"""Scenes as JSON, whatever Python has them in."""

import dataclasses
import json


def _default(value):
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    # Arrays and numbers of numpy, without importing it.
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"a scene can't hold a {type(value).__name__}")


def to_json(scene):
    if isinstance(scene, (list, tuple, int, float, bytes)) or scene is None:
        kind = type(scene).__name__
        raise TypeError(f"a scene is a mapping, a dataclass, a JSON text or a Scene, not {kind}")
    return json.dumps(scene, default=_default)
