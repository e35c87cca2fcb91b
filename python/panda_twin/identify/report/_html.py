"""Pieces of a page: every text that goes through them is escaped."""

from __future__ import annotations

import dataclasses
import html
from collections.abc import Sequence
from typing import NewType, TypeAlias

Html = NewType("Html", str)
"""Text that is escaped already."""

# As src/report/templates/style.css, with colours for dark pages beside.
STYLE = """
:root{color-scheme:light dark;--ink:#222;--soft:#666;--rule:#ddd;--paper:#fff;--box:#f5f4f7;
--title:#7a2a90;--good:#1b6e4f;--bad:#c0272d;--badly:#fbe3e5}
@media(prefers-color-scheme:dark){:root{--ink:#dcdcde;--soft:#a0a0a6;--rule:#3c3c42;--paper:#1a1a1d;--box:#26262b;
--title:#cf94e0;--good:#62c79f;--bad:#ff8087;--badly:#43262a}}
body{font:15px/1.45 'DejaVu Sans',Verdana,sans-serif;color:var(--ink);background:var(--paper);
max-width:1060px;margin:2em auto;padding:0 1em}
h1{font-size:1.35em;margin:0 0 .2em}
h2{font-size:1.1em;margin:2em 0 .5em}
h3{font-size:1em;margin:1.5em 0 .3em}
h1.met{color:var(--good)}
h1.missed{color:var(--bad)}
p{margin:0 0 .5em;overflow-wrap:anywhere}
p.soft,figcaption{color:var(--soft);font-size:.9em}
ul{margin:0 0 .5em;padding-left:1.3em}
li{overflow-wrap:anywhere}
svg{width:100%;height:auto;display:block}
figure{margin:0 0 1em}
table{border-collapse:collapse;font-size:.85em;font-variant-numeric:tabular-nums;margin:0 0 .5em}
th,td{padding:.15em .6em;text-align:right;border-bottom:1px solid var(--rule)}
th{vertical-align:bottom;font-weight:normal;color:var(--soft)}
th.over{text-align:center;color:var(--ink)}
tr>:first-child,td.word,th.word{text-align:left}
td{white-space:nowrap}
tr>td:first-child,td.word{white-space:normal;overflow-wrap:anywhere}
th.first,td.first{border-left:1px solid var(--rule)}
.met{color:var(--good)}
.missed{color:var(--bad);font-weight:bold}
td.missed{background:var(--badly)}
.untold{color:var(--soft)}
pre{font-size:.8em;overflow-x:auto;background:var(--box);padding:.5em .8em;margin:.2em 0 .8em;
user-select:all;white-space:pre-wrap}
.wide{overflow-x:auto}
.doubt{border-left:4px solid var(--bad);background:var(--badly);padding:.5em .8em;margin:.8em 0}
.doubt p:last-child{margin:0}
.cause{display:grid;grid-template-columns:5em 1fr;gap:0 1em;margin:0 0 .5em}
.cause b{font-size:1.35em;color:var(--title);text-align:right}
summary{cursor:pointer;margin:.5em 0}
code{overflow-wrap:anywhere;font-size:.9em}
@media print{details{display:block}}
"""


@dataclasses.dataclass(frozen=True)
class Cell:
    """A cell of a table with classes, and over how many columns it reaches."""

    text: str
    css: str = ""
    columns: int = 1


Cells: TypeAlias = Sequence["str | Cell"]


def escaped(text: str) -> Html:
    """A text as it is to be read; what is no character of Unicode shows as a question mark."""
    return Html(html.escape(text.encode(errors="replace").decode()))


def element(name: str, text: str, css: str = "") -> Html:
    """An element with a text."""
    return Html(f"<{name}{f' class={chr(34)}{css}{chr(34)}' if css else ''}>{escaped(text)}</{name}>")


def p(text: str, css: str = "") -> Html:
    """A paragraph."""
    return element("p", text, css)


def h2(text: str) -> Html:
    """A heading."""
    return element("h2", text)


def h3(text: str) -> Html:
    """A heading below."""
    return element("h3", text)


def pre(text: str) -> Html:
    """A text to copy."""
    return element("pre", text)


def bullets(lines: Sequence[str]) -> Html:
    """A list."""
    return Html("<ul>" + "".join(element("li", line) for line in lines) + "</ul>")


def table(heads: Sequence[Cells], rows: Sequence[Cells]) -> Html:
    """A table, wide ones with a bar to scroll."""
    lines = [_row("th", cells) for cells in heads] + [_row("td", cells) for cells in rows]
    return Html('<div class="wide"><table>\n' + "\n".join(lines) + "\n</table></div>")


def _row(name: str, cells: Cells) -> str:
    return "<tr>" + "".join(_cell(name, cell if isinstance(cell, Cell) else Cell(cell)) for cell in cells) + "</tr>"


def _cell(name: str, cell: Cell) -> str:
    css = f' class="{cell.css}"' if cell.css else ""
    columns = f' colspan="{cell.columns}"' if cell.columns > 1 else ""
    return f"<{name}{css}{columns}>{escaped(cell.text)}</{name}>"


def folded(title: str, inside: Sequence[Html]) -> Html:
    """What opens on demand."""
    return Html(f"<details><summary>{escaped(title)}</summary>\n" + "\n".join(inside) + "\n</details>")


def figure(svg: str, caption: str) -> Html:
    """A plot below its caption."""
    return Html(f"<figure>\n<figcaption>{escaped(caption)}</figcaption>\n{svg}</figure>")


def document(title: str, parts: Sequence[Html]) -> str:
    """The whole page."""
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escaped(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n" + "\n".join(parts) + "\n</body>\n</html>\n"
    )
