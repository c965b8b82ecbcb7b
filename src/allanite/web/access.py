"""Who may come in: scripts of this page with the secret, at this address."""

import hmac
import secrets
import time
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse, PlainTextResponse

from allanite.phrases.phrase import command_line

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
Application = Callable[[Scope, Receive, Send], Awaitable[None]]

SAFE = ("GET", "HEAD")  # methods that change nothing; every other request must say that it comes from this page

EMPTY_STYLE = "'sha256-47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU='"
"""Hash of the empty style sheet that the charts make and then fill by rules."""

HEADERS = {
    "Content-Security-Policy": f"default-src 'self'; style-src 'self' {EMPTY_STYLE}; img-src 'self' data: blob:; "
    "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff", "X-Frame-Options": "DENY", "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin", "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}  # fmt: skip
"""Headers of every answer."""


ENTRY = "/api/enter"  # where the token of a link is exchanged for the secret

MAX_LINKS, MAX_LINK_AGE_S = 16, 3600.0
"""Links that can be open at once, the newest ones, and seconds until one is too old."""


class Door:
    """Refuses requests of other hosts, of other pages, and to the API without the secret of this start."""

    def __init__(self, inside: Application, *, port: int, clock: Callable[[], float] = time.monotonic) -> None:
        self.inside, self.port, self.clock = inside, port, clock
        # it comes in a header, which no browser adds by itself: a cookie would be sent to every port of this machine
        self.secret = secrets.token_urlsafe(32)
        self.tokens = dict[str, float]()
        self.hosts = {f"{name}:{port}" for name in ("127.0.0.1", "localhost")}

    def link(self) -> str:
        """A link that opens the page once; its token is in the fragment, which is in no request and no referrer."""
        token = secrets.token_urlsafe(24)
        newest = list(self._valid().items())[1 - MAX_LINKS :]
        self.tokens = {**dict(newest), token: self.clock() + MAX_LINK_AGE_S}
        return f"http://127.0.0.1:{self.port}/#token={token}"

    def _valid(self) -> dict[str, float]:
        return {token: end for token, end in self.tokens.items() if end > self.clock()}

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
        if not scope["path"].startswith("/api/"):
            return None
        given = headers.get("authorization", "").removeprefix("Bearer ").encode()
        if scope["path"] == ENTRY and scope["method"] == "POST":
            return self._entered(given)
        if not hmac.compare_digest(given, self.secret.encode()):
            words = "open the link that allanite serve prints; run it once more for a new one"
            return JSONResponse({"error": words, "option": None, "exit": 2}, 401)
        return None

    def _entered(self, given: bytes) -> Application:
        self.tokens = self._valid()
        token = next((token for token in self.tokens if hmac.compare_digest(given, token.encode())), None)
        if token is None:
            words = "this link was used already, or is too old; run allanite serve once more for a new one"
            return JSONResponse({"error": words, "option": None, "exit": 2}, 403)
        del self.tokens[token]
        return JSONResponse({"secret": self.secret})
