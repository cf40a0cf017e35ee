"""An HTTP server on loopback that answers as a hostile one would."""

import threading
from http.server import BaseHTTPRequestHandler

from handler_server import HandlerServer


class Origin(HandlerServer):
    """`pages[path]` is (status, headers, body) or a function of the handler."""

    def __init__(self, address="127.0.0.1"):
        self.pages, self.asked, self.release = {}, [], threading.Event()
        origin = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_GET(self):
                origin.asked.append(self.path)
                self.close_connection = True
                page = origin.pages.get(self.path.partition("?")[0])
                try:
                    if callable(page):
                        return page(self)
                    status, headers, body = page or (404, {}, b"no such page")
                    self.send_response(status)
                    for name, value in {"Content-Length": len(body), **headers}.items():
                        self.send_header(name, str(value))
                    self.end_headers()
                    self.wfile.write(body)
                except (BrokenPipeError, ConnectionResetError):
                    pass  # the other side had enough

        super().__init__(Handler, address)
        self.__enter__()

    def redirect(self, path, target, status=302):
        self.pages[path] = (status, {"Location": target}, b"")

    def end(self):
        self.release.set()
        self.__exit__()


def endless_chunks(handler):
    """A body that never ends, and says nothing of its length."""
    handler.send_response(200)
    handler.send_header("Transfer-Encoding", "chunked")
    handler.end_headers()
    while True:
        handler.wfile.write(b"10000\r\n" + b"x" * 0x10000 + b"\r\n")


def endless_head(handler):
    handler.wfile.write(b"HTTP/1.1 200 OK\r\n")
    while True:
        handler.wfile.write(b"X-More: " + b"x" * 1000 + b"\r\n")


def liar(body):
    """Promises more than it sends."""
    return 200, {"Content-Length": len(body) + 1000}, body
