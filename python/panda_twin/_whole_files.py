"""Files that are written whole or not at all."""

from __future__ import annotations

import os
import typing

if typing.TYPE_CHECKING:
    import pathlib
    from collections.abc import Mapping


def write_whole(folder: pathlib.Path, texts: Mapping[str, str]) -> None:
    """Write files of a folder, made if need be: all of them, or, if one cannot be written, none.

    Raises
    ------
    OSError
        If one cannot be written, which it names; what was there before is left as it was.
    """
    folder.mkdir(parents=True, exist_ok=True)
    parts = {name: folder / f"{name}.{os.getpid()}.partial" for name in texts}
    file = folder
    try:
        for name, text in texts.items():
            file = folder / name
            # A name of a file that is no UTF-8 comes as surrogates.
            parts[name].write_text(text, encoding="utf-8", errors="replace")
        for name, part in parts.items():
            part.replace(folder / name)
    except OSError as error:
        if error.filename is None:  # of writing and closing
            raise OSError(error.errno, error.strerror, str(file)) from None
        raise
    finally:
        for part in parts.values():
            part.unlink(missing_ok=True)
