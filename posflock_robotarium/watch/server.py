"""The pages and their websocket, as an ASGI application."""

from __future__ import annotations

import asyncio
import contextlib
import json

from starlette.applications import Starlette
from starlette.datastructures import Headers
from starlette.requests import Request as HttpRequest
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from posflock_robotarium.pages import SHARED_SCRIPTS, SHARED_STYLE, asset
from posflock_robotarium.watch.guard import policy, refusal
from posflock_robotarium.watch.requests import RequestError, read_request
from posflock_robotarium.watch.show import Show, Viewer

_OURS = "posflock_robotarium.watch"
#: Code of a websocket that is closed because it broke a rule.
_POLICY_VIOLATION = 1008


class Guarded:
    """Lets nobody in whom `refusal` refuses.

    Parameters
    ----------
    app : ASGI application
        What is guarded.
    word : str
        The first part of every path.
    """

    def __init__(self, app: ASGIApp, word: str) -> None:
        self._app, self._word = app, word

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or refuse it.

        Parameters
        ----------
        scope, receive, send
            As ASGI has them.
        """
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        websocket = scope["type"] == "websocket"
        why = refusal(scope["path"], Headers(scope=scope), self._word, websocket)
        if why is None:
            await self._app(scope, receive, send)
        elif websocket:
            await WebSocket(scope, receive, send).close(_POLICY_VIOLATION, why)
        else:
            await PlainTextResponse(why + "\n", 403)(scope, receive, send)


def application(show: Show, word: str) -> Guarded:
    """Return the server of one show.

    Parameters
    ----------
    show : Show
        What the pages see.
    word : str
        The first part of every path, which nobody can guess.
    """

    async def live(websocket: WebSocket) -> None:
        await websocket.accept()
        with show.viewed() as viewer:
            sending = asyncio.create_task(_send(websocket, viewer))
            try:
                await _receive(websocket, show, viewer)
            finally:
                sending.cancel()
                with contextlib.suppress(asyncio.CancelledError, WebSocketDisconnect, OSError):
                    await sending

    routes = [
        Route("/", _page),
        Route("/{name}", _file),
        WebSocketRoute("/live", live),
    ]
    return Guarded(Starlette(routes=[Mount(f"/{word}", routes=routes)]), word)


async def _send(websocket: WebSocket, viewer: Viewer) -> None:
    while True:
        for message in await viewer.messages():
            await websocket.send_text(message)


async def _receive(websocket: WebSocket, show: Show, viewer: Viewer) -> None:
    with contextlib.suppress(WebSocketDisconnect):
        while True:
            text = await websocket.receive_text()
            try:
                show.ask(read_request(text))
            except RequestError as error:
                viewer.offer("refused", json.dumps(str(error)))


#: Each file of the page: its kind, what of it all pages share, and what is its own.
_FILES: dict[str, tuple[str, tuple[str, ...], str]] = {
    "watch.js": ("text/javascript", SHARED_SCRIPTS, "watch.js"),
    "watch.css": ("text/css", (SHARED_STYLE,), "watch.css"),
}


def _answer(request: HttpRequest, text: str, kind: str) -> Response:
    headers = policy(request.headers["host"])
    return Response(text, media_type=f"{kind}; charset=utf-8", headers=headers)


async def _page(request: HttpRequest) -> Response:
    return _answer(request, asset("watch.html", _OURS), "text/html")


async def _file(request: HttpRequest) -> Response:
    name = request.path_params["name"]
    if name not in _FILES:
        return PlainTextResponse("no such file\n", 404)
    kind, shared, own = _FILES[name]
    parts = [*(asset(part) for part in shared), asset(own, _OURS)]
    return _answer(request, "\n".join(parts), kind)
