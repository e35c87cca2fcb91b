"""Writes panda_twin/scenario_types.py: the sections of a scenario as TypedDicts, out of the schema that the module has.

python3 -P generate_scenario.py FILE, with the built package in PYTHONPATH; the build calls it.
"""

import json
import keyword
import pathlib
import sys

import panda_twin

HEAD = '''"""Sections and keys of a scenario, for type checkers and editors: written by the build, out of `panda_twin.schema()`.

No key is required here, so that the same types serve changes of a scenario: the code that reads scenarios says what is missing.
"""

from __future__ import annotations

import collections.abc
import typing

import numpy
import numpy.typing

Parameters = collections.abc.Mapping[str, typing.Any]
Numbers = collections.abc.Sequence[float] | numpy.typing.NDArray[numpy.float64]
'''
PLAIN = {"string": "str", "integer": "int", "number": "float", "boolean": "bool"}
WIDTH = 140


def wrapped(text, width):
    lines = [""]
    for word in text.split():
        if lines[-1] and len(lines[-1]) + 1 + len(word) > width:
            lines.append("")
        lines[-1] += (" " if lines[-1] else "") + word
    return lines


def class_name(path):
    return "".join(part.capitalize() for key in path for part in key.split("_"))


def distinct(names):
    return list(dict.fromkeys(names))


class Types:
    """Texts of the classes, each behind those that it refers to."""

    def __init__(self):
        self.texts = []

    def of(self, path, schema):
        """The type of a value, whose classes are added first."""
        if "$ref" in schema:
            return class_name([schema["$ref"].rsplit("/", 1)[1]])
        if "anyOf" in schema:
            one_of = [*path, "keys"] if len(path) == 1 else path  # beside the name of the alternatives
            return " | ".join(distinct(self.of(one_of, one) for one in schema["anyOf"]))
        values = schema["enum"] if "enum" in schema else [schema["const"]] if "const" in schema else None
        if values is not None:
            return f"typing.Literal[{', '.join(json.dumps(value) for value in values)}]"
        if schema["type"] == "array":
            item = self.of(path, schema["items"])
            return "Numbers" if item == "float" else f"collections.abc.Sequence[{item}]"
        if schema["type"] == "object":
            return self.add(path, schema) if "properties" in schema else "Parameters"
        return PLAIN[schema["type"]]

    def add(self, path, schema, name=""):
        """Adds a map's class; returns its name."""
        name = name or class_name(path)
        keys = {key: self.of([*path, key], value) for key, value in schema["properties"].items()}
        if any(keyword.iskeyword(key) for key in keys):  # no attribute can have such a name
            text = f'\n\n{name} = typing.TypedDict(\n    "{name}",\n    {{\n'
            for key, kind in keys.items():
                text += "".join(f"        # {line}\n" for line in wrapped(meaning(key, schema), WIDTH - 10))
                text += f'        "{key}": {kind},\n'
            self.texts.append(text + "    },\n    total=False,\n)\n")
            return name
        text = f"\n\nclass {name}(typing.TypedDict, total=False):\n" + docstring(schema.get("description", f"Keys of `{'.'.join(path)}`."))
        for key, kind in keys.items():
            text += f"\n{field(key, kind)}{docstring(meaning(key, schema))}"
        self.texts.append(text)
        return name

    def define(self, name, schema):
        """Adds what is used by name."""
        kind = self.of([name], schema)
        if kind != class_name([name]):
            self.texts.append(f"\n\n{field(class_name([name]), kind, ' = ', '')}")


def field(key, kind, joint=": ", indent="    "):
    line = f"{indent}{key}{joint}{kind}\n"
    if len(line) <= WIDTH:
        return line
    return f"{indent}{key}{joint}(\n{indent}    {kind}\n{indent})\n" if joint == " = " else line


def docstring(text):
    lines = wrapped(text.replace("\\", "\\\\"), WIDTH - 10)
    if len(lines) == 1:
        return f'    """{lines[0]}"""\n'
    return '    """' + "\n    ".join(lines) + '"""\n'


def meaning(key, schema):
    value = schema["properties"][key]
    unit = [one["title"] for one in [value, *value.get("anyOf", [])] if " in [" in one.get("title", "")]
    text = " ".join([value.get("description", ""), *(f"{title[0].upper()}{title[1:]}." for title in unit)]).strip()
    if key in schema.get("required", []):
        return f"{text} Required."
    return f"{text} Default: {json.dumps(value['default'])}." if value.get("default", "") != "" else text


def main():
    schema = panda_twin.schema()
    types = Types()
    for name, definition in schema["$defs"].items():
        types.define(name, definition)
    types.add([], {**schema, "description": "All of a scenario. One of motion and application is required."}, "ScenarioKeys")
    pathlib.Path(sys.argv[1]).write_text(HEAD + "".join(types.texts), encoding="utf-8")


if __name__ == "__main__":
    main()
