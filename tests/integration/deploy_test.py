"""What stands in docs/deploy is true: the service's unit, the man page, and nginx with TLS in front."""

import json
import os
import re
import shutil
import socket
import ssl
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import case_report
from sightline_server import BINARY, JSON_TYPE, PATIENCE, SOURCE, Server, bearer, curl, demo_glb, make_key, read_answer, write_keys

sys.path.insert(0, str(SOURCE / "scripts"))
import man_page

DEPLOY = SOURCE / "docs/deploy"
QUERY = '{"rays":[{"origin":[-10,1,0],"direction":[1,0,0]}],"fields":["t"]}'


def run(*command, **options):
    return subprocess.run([*map(str, command)], capture_output=True, text=True, timeout=PATIENCE, check=False, **options)


class Unit(unittest.TestCase):
    def setUp(self):
        if shutil.which("systemd-analyze") is None:
            self.skipTest("systemd-analyze is not installed")
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.unit = Path(folder.name, "sightline.service")
        text = (DEPLOY / "sightline.service").read_text(encoding="utf-8")
        # The check asks whether the programs are there.
        self.unit.write_text(text.replace("/usr/local/bin/sightline", str(Path(BINARY).resolve())).replace("Documentation=man:", "#"),
                             encoding="utf-8")

    def test_it_is_a_good_unit(self):
        done = run("systemd-analyze", "verify", "--man=no", self.unit)
        # Other units of this machine may be at odds; of this one nothing is said.
        self.assertNotIn("sightline", done.stderr.replace(str(BINARY), ""), done.stderr)

    def test_it_is_hardened(self):
        done = run("systemd-analyze", "security", "--offline=yes", "--threshold=20", self.unit)
        if "offline" in done.stderr:
            self.skipTest("this systemd-analyze knows no --offline")
        self.assertEqual(done.returncode, 0, done.stdout[-3000:] + done.stderr)


class Stops(unittest.TestCase):
    def test_each_waits_for_what_has_begun(self):
        drains = 30 + 0  # --drain-seconds and --notice-seconds as they come
        self.assertRegex(man_page.help_of(BINARY, ("serve",)), r"--drain-seconds \S+=30 *\n(.|\n)*--notice-seconds \S+=0 *\n")
        for file, pattern in [("docs/deploy/sightline.service", r"^TimeoutStopSec=(\d+)$"), ("docker/compose.single.yaml", r"^ *stop_grace_period: (\d+)s"),
                              ("README.md", r"docker run --stop-timeout (\d+) ")]:
            seconds = re.findall(pattern, (SOURCE / file).read_text(encoding="utf-8"), re.MULTILINE)
            self.assertEqual([int(each) > drains + 5 for each in seconds], [True], file)

    def test_a_reload_looks_at_the_settings_first(self):
        reloads = re.findall(r"^ExecReload=(.*)$", (DEPLOY / "sightline.service").read_text(encoding="utf-8"), re.MULTILINE)
        start = re.findall(r"^ExecStartPre=(.*)$", (DEPLOY / "sightline.service").read_text(encoding="utf-8"), re.MULTILINE)
        self.assertEqual(reloads, [*start, "/bin/kill -HUP $MAINPID"])


class ManPage(unittest.TestCase):
    def test_it_has_no_notation_of_the_library(self):
        page = (DEPLOY / "sightline.1").read_text(encoding="utf-8")
        self.assertNotRegex(page, r"\bTEXT\b")
        for word in ("UINT", "FLOAT", "REQUIRED", "Excludes:", "POSITIVE", "OPTIONS:"):
            self.assertNotIn(word, page)

    def test_it_has_every_command_and_flag_of_the_help(self):
        page = (DEPLOY / "sightline.1").read_text(encoding="utf-8").replace("\\-", "-")
        commands = [("key", "new")]
        for line in re.split(r"(?i)subcommands:\n", run(BINARY, "--help").stdout)[1].splitlines():
            if (word := re.match(r"  (\S+) ", line)) and word[1] != "key":
                commands.append((word[1],))
        self.assertGreater(len(commands), 7)
        for command in commands:
            with self.subTest(command=command):
                text = run(BINARY, *command, "--help").stdout
                section = page.split(f".SS {' '.join(command)}\n")[1].split("\n.S")[0]
                flags = re.findall(r"^ +(?:-\w, *)?(--[a-z-]+)", text, re.MULTILINE)
                self.assertEqual(sorted({"--help", *re.findall(r"^\\fB(--[a-z-]+)", section, re.MULTILINE)}), sorted(set(flags)))

    def test_its_examples_run(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            subprocess.run([BINARY, "demo", "town", folder / "house.glb"], check=True, timeout=PATIENCE)
            (folder / "rays.txt").write_text("3 200 5 0 -1 0\n", encoding="ascii")
            (folder / "sightline.json").write_text('{"max-rays": 1000}', encoding="ascii")
            for _, lines in man_page.EXAMPLES:
                server = None
                try:
                    for line in lines:
                        words = line.split()[1:]
                        if words[0] == "serve":
                            # Tests listen on a port of their own, and write into their folder.
                            if "--listen" in words:
                                at = words.index("--listen")
                                del words[at:at + 2]
                            server = Server(*(word.replace("/var/lib", name).replace("keys.txt", f"{name}/keys.txt") for word in words[1:]))
                            continue
                        if server:
                            words = [server.url if word.startswith("http://") else word for word in words]
                        done = subprocess.run([BINARY, *words], cwd=folder, capture_output=True, text=True, timeout=PATIENCE, check=False)
                        self.assertEqual(done.returncode, 0, line + done.stderr)
                        if words[:2] == ["key", "new"]:
                            write_keys(folder / "keys.txt", done.stdout.splitlines()[1].removeprefix("line: "))
                finally:
                    if server:
                        server.end()

    def test_it_is_what_the_program_says(self):
        page = (DEPLOY / "sightline.1").read_text(encoding="utf-8")
        self.assertEqual(page, man_page.page(BINARY), "scripts/man_page.py BINARY --write")
        for word in ("listen", "keys", "config", "max\\-rays", "origin", "any", "role", "FILE", "NAME"):
            self.assertRegex(page, r"\\fB(\\-\\-)?" + word.replace("\\", r"\\"))
        self.assertTrue(page.startswith('.\\" '), "a comment is a request")
        self.assertNotIn("\\fBwhat to print", page)
        self.assertIn("\nmode:\nwhat to print; default: the closest hit\n.TP\n", page)
        self.assertIn(".SH ENVIRONMENT\n.TP\nSIGHTLINE_KEY\n", page)
        for command in ("cast", "query", "check\\-config"):
            self.assertIn(f"\\fB{command}\\fR", page.split(".SH EXIT STATUS")[1].split(".SH")[0])

    def test_it_is_good_troff(self):
        if shutil.which("groff") is None:
            self.skipTest("groff is not installed")
        done = run("groff", "-man", "-ww", "-Tascii", DEPLOY / "sightline.1")
        self.assertEqual((done.returncode, done.stderr), (0, ""))


class TlsCase(unittest.TestCase):
    """A server with keys, and nginx in front of it with a configuration as it stands, but for ports and paths."""

    @classmethod
    def setUpClass(cls):
        if cls is TlsCase:
            raise unittest.SkipTest("it is what the others have in common")
        for program in ("nginx", "openssl"):
            if shutil.which(program) is None and not os.path.exists(f"/usr/sbin/{program}"):
                raise unittest.SkipTest(f"{program} is not installed")
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        cls.certificate = cls.folder / "certificate.pem"
        made = run("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2", "-subj",
                   "/CN=localhost", "-addext", "subjectAltName=DNS:localhost", "-keyout", cls.folder / "key.pem", "-out", cls.certificate)
        assert made.returncode == 0, made.stderr
        cls.key, line = make_key("write", "tls")
        keys = write_keys(cls.folder / "keys", line)
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            cls.port = probe.getsockname()[1]
        cls.server = Server("--preload", "six=demo:six", "--keys", keys)
        cls.addClassCleanup(cls.server.end)
        cls.start_nginx(cls.configuration())
        cls.url = f"https://localhost:{cls.port}"

    @classmethod
    def in_place(cls, name, *others):
        """The file of docs/deploy with this test's ports and paths."""
        text = (DEPLOY / name).read_text(encoding="utf-8")
        for old, new in [("server 127.0.0.1:8080;", f"server 127.0.0.1:{cls.server.port};"),
                         ("/etc/ssl/certs/sightline.pem", str(cls.certificate)), ("/etc/ssl/private/sightline.key", f"{cls.folder}/key.pem"),
                         *others]:
            assert text.count(old) == 1, old
            text = text.replace(old, new)
        return text

    @classmethod
    def start_nginx(cls, configuration):
        whole = cls.folder / "nginx.conf"
        whole.write_text(f"pid {cls.folder}/pid;\nworker_processes 1;\n{configuration}", encoding="utf-8")
        cls.log = open(cls.folder / "error.log", "wb")
        cls.addClassCleanup(cls.log.close)
        program = shutil.which("nginx") or "/usr/sbin/nginx"
        cls.nginx = subprocess.Popen([program, "-e", "stderr", "-p", cls.folder, "-c", whole, "-g", "daemon off;"], stderr=cls.log)
        cls.addClassCleanup(cls.nginx.wait)
        cls.addClassCleanup(cls.nginx.terminate)
        end = time.monotonic() + PATIENCE
        while True:
            try:
                socket.create_connection(("127.0.0.1", cls.port)).close()
                return
            except OSError:
                assert cls.nginx.poll() is None and time.monotonic() < end, (cls.folder / "error.log").read_text(encoding="utf-8")

    def ask(self, path, *arguments, **options):
        return curl(self.url + path, "--cacert", str(self.certificate), *arguments, **options)

    def connect(self):
        context = ssl.create_default_context(cafile=self.certificate)
        return context.wrap_socket(socket.create_connection(("127.0.0.1", self.port), timeout=PATIENCE), server_hostname="localhost")


class Tls(TlsCase):
    @classmethod
    def configuration(cls):
        text = cls.in_place("nginx.conf", ("    listen [::]:443 ssl http2;\n", ""),
                            ("listen 443 ssl http2;", f"listen 127.0.0.1:{cls.port} ssl http2;"), ("sightline.example.org", "localhost"),
                            ("/var/log/nginx/sightline.log", f"{cls.folder}/access.log"))
        temporary = "".join(f"{kind}_temp_path {cls.folder}/{kind};\n" for kind in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi"))
        return f"events {{}}\nhttp {{\n{temporary}{text}}}\n"

    def test_answers_come_through_over_both_versions(self):
        for version in ("--http1.1", "--http2"):
            with self.subTest(version=version):
                answer = self.ask("/v1/scenes/six/rays:closest", version, "-H", JSON_TYPE, *bearer(self.key), body=QUERY)
                self.assertEqual((answer.status, answer.body), (200, b'{"hits":[{"t":4.5}]}'))
                self.assertTrue(answer.headers["strict-transport-security"])
                self.assertEqual(answer.headers["x-content-type-options"], "nosniff")
        locked = self.ask("/v1/scenes/six")
        self.assertEqual((locked.status, locked.headers["www-authenticate"]), (401, 'Bearer realm="sightline"'))

    def test_query_wants_an_authority_that_it_trusts(self):
        command = (BINARY, "query", self.url, "six", "--origin=-10,1,0", "--direction", "1,0,0", "--any")
        trusted = dict(os.environ, SIGHTLINE_KEY=self.key, SSL_CERT_FILE=str(self.certificate))
        self.assertEqual(run(*command, env=trusted).stdout, "true\n")
        del trusted["SSL_CERT_FILE"]
        strange = run(*command, env=trusted)
        self.assertEqual((strange.returncode, strange.stdout), (2, ""))
        self.assertIn("no authority that this machine trusts", strange.stderr)

    def test_request_ids_come_through_both_ways(self):
        given = self.ask("/v1/scenes/six", *bearer(self.key), "-H", "X-Request-Id: through-tls")
        made = self.ask("/v1/scenes/six", *bearer(self.key)).headers["x-request-id"]
        self.assertEqual(given.headers["x-request-id"], "through-tls")
        for request_id in ("through-tls", made):
            self.assertIn(f" id={request_id} key=tls\n", self.server.log_text())
            while f" id {request_id}\n" not in (self.folder / "access.log").read_text(encoding="utf-8"):
                self.assertIsNone(self.nginx.poll())

    def test_a_scene_goes_up_and_a_key_stays_out_of_the_logs(self):
        put = self.ask("/v1/scenes/mine", "-X", "PUT", *bearer(self.key), body=demo_glb("town"))
        self.assertEqual(put.status, 201)
        self.assertEqual(self.ask(f"/v1/scenes?key={self.key}").status, 401)
        self.assertEqual(self.ask("/v1/scenes/mine", "-X", "DELETE", *bearer(self.key)).status, 204)
        for text in (self.server.log_text(), *(file.read_text(encoding="utf-8") for file in self.folder.glob("*.log"))):
            self.assertNotIn(self.key, text)

    def test_a_refusal_comes_before_the_body_was_sent(self):
        with self.connect() as connection, connection.makefile("rb") as stream:
            connection.sendall(b"PUT /v1/scenes/x HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000000\r\n\r\nglTF")
            self.assertEqual(read_answer(stream).status, 401)

    def test_events_come_one_by_one(self):
        body = demo_glb("six")
        key = f"Authorization: Bearer {self.key}\r\n".encode()
        with self.server.connect() as upload, upload.makefile("rb") as uploaded:
            upload.sendall(b"PUT /v1/scenes/slow HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\nContent-Length: %d\r\n%s\r\n" % (len(body), key))
            self.assertEqual(read_answer(uploaded).status, 100)
            with self.connect() as watching, watching.makefile("rb") as events:
                watching.sendall(b"GET /v1/scenes/slow/events HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n%s\r\n" % key)
                # The first arrives while the scene, and so the stream, is far from its end.
                while b"event: progress" not in events.readline():
                    pass
                upload.sendall(body)
                rest = events.read()
                self.assertIn(b"event: ready", rest)
            self.assertEqual(read_answer(uploaded).status, 201)

    def test_a_long_answer_is_whole(self):
        rays = json.dumps({"rays": json.loads(QUERY)["rays"] * 20000, "fields": ["t"]})
        answer = self.ask("/v1/scenes/six/rays:closest", "-H", JSON_TYPE, *bearer(self.key), body=rays)
        self.assertEqual(answer.json(), {"hits": [{"t": 4.5}] * 20000})

    def test_what_is_no_tls_is_refused(self):
        self.assertEqual(curl(self.url.replace("https", "http") + "/healthz").status, 400)


class TlsStream(TlsCase):
    MODULE = Path("/usr/lib/nginx/modules/ngx_stream_module.so")

    @classmethod
    def configuration(cls):
        if not cls.MODULE.exists():
            raise unittest.SkipTest("libnginx-mod-stream is not installed")
        text = cls.in_place("nginx-stream.conf", ("        listen [::]:443 ssl;\n", ""), ("listen 443 ssl;", f"listen 127.0.0.1:{cls.port} ssl;"),
                            ("/var/log/nginx/sightline-stream.log", f"{cls.folder}/access.log"))
        return f"load_module {cls.MODULE};\nevents {{}}\n{text}"

    def test_a_long_stream_of_rays_comes_through(self):
        # Both ways more than what nginx, the kernel and the server hold of a stream.
        lines = '{"origin":[-10,1,0],"direction":[1,0,0]}\n' * 200_000
        answer = self.ask("/v1/scenes/six/rays:any", *bearer(self.key), "-H", "Content-Type: application/x-ndjson",
                          "-H", "Transfer-Encoding: chunked", "-X", "POST", body=lines)
        self.assertEqual(answer.status, 200)
        self.assertEqual((answer.body.count(b"\n"), answer.body[-200:].count(b"REQUEST_TIMEOUT")), (200_000, 0))

    def test_questions_follow_each_other_on_a_connection(self):
        with self.connect() as connection, connection.makefile("rb") as stream:
            for _ in range(2):
                connection.sendall(b"GET /v1/scenes/six HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer %s\r\n\r\n" % self.key.encode())
                self.assertEqual(read_answer(stream).status, 200)


if __name__ == "__main__":
    case_report.main()
