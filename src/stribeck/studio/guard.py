"""Who may talk to the studio: the browser that opened its address on this machine, nobody else.

A page of another site can make a browser send requests to a server on the same machine, and a name
that it owns can be made to point there (DNS rebinding). So every request, reading ones and streams
included, must name a host that the studio serves and carry a cookie that only its own start link
sets; and what writes must come from the studio's own page.
"""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Iterable
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs

#: Path of the start link, and name of the cookie that it sets.
START, COOKIE = "/start", "stribeck-studio"
#: What a page of the studio may load: its own files alone, and nothing written into the page.
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
    "connect-src 'self'; frame-src 'self'; frame-ancestors 'self'; base-uri 'none'; "
    "form-action 'none'"
)
HEADERS = (
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-opener-policy", b"same-origin"),
    (b"cross-origin-resource-policy", b"same-origin"),
    (b"cache-control", b"no-store"),
)
_READING = frozenset({"GET", "HEAD"})


class Guard:
    """An ASGI application before another: it refuses what does not come from the studio's page.

    Args:
        app: The application behind it.
        hosts: The values of a Host header that are the studio's.
        secret: Value of the cookie.
        place: The page to which the start link leads.

    Attributes:
        token: Of the next start link; it is used once.
    """

    def __init__(self, app: Any, hosts: Iterable[str], secret: str, place: str = "/") -> None:
        self._app, self._secret, self._place = app, secret, place
        self._hosts = frozenset(h.lower() for h in hosts)
        self.token: str | None = secrets.token_urlsafe(24)

    async def __call__(self, scope: dict[str, Any], receive: Any, send: Any) -> None:
        """Answer a request, or hand it on."""
        if scope["type"] != "http":
            if scope["type"] == "lifespan":
                await self._app(scope, receive, send)
            return
        headers = {k.decode("latin-1").lower(): v.decode("latin-1") for k, v in scope["headers"]}
        named = [v.decode("latin-1").lower() for k, v in scope["headers"] if k.lower() == b"host"]
        if len(named) != 1 or named[0] not in self._hosts:
            await _answer(send, 421, "this is not a host that the studio serves")
            return
        if scope["path"] == START:
            await self._start(scope, send)
            return
        if not self._known(headers.get("cookie", "")):
            await _answer(
                send, 403, "open the studio by the address that `stribeck studio` printed; each "
                "address works once: start it again for another"
            )  # fmt: skip
            return
        if refusal := _foreign(scope["method"], headers):
            await _answer(send, 403, refusal)
            return
        await self._app(scope, receive, _with_headers(send))

    async def _start(self, scope: dict[str, Any], send: Any) -> None:
        asked = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
        token = self.token
        if scope["method"] != "GET" or token is None or not _equal(asked, token):
            await _answer(send, 403, "this address has been used: start the studio again")
            return
        self.token = None
        cookie = f"{COOKIE}={self._secret}; Path=/; HttpOnly; SameSite=Strict; Max-Age=31536000"
        more = [(b"location", self._place.encode()), (b"set-cookie", cookie.encode())]
        await _answer(send, 303, "", more)

    def _known(self, text: str) -> bool:
        try:
            cookie = SimpleCookie(text).get(COOKIE)
        except CookieError:
            return False
        return cookie is not None and _equal(cookie.value, self._secret)


def _equal(a: str, b: str) -> bool:
    return hmac.compare_digest(a.encode(), b.encode())


def _foreign(method: str, headers: dict[str, str]) -> str:
    """Why a request does not come from the studio's own page; empty if it does."""
    site = headers.get("sec-fetch-site")
    own = f"http://{headers['host']}".lower()
    if method in _READING:
        # Another page may lead here, but not load what is here into itself.
        if site in (None, "same-origin", "none") or headers.get("sec-fetch-mode") == "navigate":
            return ""
        return "the studio answers its own page alone"
    if headers.get("origin", "").lower() == own and site in (None, "same-origin"):
        return ""
    return "only the studio's own page can change a session"


def _with_headers(send: Any) -> Any:
    async def answer(message: dict[str, Any]) -> None:
        if message["type"] == "http.response.start":
            named = {k.lower() for k, _ in message["headers"]}
            more = [(k, v) for k, v in HEADERS if k not in named]
            if b"content-security-policy" not in named:
                more.append((b"content-security-policy", POLICY.encode()))
            message = {**message, "headers": [*message["headers"], *more]}
        await send(message)

    return answer


async def _answer(
    send: Any, status: int, text: str, more: Iterable[tuple[bytes, bytes]] = ()
) -> None:
    """A short answer in plain text."""
    headers = [(b"content-type", b"text/plain; charset=utf-8"), *HEADERS, *more]
    headers.append((b"content-security-policy", b"default-src 'none'"))
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": f"{text}\n".encode() if text else b""})
