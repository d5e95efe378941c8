"""A view as a page of its own: one file that needs neither Python nor a network.

Goes in: a view's state and arrays. Comes out: HTML with the bundle, the style sheet and the arrays (gzip, as
base64) inside, which a browser opens from disk.
"""

from __future__ import annotations

import base64
import gzip
import html
import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from scenewidget.editing.formats.seal import SEAL

__all__ = ["make_page"]

COMPRESSION = 6  # level of gzip; higher ones take seconds more and save hardly a byte
PAGE = """\
<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="generator" content="scenewidget {seal}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
html, body {{ height: 100%; margin: 0; }}
body {{ background: #f4f5f7; font: 13px/1.4 system-ui, sans-serif; }}
@media (prefers-color-scheme: dark) {{ body {{ color: #e6e8eb; background: #191b1f; }} }}
#view {{ height: 100%; }}
#view .scenewidget {{ width: 100%; height: 100% !important; margin: 0; border: 0; border-radius: 0; }}
#note {{ padding: 24px; }}
{style}
</style>
</head>
<body>
<div id="view"><p id="note">Opening the scan …</p></div>
<script type="application/json" id="saved">{saved}</script>
<script type="text/plain" id="bundle">{bundle}</script>
<script type="module">
const text = (id) => document.getElementById(id).textContent;
const note = document.getElementById("note");
try {{
  const packed = Uint8Array.from(atob(text("bundle")), (character) => character.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const code = new Blob([await new Response(stream).text()], {{ type: "text/javascript" }});
  const {{ default: widget, savedModel }} = await import(URL.createObjectURL(code));
  const model = await savedModel(JSON.parse(text("saved")));
  note.remove();
  widget.render({{ model, el: document.getElementById("view") }});
}} catch (error) {{
  note.textContent = `This page can't be shown here: ${{error.message}}. It needs a current browser.`;
  throw error;
}}
</script>
</body>
</html>
"""


def make_page(
    state: Mapping[str, Any],
    arrays: Mapping[str, npt.NDArray[Any]],
    *,
    bundle: str,
    style: str,
    title: str,
) -> str:
    """The page as text.

    Parameters
    ----------
    state : mapping
        What the view reads of its model, without its arrays; must be JSON.
    arrays : mapping of name to array
    bundle, style : str
        Script and style sheet of the front end.
    title : str
        Of the page; any text.

    Examples
    --------
    >>> page = make_page({"level": "final"}, {}, bundle="", style="", title="A room")
    >>> "<title>A room</title>" in page
    True
    """
    packed = {
        name: {
            "dtype": array.dtype.name,
            "shape": list(array.shape),
            "data": _packed(np.ascontiguousarray(array).tobytes()),
        }
        for name, array in arrays.items()
    }
    saved = json.dumps({"state": dict(state), "arrays": packed}, separators=(",", ":"))
    return PAGE.format(
        seal=SEAL,
        title=html.escape(title),
        style=style,
        saved=saved.replace("<", "\\u003c"),  # so that no name can end the script
        bundle=_packed(bundle.encode()),
    )


def _packed(data: bytes) -> str:
    return base64.b64encode(gzip.compress(data, COMPRESSION, mtime=0)).decode("ascii")
