"""Files of people: YAML in, and out with innermost maps and lists in one line."""

from __future__ import annotations

import json
import os
import pathlib
from collections.abc import Mapping
from typing import Any

_LARGEST = 4_000_000
_STRANGE = (ValueError, TypeError, LookupError, RecursionError, AttributeError)  # what strange texts make the library raise


def read_yaml(file: str | os.PathLike[str]) -> Any:
    """Read a YAML file.

    Raises
    ------
    ImportError
        Without ruamel.yaml.
    OSError
        When there is no such file.
    ValueError
        When it is not YAML.
    """
    try:
        from ruamel.yaml import YAML
        from ruamel.yaml.error import YAMLError
    except ImportError as error:
        raise ImportError(f"{file}: reading it needs ruamel.yaml ({error}): pip install 'panda-twin[identify]'") from None
    path = pathlib.Path(file)
    if path.exists() and not path.is_file():
        raise ValueError(f"{path} is no file; name one with YAML")
    if path.stat().st_size > _LARGEST:
        raise ValueError(f"{path} has {path.stat().st_size / 1e6:.0f} MB; what people write has at most {_LARGEST / 1e6:.0f}")
    try:
        return YAML(typ="safe", pure=True).load(path.read_text(encoding="utf-8-sig"))
    except (YAMLError, *_STRANGE) as error:
        raise ValueError(f"{path} is not YAML: {' '.join(str(error).split())[:300]}") from None


def yaml_text(value: Mapping[str, Any], indent: int = 0) -> str:
    """Write a map as YAML."""
    lines = []
    for key, one in value.items():
        if isinstance(one, dict) and any(isinstance(inner, (dict, list)) for inner in one.values()) and len(json.dumps(one)) > 100:
            lines.append(" " * indent + f"{key}:\n" + yaml_text(one, indent + 2))
        elif isinstance(one, list) and one and isinstance(one[0], (list, dict)):
            lines.append(" " * indent + f"{key}:\n" + "".join(" " * (indent + 2) + f"- {json.dumps(inner)}\n" for inner in one))
        else:
            lines.append(" " * indent + f"{key}: {json.dumps(one)}\n")
    return "".join(lines)
