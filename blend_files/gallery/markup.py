# SPDX-License-Identifier: GPL-3.0-or-later
"""Pieces of HTML. No bpy."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape


def command(options: str) -> str:
    """What makes a part of the gallery."""
    start = "blender -b --factory-startup --python-exit-code 1 -P blend_files/gallery/make.py -- --output DIR"
    return f"{start} {options}".rstrip()


def section(name: str, title: str, *parts: str) -> str:
    """A section of the page, with a name to link to."""
    return f'<section id="{escape(name)}"><h2>{escape(title)}</h2>\n' + "\n".join(parts) + "</section>"


def picture(path: str, text: str) -> str:
    """A picture by its relative path, which a click shows by itself."""
    return f'<figure><a href="{escape(path)}"><img src="{escape(path)}" alt="{escape(text)}" loading="lazy"></a></figure>'


def cells(large: str, shown: Sequence[tuple[str, Sequence[str]]]) -> str:
    """Small pictures side by side, each with its lines of text, the first line bold; a click shows the picture
    `large`."""
    parts = []
    for path, lines in shown:
        words = "<br>".join(f"<b>{escape(line)}</b>" if not k else escape(line) for k, line in enumerate(lines))
        image = f'<img src="{escape(path)}" alt="{escape(lines[0])}" loading="lazy">'
        parts.append(f'<figure><a href="{escape(large)}">{image}</a><figcaption>{words}</figcaption></figure>')
    return f'<div class="cells">{"".join(parts)}</div>'


def grid(heads: Sequence[str], body: Sequence[Sequence[object]]) -> str:
    """A table of texts."""
    head = "".join(f"<th>{escape(str(cell))}</th>" for cell in heads)
    rows = ("<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in row) + "</tr>" for row in body)
    return f'<div class="wide"><table><tr>{head}</tr>\n' + "\n".join(rows) + "</table></div>"


def significant(value: float | None, digits: int) -> str:
    """A number to so many digits; a dash for none."""
    if value is None:
        return "–"
    text = f"{value:.{digits}g}"
    return f"{value:.0f}" if "e+" in text and abs(value) < 1e9 else text
