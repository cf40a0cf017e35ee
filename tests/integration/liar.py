"""A server that says whatever it likes, for the clients."""

from http.server import BaseHTTPRequestHandler

from handler_server import HandlerServer

DEEP = 200_000
# Status and body: what is no answer of Sightline in some way.
HOSTILE_ANSWERS = [
    (200, b""), (200, b"\n"), (200, b"null"), (200, b'"\xff\xfe"\n'), (200, b"[" * DEEP + b"]" * DEEP + b"\n"),
    (200, b'{"a":' * DEEP + b"1" + b"}" * DEEP + b"\n"), (200, b'{"status":7}\n'), (200, b"1e999\n"),
    (400, b""), (422, b"[]"), (422, b'{"code":7,"detail":[],"errors":{}}'), (422, b'{"errors":[7]}'), (422, b'{"errors":[{"pointer":7}]}'),
    (500, b'{"code":"\\u001b[2J","detail":"\\u009b31m\\u0000"}'), (422, b"[" * DEEP), (204, b""), (302, b"")]


class Liar(HandlerServer):
    """`with Liar(200, b"null") as liar:` answers everything so."""

    def __init__(self, status, body):
        class Handler(BaseHTTPRequestHandler):
            def do_POST(self):
                self.rfile.read(int(self.headers.get("Content-Length", 0)))
                self.send_response(status)
                self.send_header("Location", "http://127.0.0.1:1/")
                self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(body)

        super().__init__(Handler)
