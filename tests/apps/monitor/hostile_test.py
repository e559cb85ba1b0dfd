# SPDX-License-Identifier: Apache-2.0
"""Hostile requests: each is refused, none changes anything, and the run is not affected."""
import http.client
import socket
import threading
import time
import unittest

from programs import MOST_MEMORY_MB, PASSWORD, Browser, Monitor, RealTimeRun, WatchedRun, key_of, monitor_command, until

OVERLONG = b"a" * 3000
STATES = ("execute", "suspended")


class Stream(threading.Thread):
    """Reads an event stream to its end."""

    def __init__(self, monitor: Monitor, key: str, headers: dict[str, str]) -> None:
        super().__init__(daemon=True)
        self.came = b""
        self.line = http.client.HTTPConnection("127.0.0.1", monitor.port, timeout=20)
        self.line.request("GET", f"/api/v1/runs/{key}/events-stream", headers=headers)
        self.reply = self.line.getresponse()
        self.start()

    def run(self) -> None:
        while piece := self.reply.read1():
            self.came += piece
        self.line.close()


class Hostile(WatchedRun):
    @classmethod
    def begin(cls) -> None:
        monitor_command(cls.folder, "user", "add", "ada", "--role", "operator", password=PASSWORD)
        monitor_command(cls.folder, "user", "add", "eve", "--role", "viewer", password=PASSWORD)
        cls.token = monitor_command(cls.folder, "token", "add", "script", "--role", "viewer").stdout.strip()
        cls.run_ = RealTimeRun(cls.folder)
        cls.run_.wait_for_profile()
        cls.monitor = Monitor(cls.folder, "--control")
        cls.ada = Browser(cls.monitor, "ada")
        cls.eve = Browser(cls.monitor, "eve")
        cls.key = key_of(cls.monitor, cls.ada.headers)

    def host(self) -> bytes:
        return b"Host: 127.0.0.1:%d\r\n" % self.monitor.port

    def heads(self) -> list[tuple[str, bytes, set[int]]]:
        """Returns whole requests with their permitted answers; 0: no answer and a closed connection."""
        host, run = self.host(), b"/api/v1/runs/" + self.key.encode()
        cookie = b"Cookie: " + self.ada.headers["Cookie"].encode() + b"\r\n"
        post = b"POST " + run + b"/pause HTTP/1.1\r\n" + host + cookie
        get = b"GET /api/v1/runs HTTP/1.1\r\n" + host
        body = b"Content-Type: application/json\r\nContent-Length: 2\r\n\r\n{}"
        return [
            ("foreign host", b"GET /api/v1/runs HTTP/1.1\r\nHost: evil.example\r\n\r\n", {421}),
            (
                "rebinding: a foreign host with the right port",
                b"GET / HTTP/1.1\r\nHost: evil.example:%d\r\n\r\n" % self.monitor.port,
                {421},
            ),
            ("host without a port", b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n", {421}),
            ("no host", b"GET / HTTP/1.1\r\n\r\n", {421}),
            ("host twice", b"GET / HTTP/1.1\r\n" + host + host + b"\r\n", {400}),
            ("host with a user", b"GET / HTTP/1.1\r\nHost: ada@127.0.0.1:%d\r\n\r\n" % self.monitor.port, {421}),
            (
                "host of a subdomain",
                b"GET / HTTP/1.1\r\nHost: localhost.evil.example:%d\r\n\r\n" % self.monitor.port,
                {421},
            ),
            ("absolute address", b"GET http://127.0.0.1/ HTTP/1.1\r\n" + host + b"\r\n", {400}),
            ("network path", b"GET //evil.example/ HTTP/1.1\r\n" + host + b"\r\n", {400}),
            ("asterisk", b"OPTIONS * HTTP/1.1\r\n" + host + b"\r\n", {405}),
            ("HTTP/0.9", b"GET /\r\n\r\n", {400}),
            ("HTTP/2", b"GET / HTTP/2.0\r\n" + host + b"\r\n", {505}),
            ("preface of HTTP/2", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", {400, 405, 505}),
            ("another protocol", b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + b"\n\n", {400}),
            ("TRACE", b"TRACE / HTTP/1.1\r\n" + host + b"\r\n", {405}),
            ("PUT", b"PUT " + run + b" HTTP/1.1\r\n" + host + body, {405}),
            ("DELETE", b"DELETE " + run + b" HTTP/1.1\r\n" + host + b"\r\n", {405}),
            ("PATCH", b"PATCH " + run + b" HTTP/1.1\r\n" + host + body, {405}),
            ("CONNECT", b"CONNECT 127.0.0.1:22 HTTP/1.1\r\n" + host + b"\r\n", {400, 405}),
            ("HEAD", b"HEAD / HTTP/1.1\r\n" + host + b"\r\n", {405}),
            ("a method in small letters", b"get / HTTP/1.1\r\n" + host + b"\r\n", {405}),
            ("two lengths", post + b"Content-Length: 2\r\nContent-Length: 40\r\n\r\n{}", {400}),
            ("length and chunks", post + b"Content-Length: 2\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n", {501}),
            ("chunks", post + b"Transfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n\r\n", {501}),
            ("a chunk of 2^63", post + b"Transfer-Encoding: chunked\r\n\r\n8000000000000000\r\n", {501}),
            ("odd encoding", post + b"Transfer-Encoding: xchunked\r\nContent-Length: 2\r\n\r\n{}", {501}),
            ("encoding hidden by a tab", post + b"Transfer-Encoding:\tchunked\r\nContent-Length: 2\r\n\r\n{}", {501}),
            ("a blank before the colon", post + b"Content-Length : 2\r\n\r\n{}", {400}),
            ("negative length", post + b"Content-Length: -1\r\n\r\n{}", {400}),
            ("length with a sign", post + b"Content-Length: +2\r\n\r\n{}", {400}),
            ("length as hexadecimal", post + b"Content-Length: 0x2\r\n\r\n{}", {400}),
            ("length of 2^64 and more", post + b"Content-Length: 18446744073709551618\r\n\r\n{}", {413}),
            ("a body of a gigabyte", post + b"Content-Length: 1000000000\r\n\r\n" + b"x" * 100_000, {413}),
            ("no length", post + b"\r\n", {411}),
            ("a GET with a body", get + b"Content-Length: 5\r\n\r\nhello", {400}),
            ("bare LF", get.replace(b"\r\n", b"\n") + b"\n", {400}),
            ("one bare LF among the headers", get + b"X: y\n\r\n", {400}),
            ("bare CR in a header", get + b"X: a\rb\r\n\r\n", {400}),
            ("folded header", get + b"X: a\r\n b\r\n\r\n", {400}),
            ("header without a name", get + b": a\r\n\r\n", {400}),
            ("header without a colon", get + b"nonsense\r\n\r\n", {400}),
            ("NUL in a header", get + b"X: a\x00b\r\n\r\n", {400}),
            ("NUL in the address", b"GET /api\x00/v1 HTTP/1.1\r\n" + host + b"\r\n", {400}),
            ("an encoded NUL", b"GET /api%00/v1 HTTP/1.1\r\n" + host + b"\r\n", {400}),
            ("climbing", b"GET /../../etc/passwd HTTP/1.1\r\n" + host + b"\r\n", {400}),
            ("climbing, encoded", b"GET /%2e%2e/%2e%2e/etc/passwd HTTP/1.1\r\n" + host + b"\r\n", {400}),
            ("climbing, slashes encoded", b"GET /..%2f..%2fetc%2fpasswd HTTP/1.1\r\n" + host + b"\r\n", {400}),
            (
                "climbing, encoded twice",
                b"GET " + run + b"/files/%252e%252e%252fusers.json HTTP/1.1\r\n" + host + cookie + b"\r\n",
                {404},
            ),
            ("climbing with backslashes", b"GET /..%5c..%5cetc HTTP/1.1\r\n" + host + b"\r\n", {400}),
            (
                "climbing from the files of a run",
                b"GET " + run + b"/files/../state/users.json HTTP/1.1\r\n" + host + cookie + b"\r\n",
                {400},
            ),
            ("overlong UTF-8", b"GET /%c0%ae%c0%ae/ HTTP/1.1\r\n" + host + b"\r\n", {400}),
            ("half an escape", b"GET /%2 HTTP/1.1\r\n" + host + b"\r\n", {400}),
            ("a fragment", b"GET /#x HTTP/1.1\r\n" + host + b"\r\n", {400}),
            (
                "a parameter twice",
                b"GET " + run + b"/series?from=1&from=2 HTTP/1.1\r\n" + host + cookie + b"\r\n",
                {400},
            ),
            ("an overlong address", b"GET /" + OVERLONG + b" HTTP/1.1\r\n" + host + b"\r\n", {414}),
            ("an overlong header", get + b"X: " + OVERLONG * 4 + b"\r\n\r\n", {431}),
            ("an overlong name of a header", get + OVERLONG * 4 + b": x\r\n\r\n", {431}),
            ("a header that never ends", get + b"X: " + b"y" * 1_000_000, {431, 0}),
            ("200 headers", get + b"".join(b"X%d: y\r\n" % i for i in range(200)) + b"\r\n", {431}),
            ("Expect", post + b"Expect: 100-continue\r\nContent-Length: 2\r\n\r\n", {501}),
            ("Upgrade", get + b"Connection: Upgrade\r\nUpgrade: websocket\r\n\r\n", {501}),
            (
                "a request in the body of another",
                post
                + b"Content-Type: application/json\r\nContent-Length: 60\r\n\r\n{}POST "
                + run
                + b"/abort HTTP/1.1\r\n\r\n"
                + b" " * 60,
                {400, 403},
            ),
            ("a line break in the address", b"GET /a%0d%0aSet-Cookie:x HTTP/1.1\r\n" + host + b"\r\n", {400}),
        ]

    def test_nothing_that_is_malformed_is_understood(self) -> None:
        heads = self.heads()
        self.assertGreaterEqual(len(heads), 60)
        for name, request, allowed in heads:
            with self.subTest(name):
                reply = self.monitor.raw(request, 1.5)
                status = int(reply[9:12]) if reply.startswith(b"HTTP/1.1 ") else 0
                self.assertIn(status, allowed, reply[:300])
                self.assertNotIn(b"root:", reply)
            time.sleep(0.05)
        self.expect_undisturbed()

    def expect_undisturbed(self) -> None:
        before = self.run_.acknowledged
        self.assertTrue(until(lambda: self.run_.acknowledged > before))
        run = self.ada.ask(f"/api/v1/runs/{self.key}").json
        self.assertEqual(run["state"], "execute")
        kinds = [event["kind"] for event in self.ada.ask(f"/api/v1/runs/{self.key}/events").json["events"]]
        self.assertNotIn("command", kinds)

    def expect_refused(self, name: str, answer, status: set[int]) -> None:
        with self.subTest(name):
            self.assertIn(answer.status, status, answer.body)

    def test_nobody_who_may_not_speaks_to_a_run(self) -> None:
        pause, abort = f"/api/v1/runs/{self.key}/pause", f"/api/v1/runs/{self.key}/abort"
        ada, eve, monitor = self.ada, self.eve, self.monitor
        script = {"Authorization": "Bearer " + self.token}
        origin = {k: ada.headers[k] for k in ("Origin", "Sec-Fetch-Site")}
        cookie, secret = ada.headers["Cookie"].split("=", 1)
        rows = [
            ("anonymous", monitor.ask(pause, {}), {401}),
            ("anonymous from the page", monitor.ask(pause, {}, origin), {401}),
            ("a viewer", eve.ask(pause, {}), {403}),
            ("a viewer's token", monitor.ask(pause, {}, script), {403}),
            ("without the second secret", ada.ask(pause, {}, without="X-CSRF-Token"), {403}),
            ("with another's second secret", ada.ask(pause, {}, X_CSRF_Token=eve.headers["X-CSRF-Token"]), {403}),
            ("with a wrong second secret", ada.ask(pause, {}, X_CSRF_Token="A" * 43), {403}),
            ("from another site", ada.ask(pause, {}, Origin="http://evil.example"), {403}),
            ("from another port", ada.ask(pause, {}, Origin="http://127.0.0.1:1"), {403}),
            ("from no site", ada.ask(pause, {}, Origin="null"), {403}),
            ("from a cross-site form", ada.ask(pause, {}, Sec_Fetch_Site="cross-site"), {403}),
            ("from a sibling site", ada.ask(pause, {}, Sec_Fetch_Site="same-site"), {403}),
            ("by TLS that is not", ada.ask(pause, {}, Origin=ada.headers["Origin"].replace("http", "https")), {403}),
            (
                "not saying where from",
                monitor.ask(pause, {}, {k: v for k, v in ada.headers.items() if k not in origin}),
                {403},
            ),
            ("as a form", ada.ask(pause, {}, Content_Type="application/x-www-form-urlencoded"), {400}),
            ("as text", ada.ask(pause, {}, Content_Type="text/plain"), {400}),
            ("a forged cookie", ada.ask(pause, {}, Cookie=f"{cookie}=" + "A" * 43), {401}),
            ("a cookie cut short", ada.ask(pause, {}, Cookie=f"{cookie}={secret[:-1]}"), {401}),
            ("a cookie with one letter more", ada.ask(pause, {}, Cookie=f"{cookie}={secret}A"), {401}),
            ("the secret in the query", monitor.ask(f"{pause}?{cookie}={secret}", {}, origin), {401}),
            ("a wrong token", monitor.ask(pause, {}, {"Authorization": "Bearer " + "A" * 43}), {401}),
            ("a token of another kind", monitor.ask(pause, {}, {"Authorization": "Basic YWRhOmFkYQ=="}), {401}),
            ("the token in the query", monitor.ask("/api/v1/runs?token=" + self.token), {401}),
            ("an unknown verb", ada.ask(f"/api/v1/runs/{self.key}/go", {}), {404}),
            (
                "a verb of the socket that is not the page's",
                ada.ask(f"/api/v1/runs/{self.key}/told", {"text": "x"}),
                {404},
            ),
            ("a run that is none", ada.ask("/api/v1/runs/0000000000000000/pause", {}), {404}),
            ("an unknown key", ada.ask(pause, {"who": "root"}), {400}),
            ("a line break in a note", ada.ask(f"/api/v1/runs/{self.key}/note", {"text": "a\nb"}), {400}),
            ("another user in a note", ada.ask(f"/api/v1/runs/{self.key}/note", {"text": ""}), {400}),
            ("an abort that nobody confirmed", ada.ask(abort, {}), {409}),
            ("an abort with a word that was not given", ada.ask(abort, {"confirm": "A" * 43}), {409}),
            (
                "an abort with the word for a stop",
                ada.ask(abort, {"confirm": ada.ask(f"/api/v1/runs/{self.key}/stop", {}).json["confirm"]}),
                {409},
            ),
            ("an abort by a GET", ada.ask(abort), {404}),
            ("who is logged in", ada.ask("/api/v1/sessions"), {403}),
            ("an anonymous look", monitor.ask("/api/v1/runs"), {401}),
            ("an anonymous look at the figures", monitor.ask("/metrics"), {401}),
            ("the file of users", ada.ask(f"/api/v1/runs/{self.key}/files/users.json"), {404}),
            ("the record that is being written", ada.ask(f"/api/v1/runs/{self.key}/files/run.db"), {404}),
        ]
        for name, answer, status in rows:
            self.expect_refused(name, answer, status)
        self.expect_undisturbed()

    def test_a_stream_ends_with_its_user_its_token_and_its_session(self) -> None:
        for name in ("mal", "sue"):
            monitor_command(self.folder, "user", "add", name, "--role", "viewer", password=PASSWORD)
        monitor_command(self.folder, "user", "add", "root", "--role", "administrator", password=PASSWORD)
        token = monitor_command(self.folder, "token", "add", "feed", "--role", "viewer").stdout.strip()
        mal, sue, root = (Browser(self.monitor, name) for name in ("mal", "sue", "root"))
        headers = {"mal": mal.headers, "sue": sue.headers, "feed": {"Authorization": "Bearer " + token}}
        streams = {name: Stream(self.monitor, self.key, one) for name, one in headers.items()}
        others = Stream(self.monitor, self.key, self.eve.headers)
        self.assertTrue(until(lambda: all(b"id:" in stream.came for stream in (*streams.values(), others))))
        self.assertEqual(root.ask("/api/v1/sessions", {"user": "sue"}).status, 200)
        for name in ("mal", "feed"):
            self.assertEqual(monitor_command(self.folder, "user", "remove", name).returncode, 0)
        for name, stream in streams.items():
            with self.subTest(name):
                stream.join(60)
                self.assertFalse(stream.is_alive(), "it is told more")
        self.assertTrue(others.is_alive(), "of another user")
        monitor_command(self.folder, "user", "add", "mal", "--role", "administrator", password=PASSWORD)
        self.assertEqual(mal.ask("/api/v1/runs").status, 401)
        for name in ("mal", "sue", "root"):
            monitor_command(self.folder, "user", "remove", name)

    def test_slow_senders_do_not_keep_others_out(self) -> None:
        lines = [socket.create_connection(("127.0.0.1", self.monitor.port)) for _ in range(48)]
        for line in lines:
            try:
                line.sendall(b"GET / HTTP/1.1\r\nHost: ")
            except OSError:
                pass
        self.assertTrue(until(lambda: self.tries()))
        for line in lines:
            line.close()
        self.assertLess(self.monitor.memory_mb, MOST_MEMORY_MB)
        self.expect_undisturbed()

    def tries(self) -> bool:
        try:
            return self.monitor.ask("/api/v1/session").status == 200
        except OSError:
            return False

    def test_every_answer_tells_the_browser_to_be_careful(self) -> None:
        for path in ("/", "/page.js", "/api/v1/session", "/nothing"):
            headers = self.monitor.ask(path).headers
            self.assertIn("default-src 'none'", headers["content-security-policy"])
            self.assertNotIn("unsafe", headers["content-security-policy"])
            self.assertEqual(headers["x-content-type-options"], "nosniff")
            self.assertEqual(headers["referrer-policy"], "no-referrer")
            self.assertNotIn("access-control-allow-origin", headers)


if __name__ == "__main__":
    unittest.main(verbosity=1)
