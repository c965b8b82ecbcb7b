"""Who may come in: this machine's browser with the token, at this address, from this page."""

import hmac
import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any
from urllib.parse import parse_qs

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import cookie_parser
from starlette.responses import JSONResponse, PlainTextResponse, RedirectResponse

from allanite.phrases.wording import command_line

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
Application = Callable[[Scope, Receive, Send], Awaitable[None]]

SAFE = ("GET", "HEAD")
"""Methods that change nothing; every other request must say that it comes from this page."""

EMPTY_STYLE = "'sha256-47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU='"
"""Hash of the empty style sheet that the charts make and then fill by rules."""

HEADERS = {
    "Content-Security-Policy": f"default-src 'self'; style-src 'self' {EMPTY_STYLE}; img-src 'self' data: blob:; "
    "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
"""Headers of every answer."""


SHORTEST = 32
"""Characters of a session that cannot be guessed."""


class Door:
    """Refuses requests of other hosts, other pages, and without the session's cookie.

    Parameters
    ----------
    inside : application
    port : int
        That of this server.
    session : str
        Value of the cookie.

    Raises
    ------
    ValueError
        The session is so short that it can be guessed; a request without a cookie would have that of an empty one.
    """

    def __init__(self, inside: Application, *, port: int, session: str) -> None:
        if len(session) < SHORTEST:
            raise ValueError(f"a session has at least {SHORTEST} characters, not {len(session)}")
        self.inside, self.port, self.session = inside, port, session
        self.tokens = set[str]()
        self.hosts = {f"{name}:{port}" for name in ("127.0.0.1", "localhost")}
        self.cookie = f"allanite_{port}"

    def link(self) -> str:
        """A link that opens the session once."""
        token = secrets.token_urlsafe(24)
        self.tokens.add(token)
        return f"http://127.0.0.1:{self.port}/?token={token}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request in, or answer it here."""
        if scope["type"] != "http":
            if scope["type"] == "lifespan":
                await self.inside(scope, receive, send)
            return

        async def closed(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers[name] = value
            await send(message)

        answer = self._answer(scope)
        with command_line():  # messages name options, as controls are called by them
            await (answer or self.inside)(scope, receive, closed)

    def _answer(self, scope: Scope) -> Application | None:
        """The answer to a request that does not come in."""
        headers = Headers(scope=scope)
        if headers.get("host", "") not in self.hosts:
            return PlainTextResponse("this server answers at 127.0.0.1 only", 421)
        if scope["method"] not in SAFE and headers.get("origin", "") not in {f"http://{host}" for host in self.hosts}:
            return JSONResponse({"error": "the request comes from another page", "option": None, "exit": 2}, 403)
        given = parse_qs(scope.get("query_string", b"").decode("latin-1")).get("token", [""])[0]
        if scope["path"] == "/" and given and scope["method"] in SAFE:
            return self._entered(given)
        found = (cookie_parser(line).get(self.cookie) for line in headers.getlist("cookie"))
        if not hmac.compare_digest(next((value for value in found if value), "").encode(), self.session.encode()):
            words = "open the link that allanite serve prints"
            if scope["path"].startswith("/api/"):
                return JSONResponse({"error": words, "option": None, "exit": 2}, 401)
            return PlainTextResponse(words, 401)
        return None

    def _entered(self, given: str) -> Application | None:
        token = next((one for one in self.tokens if hmac.compare_digest(given.encode(), one.encode())), None)
        if token is None:
            return PlainTextResponse("this link was used already; open the one that allanite serve prints", 403)
        self.tokens.discard(token)
        response = RedirectResponse("/", 303)
        response.set_cookie(self.cookie, self.session, httponly=True, samesite="strict", path="/")
        return response
