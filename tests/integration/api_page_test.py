"""docs/reference/api.md says what the server says."""

import unittest

import api_page
import case_report
from sightline_server import SOURCE, Server


class ApiPage(unittest.TestCase):
    def test_every_answer_of_the_page_is_what_the_server_says(self):
        with Server(*api_page.SERVED) as server:
            self.maxDiff = None
            self.assertEqual((SOURCE / "docs/reference/api.md").read_text(encoding="utf-8"), api_page.page(server.url),
                             "tests/integration/api_page.py BINARY --write writes it anew")


if __name__ == "__main__":
    case_report.main()
