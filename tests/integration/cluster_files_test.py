"""The files in docker/ for several servers agree with each other, with the program and with its metrics.

No container engine and no cluster of Kubernetes runs here. HAProxy runs with its file in front of three servers. promtool and
kubectl check their files where they are installed.
"""

import http.client
import json
import os
import re
import shutil
import socket
import subprocess
import tempfile
import time
import unittest
from http.server import BaseHTTPRequestHandler
from pathlib import Path

import case_report
from balancer import PROGRAM, Balancer, free_ports
from handler_server import HandlerServer
from sightline_server import BINARY, JSON_TYPE, PATIENCE, SOURCE, Server, curl, demo_glb

try:
    import yaml
except ImportError:
    yaml = None

DOCKER = SOURCE / "docker"
RAY = '{"rays":[{"origin":[-10,1,0],"direction":[1,0,0]}],"fields":["t"]}'


def load(path):
    return yaml.safe_load(path.read_text(encoding="utf-8"))


def flags(command):
    """{flag: value} of `serve --flag=value ...`; each flag is in the help."""
    assert command[0] == "serve", command
    known = re.findall(r"^ +(--[a-z-]+)", subprocess.run([BINARY, "serve", "--help"], capture_output=True, text=True, check=True).stdout, re.MULTILINE)
    pairs = dict(word.partition("=")[::2] for word in command[1:])
    assert set(pairs) <= set(known), set(pairs) - set(known)
    return pairs


def metric_names(text):
    return set(re.findall(r"^([a-z_:]+)(?:\{| )", text, re.MULTILINE)) | set(re.findall(r"^# TYPE (\S+)", text, re.MULTILINE))


def is_open(port):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


class Forgetful(HandlerServer):
    """A server that is ready, reads each other request and closes the connection without an answer; `requests` counts them."""

    def __init__(self):
        outer = self
        self.requests = 0

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self):
                self.send_response(200)
                self.send_header("Content-Length", "0")
                self.end_headers()

            def lose(self):
                self.rfile.read(int(self.headers.get("Content-Length", 0)))
                outer.requests += 1
                self.close_connection = True

            do_POST = do_PUT = do_PATCH = do_DELETE = lose

        super().__init__(Handler)


class Files(unittest.TestCase):
    def setUp(self):
        if yaml is None:
            self.skipTest("python3-yaml is not installed")


class Compose(Files):
    def setUp(self):
        super().setUp()
        self.compose = load(DOCKER / "compose.yaml")
        self.services = self.compose["services"]

    def test_each_name_is_declared_and_each_file_exists(self):
        volumes = set()
        for name, service in self.services.items():
            self.assertLessEqual(set(service.get("depends_on", [])), set(self.services), name)
            self.assertLessEqual(set(service.get("secrets", [])), set(self.compose["secrets"]), name)
            for volume in service.get("volumes", []):
                source = volume.split(":")[0]
                if source.startswith("."):
                    self.assertTrue((DOCKER / source).exists(), volume)
                else:
                    volumes.add(source)
            if "build" in service:
                context = DOCKER / service["build"]["context"]
                dockerfile = context / service["build"]["dockerfile"]
                ignored = (SOURCE / ".dockerignore").read_text(encoding="utf-8").splitlines()
                for line in re.findall(r"^COPY (?!--from)(.*) \S+$", dockerfile.read_text(encoding="utf-8"), re.MULTILINE):
                    for source in line.split():
                        self.assertTrue(list(context.glob(source)), line)
                        self.assertTrue(any(f"!{each}" in ignored for each in (source, *map(str, Path(source).parents))), f".dockerignore hides {source}")
            for port in service.get("ports", []):
                self.assertTrue(port.startswith("127.0.0.1:"), "the servers have no keys")
        self.assertEqual(volumes, set(self.compose["volumes"]))
        default = re.search(r":-(.*)\}", self.compose["secrets"]["origin"]["file"])[1]
        self.assertTrue((DOCKER / default).exists())

    def test_the_image_has_all_that_its_build_reads(self):
        first, = re.findall("AS build\n(.*?)\nFROM ", (DOCKER / "Dockerfile").read_text(encoding="utf-8"), re.DOTALL)
        with tempfile.TemporaryDirectory() as folder:
            for line in re.findall(r"^COPY (.*) \S+$", first, re.MULTILINE):
                for source in (file for word in line.split() for file in SOURCE.glob(word)):
                    to = Path(folder, source.relative_to(SOURCE))
                    to.parent.mkdir(exist_ok=True)
                    shutil.copytree(source, to, ignore=shutil.ignore_patterns("__pycache__")) if source.is_dir() else shutil.copy(source, to)
            done = subprocess.run(["cmake", "--preset", "release", "-DSIGHTLINE_TESTS=OFF", "-DSIGHTLINE_PAGE=OFF"], cwd=folder, capture_output=True,
                                  text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)

    def test_servers_have_flags_of_the_program_and_wait_long_enough(self):
        replicas = [service for service in self.services.values() if service["image"] == "sightline"]
        self.assertEqual(len(replicas), 3)
        self.assertEqual(len({replica["volumes"][0] for replica in replicas}), 3)
        for replica in replicas:
            given = flags(replica["command"])
            self.assertEqual(given["--origin-credentials"], f"/run/secrets/{replica['secrets'][0]}")
            self.assertIn(f":{given['--data']}", replica["volumes"][0])
            grace = int(replica["stop_grace_period"].removesuffix("s"))
            self.assertGreater(grace, float(given["--drain-seconds"]) + float(given["--notice-seconds"]) + 5)

    def test_haproxy_gets_each_address_that_its_file_names(self):
        text = (DOCKER / "haproxy.cfg").read_text(encoding="utf-8")
        given = self.services["haproxy"]["environment"]
        self.assertEqual(set(re.findall(r'"\$\{([A-Z0-9]+)\}"', text)), set(given))
        for name, address in given.items():
            host, _, port = address.partition(":")
            if name.startswith("REPLICA"):
                self.assertEqual(port, flags(self.services[host]["command"])["--listen"].rpartition(":")[2])
        self.assertIn(f"127.0.0.1:8080{given['LISTEN']}", self.services["haproxy"]["ports"])

    def test_a_stopping_server_is_noticed_before_it_ends(self):
        interval, falls = re.search(r"inter (\d+)ms fall (\d+)", (DOCKER / "haproxy.cfg").read_text(encoding="utf-8")).groups()
        notice = float(flags(self.services["replica1"]["command"])["--notice-seconds"])
        self.assertGreater(notice * 1000, int(interval) * (int(falls) + 1))

    def test_prometheus_asks_all_and_grafana_asks_prometheus(self):
        targets = {job["job_name"]: job["static_configs"][0]["targets"] for job in load(DOCKER / "prometheus/prometheus.yml")["scrape_configs"]}
        haproxy = self.services["haproxy"]["environment"]
        self.assertEqual(targets, {"sightline": [haproxy[f"REPLICA{i}"] for i in (1, 2, 3)], "haproxy": ["haproxy" + haproxy["STATS"]]})
        for file in load(DOCKER / "prometheus/prometheus.yml")["rule_files"]:
            self.assertTrue((DOCKER / "prometheus" / file).exists())
        source = load(DOCKER / "grafana/datasources.yaml")["datasources"][0]
        self.assertEqual((source["url"], source["type"]), ("http://prometheus:9090", "prometheus"))
        folder = load(DOCKER / "grafana/dashboards.yaml")["providers"][0]["options"]["path"]
        self.assertTrue(any(f":{folder}/" in volume for volume in self.services["grafana"]["volumes"]))

    def test_the_store_has_the_keys_of_the_credentials(self):
        credentials = (DOCKER / "store/credentials").read_text(encoding="ascii")
        program = (SOURCE / "tests/cluster/radosgw.py").read_text(encoding="utf-8")
        key, secret, endpoint = (re.search(rf"^{name} = (.*)$", credentials, re.MULTILINE)[1]
                                 for name in ("aws_access_key_id", "aws_secret_access_key", "endpoint_url"))
        for text in (f"--access-key={key}", f"--secret-key={secret}"):
            self.assertIn(text, program)
        self.assertIn(f'"0.0.0.0:{endpoint.rpartition(":")[2]}"', (DOCKER / "store/Dockerfile").read_text(encoding="utf-8"))
        self.assertIn(endpoint.split("/")[2].split(":")[0], self.services)


class Alerts(Files):
    def test_each_names_metrics_that_there_are(self):
        with Server("--preload", "six=demo:six") as server:
            server.query("six", "closest", json.loads(RAY))
            known = metric_names(server.ask("/metrics").body.decode()) | {"up"}
            if PROGRAM:
                with Balancer([server.port, *free_ports(2)]) as balancer:
                    known |= metric_names(curl(balancer.stats_url + "/metrics").body.decode())
        names = set()
        for group in load(DOCKER / "prometheus/alerts.yml")["groups"]:
            for rule in group["rules"]:
                self.assertIn(rule["labels"]["severity"], ("warning", "critical"))
                self.assertTrue(rule["annotations"]["summary"])
                names.add(rule["alert"])
                used = set(re.findall(r"\b(?:sightline|process|haproxy)_\w+|\bup\b", re.sub(r'"[^"]*"', "", rule["expr"])))
                self.assertTrue(used, rule["alert"])
                for name in used:
                    if PROGRAM or not name.startswith("haproxy_"):
                        self.assertIn(re.sub("_bucket$", "", name) if name.endswith("_bucket") else name, known, rule["alert"])
        self.assertGreater(len(names), 8)
        guide = (SOURCE / "docs/guides/cluster.md").read_text(encoding="utf-8")
        self.assertEqual(set(re.findall(r"^\| `(Sightline\w+)`", guide, re.MULTILINE)), names)

    def test_promtool_accepts_them(self):
        if shutil.which("promtool") is None:
            self.skipTest("promtool is not installed")
        done = subprocess.run(["promtool", "check", "config", DOCKER / "prometheus/prometheus.yml"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


class Kubernetes(Files):
    FOLDER = DOCKER / "kubernetes"

    def setUp(self):
        super().setUp()
        kustomization = load(self.FOLDER / "kustomization.yaml")
        self.objects = [each for name in kustomization["resources"] for each in yaml.safe_load_all((self.FOLDER / name).read_text(encoding="utf-8"))]
        self.secrets = {each["metadata"]["name"]: each
                        for each in yaml.safe_load_all((self.FOLDER / "secrets.example.yaml").read_text(encoding="utf-8"))}
        self.pod = self.one("Deployment")["spec"]["template"]
        self.container, = self.pod["spec"]["containers"]
        self.ports = {port["name"]: port["containerPort"] for port in self.container["ports"]}

    def one(self, kind, name="sightline"):
        found, = (each for each in self.objects if each["kind"] == kind and each["metadata"]["name"] == name)
        return found

    def test_kustomize_builds_all_with_the_namespace_and_the_image(self):
        if shutil.which("kubectl") is None:
            self.skipTest("kubectl is not installed")
        done = subprocess.run(["kubectl", "kustomize", self.FOLDER], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        built = list(yaml.safe_load_all(done.stdout))
        self.assertEqual(sorted((each["kind"], each["metadata"]["name"]) for each in built),
                         sorted((each["kind"], each["metadata"]["name"]) for each in self.objects))
        for each in built:
            self.assertEqual(each["metadata"].get("namespace", each["metadata"]["name"]), "sightline")
            if each["kind"] == "Deployment":
                image = each["spec"]["template"]["spec"]["containers"][0]["image"]
                version = re.search(r"project\([^)]*VERSION (\S+)", (SOURCE / "CMakeLists.txt").read_text(encoding="utf-8"))[1]
                self.assertTrue(image.endswith(f"/sightline:{version}"), image)

    def test_no_file_is_forgotten(self):
        named = {"kustomization.yaml", *load(self.FOLDER / "kustomization.yaml")["resources"], "secrets.example.yaml", "ingress-nginx.patch.yaml"}
        self.assertEqual({file.name for file in self.FOLDER.iterdir()}, named)
        self.assertEqual({(each["kind"], each["apiVersion"]) for each in self.objects},
                         {("Namespace", "v1"), ("Deployment", "apps/v1"), ("Service", "v1"), ("HorizontalPodAutoscaler", "autoscaling/v2"),
                          ("PodDisruptionBudget", "policy/v1"), ("NetworkPolicy", "networking.k8s.io/v1"), ("Ingress", "networking.k8s.io/v1")})

    def test_selectors_select_the_servers(self):
        labels = self.pod["metadata"]["labels"]
        spread = self.pod["spec"]["topologySpreadConstraints"][0]
        selectors = [self.one("Deployment")["spec"]["selector"]["matchLabels"], self.one("Service")["spec"]["selector"],
                     self.one("Service", "sightline-replicas")["spec"]["selector"], self.one("PodDisruptionBudget")["spec"]["selector"]["matchLabels"],
                     self.one("NetworkPolicy")["spec"]["podSelector"]["matchLabels"], spread["labelSelector"]["matchLabels"]]
        for selector in selectors:
            self.assertTrue(selector and selector.items() <= labels.items(), selector)
        target = self.one("HorizontalPodAutoscaler")["spec"]["scaleTargetRef"]
        self.assertEqual(self.one(target["kind"], target["name"])["apiVersion"], target["apiVersion"])
        self.assertEqual(self.one("Service", "sightline-replicas")["spec"]["clusterIP"], "None")

    def test_ports_have_names_that_there_are(self):
        self.assertEqual(str(self.ports["http"]), flags(self.container["args"])["--listen"].rpartition(":")[2])
        self.assertEqual(str(self.ports["http"]), self.pod["metadata"]["annotations"]["prometheus.io/port"])
        for probe in ("startupProbe", "readinessProbe", "livenessProbe"):
            self.assertIn(self.container[probe]["httpGet"]["port"], self.ports)
        for name in ("sightline", "sightline-replicas"):
            self.assertIn(self.one("Service", name)["spec"]["ports"][0]["targetPort"], self.ports)
        for rule in self.one("NetworkPolicy")["spec"]["ingress"]:
            self.assertIn(rule["ports"][0]["port"], self.ports)
        backend = self.one("Ingress")["spec"]["rules"][0]["http"]["paths"][0]["backend"]["service"]
        self.assertIn(backend["port"]["name"], [port["name"] for port in self.one("Service", backend["name"])["spec"]["ports"]])

    def test_the_server_has_its_files_and_starts_with_these_flags(self):
        given = flags(self.container["args"])
        mounts = {mount["name"]: mount for mount in self.container["volumeMounts"]}
        volumes = {volume["name"]: volume for volume in self.pod["spec"]["volumes"]}
        self.assertEqual(set(mounts), set(volumes))
        for flag, volume in (("--keys", "keys"), ("--origin-credentials", "origin")):
            folder, _, file = given[flag].rpartition("/")
            self.assertEqual(mounts[volume]["mountPath"], folder)
            self.assertIn(file, self.secrets[volumes[volume]["secret"]["secretName"]]["stringData"])
        self.assertEqual((given["--data"], given["--spool-dir"]), (mounts["data"]["mountPath"], mounts["spool"]["mountPath"]))
        for flag, volume in (("--cache-bytes", "data"), ("--spool-bytes", "spool")):
            self.assertLess(int(given[flag]), int(volumes[volume]["emptyDir"]["sizeLimit"].removesuffix("Gi")) << 30)
        limits = self.container["resources"]["limits"]
        self.assertEqual(given["--threads"], limits["cpu"])
        self.assertLess(int(given["--memory"]) + int(given["--memory-budget"]), int(limits["memory"].removesuffix("Gi")) << 30)
        with tempfile.TemporaryDirectory() as folder:
            place = Path(folder)
            hashes = iter("0123456789")  # Each key may be there once.
            keys = re.sub("HASH", lambda _: next(hashes) * 64, self.secrets["sightline-keys"]["stringData"]["keys"])
            (place / "keys").write_text(keys, encoding="ascii")
            moved = {"--keys": f"{place}/keys", "--data": f"{place}/data", "--spool-dir": folder, "--origin": f"{place}/origin"}
            left_out = ("--listen", "--origin-credentials")
            with Server(*(f"{flag}={moved.get(flag, value)}" for flag, value in given.items() if flag not in left_out), memory=None) as server:
                for probe in ("startupProbe", "readinessProbe", "livenessProbe"):
                    self.assertEqual(server.ask(self.container[probe]["httpGet"]["path"]).status, 200, "a probe has no key")

    def test_a_stop_has_time_to_finish_and_is_noticed_before(self):
        given, probe = flags(self.container["args"]), self.container["readinessProbe"]
        self.assertGreater(self.pod["spec"]["terminationGracePeriodSeconds"], float(given["--notice-seconds"]) + float(given["--drain-seconds"]) + 5)
        self.assertGreater(float(given["--notice-seconds"]), probe["periodSeconds"] * (probe["failureThreshold"] + 1))

    def test_the_ingress_hashes_the_scene_of_the_path(self):
        annotations = self.one("Ingress")["metadata"]["annotations"]
        snippet = load(self.FOLDER / "ingress-nginx.patch.yaml")["data"]["http-snippet"]
        self.assertIn(f"map $uri {annotations['nginx.ingress.kubernetes.io/upstream-hash-by']} {{", snippet)
        program = shutil.which("nginx", path=os.environ["PATH"] + ":/usr/sbin")
        if program is None:
            self.skipTest("nginx is not installed")
        port, = free_ports(1)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "nginx.conf")
            temporary = "".join(f"{kind}_temp_path {folder}/{kind};\n" for kind in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi"))
            file.write_text(f"pid {folder}/pid;\nworker_processes 1;\nevents {{}}\nhttp {{\naccess_log off;\n{temporary}{snippet}"
                            f"server {{ listen 127.0.0.1:{port}; location / {{ return 200 $sightline_scene; }} }}\n}}\n", encoding="ascii")
            nginx = subprocess.Popen([program, "-e", "stderr", "-p", folder, "-c", file, "-g", "daemon off;"], stderr=subprocess.PIPE)
            try:
                end = time.monotonic() + PATIENCE
                while not is_open(port):
                    self.assertTrue(nginx.poll() is None and time.monotonic() < end, "nginx does not listen")
                for path, key in (("/v1/scenes/town/rays:closest", b"town"), ("/v1/scenes/town?wait=3", b"town"), ("/v1/scenes/town/nodes/3", b"town"),
                                  ("/v1/scenes", b"/v1/scenes"), ("/status", b"/status")):
                    self.assertEqual(curl(f"http://127.0.0.1:{port}{path}").body, key)
            finally:
                nginx.terminate()
                nginx.communicate()


class Haproxy(unittest.TestCase):
    def setUp(self):
        if PROGRAM is None:
            self.skipTest("HAProxy is not installed")

    def test_it_accepts_its_file(self):
        self.assertEqual(Balancer(free_ports(3)).check(), "")

    def test_a_scene_has_one_server_and_the_loss_of_a_server_fails_no_query(self):
        names = [f"s{i}" for i in range(12)]
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)  # After the servers have ended: they write trees until then.
        servers = []
        for i in range(3):
            servers.append(Server("--data", f"{folder.name}/{i}", "--origin", f"{folder.name}/origin"))
            self.addCleanup(servers[-1].end)
        with Balancer([server.port for server in servers]) as balancer:
            for name in names:
                self.assertEqual(curl(f"{balancer.url}/v1/scenes/{name}", "-X", "PUT", body=demo_glb("six")).status, 201)

            def ask_all():
                for name in names:
                    answer = curl(f"{balancer.url}/v1/scenes/{name}/rays:closest", "-H", JSON_TYPE, body=RAY)
                    self.assertEqual((answer.status, answer.body), (200, b'{"hits":[{"t":4.5}]}'))

            for _ in range(2):
                ask_all()
            ready = [int(re.search(r'sightline_scenes\{state="ready"\} (\d+)', server.ask("/metrics").body.decode())[1]) for server in servers]
            self.assertEqual(sum(ready), len(names), ready)
            self.assertLess(max(ready), len(names))
            servers[ready.index(max(ready))].kill()
            ask_all()

    def test_a_request_of_16_kib_is_sent_again_after_a_lost_answer(self):
        names = [f"s{i}" for i in range(8)]
        rays = json.dumps({"rays": [{"origin": [-10, 1, 0], "direction": [1, 0, 0]}] * 320, "fields": ["t"]})
        rays += " " * ((16 << 10) - len(rays))
        self.assertEqual(len(rays), 16 << 10)
        preload = [word for name in names for word in ("--preload", f"{name}=demo:six")]
        with Server(*preload) as server, Forgetful() as forgetful, Balancer([forgetful.port, server.port, server.port]) as balancer:
            for name in names:
                answer = curl(f"{balancer.url}/v1/scenes/{name}/rays:closest", "-H", JSON_TYPE, body=rays)
                self.assertEqual((answer.status, answer.body.count(b"4.5")), (200, 320))
            self.assertGreater(forgetful.requests, 0)

    def test_a_body_that_comes_after_its_head_is_sent_again(self):
        names = [f"s{i}" for i in range(8)]
        preload = [word for name in names for word in ("--preload", f"{name}=demo:six")]
        with Server(*preload) as server, Forgetful() as forgetful, Balancer([forgetful.port, server.port, server.port]) as balancer:
            for name in names:
                connection = http.client.HTTPConnection(balancer.url.removeprefix("http://"), timeout=PATIENCE)
                connection.putrequest("POST", f"/v1/scenes/{name}/rays:closest")
                connection.putheader("Content-Type", "application/json")
                connection.putheader("Content-Length", str(len(RAY)))
                connection.endheaders()
                time.sleep(0.1)  # HAProxy repeats nothing if it has sent the head alone.
                connection.send(RAY.encode())
                answer = connection.getresponse()
                self.assertEqual((answer.status, answer.read()), (200, b'{"hits":[{"t":4.5}]}'))
                connection.close()
            self.assertGreater(forgetful.requests, 0)

    def test_a_stream_is_passed_on_at_once(self):
        with Server("--preload", "six=demo:six") as server, Balancer([server.port] * 3) as balancer:
            connection = http.client.HTTPConnection(balancer.url.removeprefix("http://"), timeout=PATIENCE)
            connection.putrequest("POST", "/v1/scenes/six/rays:closest")
            connection.putheader("Content-Type", "application/x-ndjson")
            connection.putheader("Transfer-Encoding", "chunked")
            connection.endheaders()
            for line in (b'{"options":{"fields":["t"]}}\n', b'{"origin":[-10,1,0],"direction":[1,0,0]}\n'):
                connection.send(b"%x\r\n%s\r\n" % (len(line), line))
            answer = connection.getresponse()
            self.assertEqual(answer.status, 200)
            self.assertEqual(answer.readline(), b'{"t":4.5}\n')
            connection.send(b"0\r\n\r\n")
            self.assertEqual(answer.read(), b"")
            connection.close()

    def test_a_change_is_not_sent_again_after_a_lost_answer(self):
        with Forgetful() as forgetful, Balancer([forgetful.port] * 3) as balancer:
            for method, path in (("PUT", "/v1/scenes/s"), ("PATCH", "/v1/scenes/s/nodes/0"), ("DELETE", "/v1/scenes/s"), ("POST", "/v1/scenes")):
                before = forgetful.requests
                self.assertEqual(curl(balancer.url + path, "-X", method, "-H", JSON_TYPE, body="{}").status, 502)
                self.assertEqual(forgetful.requests, before + 1, method)


if __name__ == "__main__":
    case_report.main()
