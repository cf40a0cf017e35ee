"""Large batches of many clients at once, with the default limits of memory of the server."""

import array
import hashlib
import json
import random
import struct
import threading
import unittest
from http.client import HTTPConnection

import case_report
from sightline_server import Server

RAYS = 1_000_000
JSON_RAYS = 300_000
CLIENTS = 8


def rays_of(count):
    numbers = random.Random(7)
    return [(numbers.uniform(-9, 9), 9.0, numbers.uniform(-9, 9), 0.0, -1.0, 0.0) for _ in range(count)]


def ask(server, body, headers):
    """Status, code of a problem, and the hash of the answer."""
    connection = HTTPConnection("127.0.0.1", server.port, timeout=600)
    connection.request("POST", "/v1/scenes/town/rays:closest", body, headers)
    answer = connection.getresponse()
    text = answer.read()
    connection.close()
    code = json.loads(text).get("code") if answer.status != 200 else None
    return answer.status, code, hashlib.sha256(text).hexdigest()


class ManyBatches(unittest.TestCase):
    def setUp(self):
        # Each is answered in the end, however slow the machine is.
        self.server = Server("--preload", "town=demo:town", "--request-seconds", 600, memory=None)
        self.addCleanup(self.server.end)

    def ask_together(self, body, headers):
        alone = ask(self.server, body, headers)
        self.assertEqual(alone[:2], (200, None))
        answers = [None] * CLIENTS

        def client(at):
            answers[at] = ask(self.server, body, headers)

        threads = [threading.Thread(target=client, args=(at,)) for at in range(CLIENTS)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(answers, [alone] * CLIENTS)

    def test_eight_clients_with_a_million_binary_rays_each_are_all_answered(self):
        # docs/reference/binary.md: six columns of float32.
        columns = [array.array("f", column).tobytes() for column in zip(*rays_of(RAYS))]
        body = struct.pack("<4sIQII", b"SLR1", 0, RAYS, 0, 0) + b"".join(columns)
        self.ask_together(body, {"Content-Type": "application/octet-stream"})

    def test_eight_clients_with_300000_json_rays_each_are_all_answered(self):
        rays = [{"origin": ray[:3], "direction": ray[3:]} for ray in rays_of(JSON_RAYS)]
        self.ask_together(json.dumps({"rays": rays}), {"Content-Type": "application/json"})


if __name__ == "__main__":
    case_report.main()
