"""Who may talk to the server: a browser of this machine, by the address that was printed.

The server listens on this machine alone. That keeps strangers out, but neither other users of the
machine nor web pages of strangers in a browser here: a page anywhere may send requests to
``127.0.0.1``. So the address holds a word that nobody can guess, and

- a request must be meant for this machine by name (``Host``): a name of a stranger's that leads
  here, as by DNS rebinding, is refused;
- a websocket must come from a page of this very server (``Origin``).

A port that SSH forwards may have another number, so numbers of ports are not looked at but have to
agree with each other.
"""

from __future__ import annotations

import hmac
import re
from collections.abc import Mapping

#: What this machine calls itself, with any port.
_LOOPBACK = re.compile(r"(127\.0\.0\.1|localhost|\[::1\])(:\d{1,5})?", re.IGNORECASE)


def refusal(path: str, headers: Mapping[str, str], word: str, websocket: bool) -> str | None:
    """Return why a request is refused; None where it is not.

    Parameters
    ----------
    path : str
        What is asked for.
    headers : mapping of str to str
        Those of the request, by names in small letters.
    word : str
        The first part of every path.
    websocket : bool
        Whether it asks for a websocket.
    """
    host = headers.get("host", "")
    if not _LOOPBACK.fullmatch(host):
        return "this server is for this machine alone: ask for it as 127.0.0.1 or localhost"
    given = path.split("/", 2)[1] if path.startswith("/") else ""
    if not hmac.compare_digest(given.encode("utf-8", "replace"), word.encode()):
        return "open the whole address that posflock watch has printed"
    if websocket and headers.get("origin", "").lower() != f"http://{host}".lower():
        return "only a page of this server may open its websocket"
    return None


def policy(host: str) -> dict[str, str]:
    """Return the headers that bind a browser to this server.

    Parameters
    ----------
    host : str
        By which the page was asked for, and to which its websocket goes.
    """
    content = (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src data:;"
        f" connect-src 'self' ws://{host}; base-uri 'none'; form-action 'none';"
        " frame-ancestors 'none'"
    )
    return {
        "Content-Security-Policy": content,
        "Cache-Control": "no-store",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Referrer-Policy": "no-referrer",
        "X-Content-Type-Options": "nosniff",
    }
