"""The base of tests that only ask: one server with the demo scenes "six" and "town"."""

import json
import unittest

from sightline_server import Server


class TwoScenes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "six=demo:six", "--preload", "town=demo:town")
        cls.addClassCleanup(cls.server.end)

    def ask_json(self, path, body):
        """The answer to a JSON body, which must be 200."""
        answer = self.send_json(path, body)
        self.assertEqual(answer.status, 200, answer.body)
        return answer.json()

    def send_json(self, path, body):
        return self.server.ask(path, "-H", "Content-Type: application/json", body=json.dumps(body))
