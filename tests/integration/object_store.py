"""An object store in memory that speaks as much of S3 as an origin needs, and checks each signature.

The check of Signature Version 4 follows AWS' document "Authenticating Requests (AWS Signature Version 4)" and shares nothing with
the server's client, which is libcurl.
"""

import hashlib
import hmac
import threading
import urllib.parse
from http.server import BaseHTTPRequestHandler
from xml.sax.saxutils import escape

from handler_server import HandlerServer

KEY_ID, SECRET, REGION, BUCKET = "tester", "secret+of/tests", "eu-test-1", "scenes"


def sign(secret, date, region, text):
    key = ("AWS4" + secret).encode()
    for part in (date, region, "s3", "aws4_request", text):
        key = hmac.new(key, part.encode(), hashlib.sha256).digest()
    return key.hex()


class ObjectStore(HandlerServer):
    """`with ObjectStore() as store:`; store.objects are bytes by name, store.endpoint is its URL."""

    def __init__(self):
        self.objects = {}
        self.lock = threading.Lock()
        self.overwrites = False  # ignores If-None-Match, as nginx's DAV does
        self.down = False  # ends each connection without an answer
        self.fails = 0  # answers 503 to so many requests more
        self.requests = []
        store = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def handle_any(self):
                store.answer(self)

            do_GET = do_PUT = do_DELETE = do_HEAD = handle_any

        super().__init__(Handler)
        self.endpoint = self.url

    def credentials(self, secret=SECRET):
        return (f"# of a test\n[default]\naws_access_key_id = {KEY_ID}\naws_secret_access_key = {secret}\n"
                f"region = {REGION}\nendpoint_url = {self.endpoint}\n\n[other]\naws_access_key_id = nobody\n")

    def is_signed(self, request):
        fields = {name.lower(): value.strip() for name, value in request.headers.items()}
        head, _, rest = fields.get("authorization", "").partition(" ")
        parts = dict(part.strip().split("=", 1) for part in rest.split(",") if "=" in part)
        if head != "AWS4-HMAC-SHA256" or not {"Credential", "SignedHeaders", "Signature"} <= set(parts):
            return False
        key_id, date, region, *_ = parts["Credential"].split("/")
        names = parts["SignedHeaders"].split(";")
        if key_id != KEY_ID or region != REGION or "host" not in names or "x-amz-date" not in names:
            return False
        path, _, query = request.path.partition("?")
        pairs = sorted(urllib.parse.parse_qsl(query, keep_blank_values=True))
        quoted = "&".join(f"{urllib.parse.quote(name, safe='-_.~')}={urllib.parse.quote(value, safe='-_.~')}" for name, value in pairs)
        canonical = "\n".join([request.command, path, quoted, *(f"{name}:{fields.get(name, '')}" for name in names), "",
                               parts["SignedHeaders"], fields.get("x-amz-content-sha256", "")])
        scope = f"{date}/{region}/s3/aws4_request"
        text = "\n".join(["AWS4-HMAC-SHA256", fields["x-amz-date"], scope, hashlib.sha256(canonical.encode()).hexdigest()])
        return hmac.compare_digest(parts["Signature"], sign(SECRET, date, region, text))

    def answer(self, request):
        body = request.rfile.read(int(request.headers.get("Content-Length", 0)))
        if self.down:
            request.close_connection = True
            request.connection.close()
            return
        path, _, query = request.path.partition("?")
        bucket, _, name = urllib.parse.unquote(path).lstrip("/").partition("/")
        status, content = self.outcome(request, bucket, name, dict(urllib.parse.parse_qsl(query)), body)
        self.requests.append((request.command, name, status))
        request.send_response(status)
        request.send_header("Content-Length", str(len(content)))
        request.end_headers()
        if request.command != "HEAD":
            request.wfile.write(content)

    def outcome(self, request, bucket, name, query, body):
        def error(status, code):
            return status, f'<?xml version="1.0"?><Error><Code>{code}</Code></Error>'.encode()

        with self.lock:
            if self.fails > 0:
                self.fails -= 1
                return error(503, "SlowDown")
            if not self.is_signed(request):
                return error(403, "SignatureDoesNotMatch")
            if bucket != BUCKET:
                return error(404, "NoSuchBucket")
            if request.command == "PUT":
                if name in self.objects and request.headers.get("If-None-Match") == "*" and not self.overwrites:
                    return error(412, "PreconditionFailed")
                self.objects[name] = body
                return 200, b""
            if request.command == "DELETE":
                self.objects.pop(name, None)
                return 204, b""
            if name:
                return (200, self.objects[name]) if name in self.objects else error(404, "NoSuchKey")
            names = sorted(each for each in self.objects if each.startswith(query["prefix"]) and each > query.get("start-after", ""))
            page = names[:int(query["max-keys"])]
            text = "".join(f"<Contents><Key>{escape(each)}</Key><Size>{len(self.objects[each])}</Size></Contents>" for each in page)
            more = "true" if len(page) < len(names) else "false"
            return 200, f'<?xml version="1.0"?><ListBucketResult><IsTruncated>{more}</IsTruncated>{text}</ListBucketResult>'.encode()
