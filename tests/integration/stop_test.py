"""A stop: /readyz tells, what has begun is finished, silence ends, and a second signal does not wait."""

import re
import signal
import socket
import threading
import unittest

import case_report
from sightline_server import PATIENCE, Server, curl, demo_glb, read_answer

HEALTH = b"GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n"


class Stop(unittest.TestCase):
    def test_two_hundred_idle_connections_and_half_a_head_delay_nothing(self):
        with Server("--preload", "six=demo:six", "--drain-seconds", PATIENCE) as server:
            held = [server.connect() for _ in range(200)]
            for connection in held[:50]:  # some have asked before
                connection.sendall(HEALTH)
                with connection.makefile("rb") as stream:
                    self.assertEqual(read_answer(stream).status, 200)
            held[-1].sendall(b"GET /healthz HTTP/1.1\r\nHo")
            self.assertEqual(server.stop(), 0)
            self.assertNotIn("breaking off", server.log_text())
            for connection in held:
                connection.close()

    def test_readyz_says_so_first(self):
        with Server("--preload", "six=demo:six", "--notice-seconds", PATIENCE) as server:
            server.signal()
            while (answer := curl(server.url + "/readyz")).status == 200:
                pass
            self.assertEqual((answer.status, answer.json()["status"], answer.headers["retry-after"]), (503, "stopping", "1"))
            # Requests are answered until the notice is over. A second signal ends it.
            self.assertEqual(curl(server.url + "/healthz").status, 200)
            self.assertEqual(server.stop(), 0)

    def test_an_upload_that_has_begun_is_finished(self):
        body = demo_glb("six")
        with Server("--drain-seconds", PATIENCE, "--rate-seconds", PATIENCE) as server:
            upload = server.connect()
            with upload, upload.makefile("rwb") as stream:
                stream.write(b"PUT /v1/scenes/a HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\nContent-Length: %d\r\n\r\n" % len(body))
                stream.flush()
                self.assertEqual(read_answer(stream).status, 100)
                watching = server.connect()
                watching.sendall(b"GET /v1/scenes/a/events HTTP/1.1\r\nHost: x\r\n\r\n")
                events = watching.makefile("rb")
                while b"event: progress" not in events.readline():
                    pass
                server.signal()
                # The stream ends as a stream does, with its last chunk, and the rest of the upload is taken.
                rest = events.read()
                self.assertTrue(rest.endswith(b"0\r\n\r\n"), rest)
                with self.assertRaises(OSError):
                    while True:  # the door closes when the signal has come through
                        server.connect().close()
                stream.write(body)
                stream.flush()
                answer = read_answer(stream)
                self.assertEqual((answer.status, answer.headers.get("connection")), (201, "close"))
                watching.close()
            self.assertEqual(server.wait(), 0)

    def test_a_second_signal_does_not_wait(self):
        with Server("--drain-seconds", PATIENCE * 10, "--rate-seconds", PATIENCE * 10) as server:
            upload = server.connect()
            upload.sendall(b"PUT /v1/scenes/a HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\nContent-Length: 1000\r\n\r\n")
            with upload.makefile("rb") as stream:
                self.assertEqual(read_answer(stream).status, 100)
                server.signal()
                while "stopping" not in server.log_text():
                    pass
                server.signal(signal.SIGINT)
                self.assertEqual(server.wait(), 0)
            self.assertIn("breaking off", server.log_text())
            upload.close()

    def test_under_load_no_request_that_was_accepted_is_lost(self):
        for _ in range(5):
            with Server("--preload", "six=demo:six", "--drain-seconds", PATIENCE) as server:
                started, lost, answered = threading.Barrier(9), [], []

                def ask():
                    # Pipelined: what the server has not read when it says "close" it need not answer.
                    connection = server.connect()
                    started.wait()
                    with connection, connection.makefile("rb") as stream:
                        try:
                            while True:
                                connection.sendall(HEALTH)
                                answer = read_answer(stream)
                                if answer is None:
                                    return  # closed between two requests
                                answered.append(answer.status)
                                if answer.headers.get("connection") == "close":
                                    return
                        except (ConnectionError, IndexError):
                            return
                        except (ValueError, socket.timeout) as error:
                            lost.append(error)
                askers = [threading.Thread(target=ask) for _ in range(8)]
                for asker in askers:
                    asker.start()
                started.wait()
                while len(answered) < 200:
                    pass
                self.assertEqual(server.stop(), 0)
                for asker in askers:
                    asker.join()
                self.assertEqual((lost, set(answered)), ([], {200}))
                # Every answer that the server gave has arrived.
                given = len(re.findall(r"path=/healthz status=200", server.log_text()))
                self.assertEqual(len(answered), given)
                self.assertNotIn("breaking off", server.log_text())


if __name__ == "__main__":
    case_report.main()
