"""Another server of this machine that the user visits: what it gets of the page by the browser, and opens with it."""

import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import httpx
import pytest

pytestmark = pytest.mark.slow("the page in a browser, visited beside another server")

ATTACK = """async (page) => {
    const tries = [["GET", "api/workspaces"], ["POST", "api/workspaces"], ["POST", "api/link"], ["POST", "api/enter"]];
    const ways = [{credentials: "include"}, {credentials: "include", mode: "no-cors"}];
    const answers = [];
    for (const [method, path] of tries)
        for (const way of ways)
            answers.push(await fetch(page + path, {method, ...way}).then((r) => r.text(), (error) => ""));
    const loaded = (tag, at) => new Promise((resolve) => {
        const node = document.createElement(tag);
        node.onload = () => resolve(true);
        node.onerror = () => resolve(false);
        node.src = page + at;
        document.head.append(node);
    });
    return {answers, script: await loaded("script", "api/workspaces"), stored: Object.keys(localStorage)};
}"""


class Intruder(BaseHTTPRequestHandler):
    """Serves an empty page, and notes what it is sent."""

    def do_GET(self):
        self.server.noted.append(dict(self.headers))
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.end_headers()
        self.wfile.write(b"<!DOCTYPE html><title>another</title><link rel=icon href=data:,>")

    def log_message(self, *_):
        pass


@pytest.fixture
def intruder():
    with ThreadingHTTPServer(("127.0.0.1", 0), Intruder) as server:
        server.noted = []
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield server
        server.shutdown()
        thread.join()


def test_a_server_at_another_port_gets_nothing_that_opens_the_page(page, context, intruder):
    own = {"Authorization": f"Bearer {context.secret}"}
    before = httpx.get(f"{context.address}api/workspaces", headers=own).json()
    assert before
    other = context.new_page()
    other.goto(f"http://127.0.0.1:{intruder.server_port}/")
    got = other.evaluate(ATTACK, context.address)
    assert set(got["answers"]) == {""}
    assert (got["script"], got["stored"]) == (False, [])
    page.evaluate("(address) => { location.href = address; }", f"http://127.0.0.1:{intruder.server_port}/from")
    page.wait_for_url("**/from")
    noted = intruder.noted
    assert len(noted) == 2
    assert not {name.lower() for headers in noted for name in headers} & {"cookie", "authorization", "referer"}
    assert context.secret not in str(noted)
    # with all that it was sent, and an Origin that it writes itself
    for headers in noted:
        forged = {name: value for name, value in headers.items() if name not in ("Host", "Connection")}
        forged["Origin"] = context.address.rstrip("/")
        for method, path in (("GET", "workspaces"), ("POST", "workspaces"), ("POST", "link"), ("POST", "enter")):
            answer = httpx.request(method, f"{context.address}api/{path}", headers=forged)
            assert answer.status_code in (401, 403)
    assert httpx.get(f"{context.address}api/workspaces", headers=own).json() == before
    assert context.cookies() == []
    other.close()
