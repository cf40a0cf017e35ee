"""A server on loopback whose answers a test writes itself."""

import threading
from http.server import ThreadingHTTPServer


class HandlerServer:
    """`with HandlerServer(Handler) as server:`; Handler is a BaseHTTPRequestHandler. `port`, `url`."""

    def __init__(self, handler, address="127.0.0.1"):
        handler.log_message = lambda *_: None
        self.server = ThreadingHTTPServer((address, 0), handler)
        self.server.daemon_threads = True
        self.port = self.server.server_port
        self.url = f"http://{address}:{self.port}"
        self.thread = threading.Thread(target=self.server.serve_forever)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.server.shutdown()
        self.thread.join()
        self.server.server_close()
