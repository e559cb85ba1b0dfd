# SPDX-License-Identifier: Apache-2.0
"""Operators send commands to a run through the page, and the record contains their names. An alarm reaches a mail
server, and later the next address; after an acknowledgement it causes no more messages."""
import http.client
import json
import os
import pathlib
import pty
import pwd
import re
import shutil
import signal
import socket
import ssl
import subprocess
import termios
import threading
import time
import unittest

from programs import (
    GYROTHERM,
    MONITOR,
    PASSWORD,
    SOURCE,
    Browser,
    Folder,
    Monitor,
    RealTimeRun,
    gyrotherm,
    key_of,
    monitor_command,
    until,
)


class MailServer(threading.Thread):
    """Receives mail. Implements the part of SMTP that a client needs."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.letters: list[str] = []
        self.start()

    def run(self) -> None:
        while True:
            line, _ = self.listener.accept()
            with line, line.makefile("rwb") as talk:
                self.hear(talk)

    def hear(self, talk) -> None:
        def say(text: str) -> None:
            talk.write(text.encode() + b"\r\n")
            talk.flush()

        say("220 here")
        for word in talk:
            verb = word[:4].upper()
            if verb == b"DATA":
                say("354 go on")
                letter = b""
                for text in talk:
                    if text == b".\r\n":
                        break
                    letter += text
                self.letters.append(letter.decode())
                say("250 taken")
            elif verb == b"QUIT":
                return say("221 good night")
            else:
                say("250 yes")


SITE = """schema = "gyrotherm-site/1"
name = "laboratory"

[notify.mail]
server = "smtp://127.0.0.1:{port}"
from = "rig@example.org"
secure = false

[[notify.address]]
name = "night"
mail = ["ada@example.org"]

[[notify.address]]
name = "boss"
command = ["sh", "-c", "cat >> {folder}/boss.txt", "x"]

[[notify.rule]]
name = "alarms"
when = "alarm"
tell = ["night", "boss"]
after = "2 s"

[[notify.rule]]
when = "run ended"
tell = ["night"]
"""


class Control(unittest.TestCase):
    def setUp(self) -> None:
        self.holder = Folder()
        self.folder = self.holder.__enter__()
        for name, role in (("ada", "operator"), ("eve", "viewer"), ("root", "administrator")):
            self.assertEqual(
                monitor_command(self.folder, "user", "add", name, "--role", role, password=PASSWORD).returncode, 0
            )
        self.mail = MailServer()
        site = self.folder / "site.toml"
        site.write_text(SITE.format(port=self.mail.port, folder=self.folder))
        self.run_ = RealTimeRun(self.folder)
        self.monitor = Monitor(self.folder, "--control", "--site", str(site))
        self.ada = Browser(self.monitor, "ada")
        self.key = key_of(self.monitor, self.ada.headers)

    def tearDown(self) -> None:
        self.run_.end()
        self.monitor.stop()
        self.holder.__exit__()

    def tell(self, verb: str, **body: str):
        return self.ada.ask(f"/api/v1/runs/{self.key}/{verb}", body)

    def status(self) -> dict:
        return self.ada.ask(f"/api/v1/runs/{self.key}").json

    def test_an_operator_speaks_to_the_run_and_is_told_of_it_at_night(self) -> None:
        self.assertTrue(until(lambda: self.status()["state"] == "execute"))
        self.assertEqual(self.tell("note", text="door <b>opened</b>").status, 200)
        self.assertEqual(self.tell("pause").status, 200)
        self.assertTrue(until(lambda: self.status()["state"] == "held"))
        self.assertIn("ada", self.status()["cause"])
        self.assertEqual(self.tell("pause").status, 409, "it is held already")
        self.assertEqual(self.tell("resume", text="looked").status, 200)
        self.assertTrue(until(lambda: self.status()["state"] == "execute"))

        self.run_.move_set_point(24.0)
        self.assertTrue(until(lambda: self.status()["alarms"]))
        alarm = self.status()["alarms"][0]
        self.assertTrue(until(lambda: self.mail.letters))
        self.assertIn("Subject: Alarm: laboratory: SIMULATED run on virtual", self.mail.letters[0])
        self.assertIn("To: ada@example.org", self.mail.letters[0])
        boss = self.folder / "boss.txt"
        self.assertTrue(until(boss.exists), "nobody acknowledges: the next address")
        memory = self.folder / "state" / "told.json"
        self.assertTrue(until(lambda: '"steps": 2' in memory.read_text()))
        self.monitor.kill()
        self.monitor.again()
        self.assertEqual(self.tell("acknowledge", alarm=str(alarm["number"])).status, 400, "without a comment")
        self.assertTrue(
            until(lambda: self.tell("acknowledge", alarm=str(alarm["number"]), text="I am coming").status == 200)
        )
        self.assertTrue(until(lambda: all(one["acknowledged"] for one in self.status()["alarms"])))
        self.assertEqual(self.tell("acknowledge", alarm=str(alarm["number"]), text="again").status, 409)
        letters = len(self.mail.letters)
        time.sleep(2.5)
        self.assertEqual(len(self.mail.letters), letters, "told once, over a restart too")
        self.assertEqual(boss.read_text().count("rule"), 1)

        asked = self.tell("stop")
        self.assertEqual(asked.status, 409)
        self.assertRegex(asked.json["question"], r"done, .* left\..*A stop is final")
        self.assertIn("safe set point, ", asked.json["question"], "what becomes of the chamber, with the temperature")
        self.assertNotIn("error", asked.json)
        late = self.tell("stop", confirm="A" * 43, text="the day is over")
        self.assertEqual(late.status, 409)
        self.assertIn("stop was not sent", late.json["error"])
        self.assertIn("question", late.json)
        self.assertEqual(self.tell("stop", confirm=late.json["confirm"], text="the day is over").status, 200)
        self.assertEqual(self.run_.run.wait(timeout=60), 0)
        self.assertTrue(until(lambda: any("Subject: Ended" in letter for letter in self.mail.letters)))
        self.expect_in_the_record(alarm["number"])

    def expect_in_the_record(self, alarm: int) -> None:
        events = self.run_.events()
        for kind, pattern in (
            ("note", r"door <b>opened</b>"),
            ("command", r"pause.*ada \(through|ada \(through.*pause"),
            ("command", "resume"),
            ("command", "stop.*: the day is over"),
            ("acknowledged", rf"{alarm}.*ada \(through .*I am coming"),
            ("told", r"night was notified of alarm"),
            ("told", r"boss was notified of alarm"),
        ):
            with self.subTest(kind=kind, pattern=pattern):
                self.assertTrue(any(one == kind and re.search(pattern, text) for one, text in events), events)
        verified = gyrotherm("status", str(self.run_.record), "--verify")
        self.assertEqual(verified.returncode, 0, verified.stderr)


class Shelving(unittest.TestCase):
    """A shelved alarm causes no notification until its time is over, also if the run is killed meanwhile."""

    def test_it_is_announced_again_when_its_time_is_over(self) -> None:
        with Folder() as folder:
            self.holder = folder
            for name, role in (("ada", "operator"), ("eve", "viewer")):
                self.assertEqual(
                    monitor_command(folder, "user", "add", name, "--role", role, password=PASSWORD).returncode, 0
                )
            mail, site = MailServer(), folder / "site.toml"
            site.write_text(SITE.format(port=mail.port, folder=folder).replace('"night", "boss"', '"night"'))
            run = RealTimeRun(folder, rig_end='\n[policy]\nforeign_set_point = "warn"\n')
            monitor = Monitor(folder, "--control", "--site", str(site))
            try:
                self.follow(run, monitor, mail)
            finally:
                run.end()
                monitor.stop()

    def follow(self, run: RealTimeRun, monitor: Monitor, mail: MailServer) -> None:
        ada, eve = Browser(monitor, "ada"), Browser(monitor, "eve")
        page = f"/api/v1/runs/{key_of(monitor, ada.headers)}"
        row = lambda: (ada.ask(page).json["alarms"] or [{}])[0]
        run.move_set_point(24.0)
        alarm = until(row)
        number = str(alarm["number"])
        self.assertEqual((alarm["reaction"], alarm["priority"]), ("warn", "low"))
        self.assertNotIn("shelved_by", alarm)
        self.assertTrue(until(lambda: mail.letters))

        good = {"alarm": number, "time": "6 s", "text": "the <b>fan</b>"}
        self.assertEqual(eve.ask(f"{page}/shelve", good).status, 403, "a viewer")
        for wrong in ({"time": ""}, {"time": "0 s"}, {"time": "-1 h"}, {"time": "25 h"}, {"text": ""},
                      {"text": " "}, {"alarm": ""}, {"alarm": "all"}, {"time": "1 h 30 min"}):
            self.assertEqual(ada.ask(f"{page}/shelve", good | wrong).status, 400, wrong)
        self.assertEqual(ada.ask(f"{page}/shelve", good | {"alarm": "99999"}).status, 409)
        self.assertEqual(ada.ask(f"{page}/unshelve", {"alarm": number}).status, 409, "it is not shelved")
        self.assertEqual(ada.ask(f"{page}/shelve", good).status, 200)
        self.assertTrue(until(lambda: row().get("shelved_by")))
        shelved = row()
        self.assertRegex(shelved["shelved_by"], r"^ada \(through ")
        self.assertEqual((shelved["shelving_reason"], shelved["acknowledged"]), ("the <b>fan</b>", True))
        self.assertEqual(ada.ask(f"{page}/shelve", good).status, 409, "it is shelved already")
        self.assertIn('gyrotherm_run_alarms{', metrics := ada.ask("/metrics").body.decode())
        self.assertRegex(metrics, r"gyrotherm_run_alarms\{[^}]*\} 0\n")

        again = until(lambda: (now := row()) and not now.get("shelved_by") and now, 30)
        self.assertTrue(again and again["active"] and not again["acknowledged"], again)
        self.assertGreater(again["number"], int(number))
        self.assertTrue(until(lambda: len(mail.letters) == 2), "notified again")

        told = gyrotherm("tell", str(run.record), "shelve", str(again["number"]), "45 s", "known")
        self.assertEqual(told.returncode, 0, told.stderr)
        shown = lambda: gyrotherm("status", str(run.record)).stdout
        self.assertTrue(until(lambda: re.search(r"shelved alarm \d+ .*\n +shelved until .*: known", shown())), shown())
        self.assertTrue(until(lambda: run.acknowledged > row()["slot"] + 3))
        self.resume(run)
        kept = gyrotherm("status", "--json", str(run.record))
        alarms = [one for one in json.loads(kept.stdout)["alarms"] if one["interlock"] == "foreign_set_point"]
        self.assertEqual([one["shelving_reason"] for one in alarms], ["known"], kept.stdout)
        over = lambda: any("unshelved: the time is over" in event["text"] and event["slot"] > again["slot"] + 40
                           for event in ada.ask(f"{page}/events").json["events"])
        self.assertTrue(until(over, 90), ada.ask(f"{page}/events").body)

    def resume(self, run: RealTimeRun) -> None:
        """Kills the program of the run and resumes it when its guard has made the chamber safe."""
        run.run.kill()
        run.run.wait()
        self.assertTrue(until(lambda: gyrotherm("status", str(run.record), "--json").stdout.find('"made_safe":null') < 0))
        with open(self.holder / "run.log", "a", encoding="utf-8") as log:
            run.run = subprocess.Popen([GYROTHERM, "resume", run.record, "--accept", "--json"], stdout=log, stderr=log,
                                       cwd=SOURCE)
        is_written = lambda: json.loads(gyrotherm("status", "--json", str(run.record)).stdout or "{}").get("answers")
        self.assertTrue(until(is_written, 60), (self.holder / "run.log").read_text())


class Units(unittest.TestCase):
    """A run that waits for serial numbers asks on the page, as a profile does."""

    def test_an_operator_answers_the_question(self) -> None:
        with Folder() as folder:
            self.assertEqual(
                monitor_command(folder, "user", "add", "ada", "--role", "operator", password=PASSWORD).returncode, 0
            )
            made = ["python3", SOURCE / "tests/apps/gyrotherm/real_rig.py", SOURCE / "profiles/rigs/virtual.toml"]
            rig = subprocess.run([*made, "1", "1", "1", "1"], capture_output=True, text=True, check=True).stdout
            (folder / "rig.toml").write_text(rig.replace('serial_number = "V-1"\n', ""))
            run = subprocess.Popen(
                [GYROTHERM, "run", "tests/profiles/ten-seconds.toml", "--rig", folder / "rig.toml",
                 "--wait-for-units", "--out", folder / "run.db"],
                stderr=subprocess.PIPE, text=True, cwd=SOURCE,
            )
            monitor = Monitor(folder, "--control")
            try:
                ada = Browser(monitor, "ada")
                page = f"/api/v1/runs/{key_of(monitor, ada.headers)}"
                self.assertTrue(until(lambda: ada.ask(page).json["state"] == "held"))
                status = ada.ask(page).json
                self.assertEqual(status["cause"], "answer with the serial number of the unit")
                self.assertEqual((status["running"], status["units"], status["order_number"]), (True, [], ""))
                refused = ada.ask(f"{page}/resume", {"text": "x" * 65})
                self.assertEqual(refused.status, 409)
                self.assertIn("has 65 bytes, expected at most 64", refused.json["error"])
                taken = ada.ask(f"{page}/resume", {"text": "0042"})
                self.assertEqual((taken.status, taken.json), (200, {"done": "gyro 0042"}))
                said = run.communicate(timeout=60)[1]
                self.assertIn("units: gyro 0042", said)
                self.assertEqual(run.returncode, 3, "the instruments do not answer")
            finally:
                run.kill()
                run.wait()
                self.assertEqual(monitor.stop(), 0)


class Starts(unittest.TestCase):
    """Options that would admit unknown clients are refused before the monitor listens."""

    def starts(self, *options: str) -> tuple[int, str]:
        with Folder() as folder:
            ran = subprocess.run(
                [MONITOR, "--state", str(folder / "state"), *options],
                capture_output=True,
                text=True,
                timeout=20,
                check=False,
            )
            return ran.returncode, ran.stderr

    def test_only_as_far_as_is_safe(self) -> None:
        folder = str(pathlib.Path(__file__).parent)
        for options, why in (
            (("--listen", "127.0.0.1:0"), "--folder"),
            (("--folder", folder, "--listen", "0.0.0.0:0"), "users"),
            (("--folder", folder, "--control"), "requires users"),
            (("--folder", "/nothing/there"), "is not a folder"),
            (("--folder", folder, "--listen", "somewhere"), "ADDRESS:PORT"),
            (("--folder", folder, "--nonsense"), "--nonsense"),
            (("--folder", folder, "--certificate", "x"), "--key"),
            (("--folder", folder, "--behind-proxy", "--listen", "0.0.0.0:1"), "requires --listen on 127.0.0.1"),
            (("--folder", folder, "--host", "http://rig1"), "is not a host name"),
        ):
            with self.subTest(options):
                code, said = self.starts(*options)
                self.assertEqual(code, 2, said)
                self.assertIn(why, said)
        code, said = self.starts("--folder", folder, "--site", __file__)
        self.assertEqual(code, 4, said)
        self.assertIn("control_test.py:", said)

    def test_a_refusal_says_how_users_are_added_where_it_looks(self) -> None:
        with Folder() as folder:
            refused = monitor_command(folder, "--folder", str(folder), "--listen", "127.0.0.1:0", "--control")
            self.assertEqual(refused.returncode, 2, refused.stderr)
            words = re.search(r"gyrotherm-monitor (user add .*)", refused.stderr)[1].replace("NAME", "ada").split()
            added = subprocess.run(
                [MONITOR, *words], input=PASSWORD, capture_output=True, text=True, timeout=30, check=False
            )
            self.assertEqual(added.returncode, 0, added.stderr)
            monitor = Monitor(folder, "--control")
            Browser(monitor, "ada")
            self.assertEqual(monitor.stop(), 0)

    @unittest.skipUnless(os.geteuid() == 0, "only root can write into another user's folder")
    def test_root_adds_nobody_to_another_users_folder(self) -> None:
        with Folder() as folder:
            state, added = folder / "state", ("user", "add", "ada", "--role", "viewer")
            state.mkdir(mode=0o700)
            os.chown(state, 65534, 65534)
            refused = monitor_command(folder, *added, password=PASSWORD)
            self.assertEqual(refused.returncode, 4, refused.stderr)
            self.assertIn(f"belongs to {pwd.getpwuid(65534).pw_name}", refused.stderr)
            self.assertEqual(list(state.iterdir()), [])
            os.chown(state, 0, 0)
            self.assertEqual(monitor_command(folder, *added, password=PASSWORD).returncode, 0)

    def test_the_cause_of_a_wrong_command_line_is_said(self) -> None:
        for words, said in (
            (("--foldr", "runs"), "--foldr is not an option of gyrotherm-monitor. Did you mean --folder?"),
            (("usr", "add", "ada", "--role", "viewer"), '"usr" is not a command. Did you mean "user"?'),
            (("user", "ad", "ada", "--role", "viewer"), '"ad" is not a command. Did you mean "add"?'),
        ):
            refused = subprocess.run([MONITOR, *words], capture_output=True, text=True, timeout=30, check=False)
            self.assertEqual(refused.returncode, 2)
            self.assertIn(said, refused.stderr)

    def test_a_terminal_shows_again_what_is_typed_whatever_ends_the_prompt(self) -> None:
        def is_shown() -> bool:
            return termios.tcgetattr(terminal)[3] & termios.ECHO != 0

        for key in (b"\x03", b"\x1c", PASSWORD.encode() + b"\n"):
            with Folder() as folder:
                screen, terminal = pty.openpty()
                words = [MONITOR, "user", "add", "ada", "--role", "viewer", "--state", folder / "state"]
                asked = subprocess.Popen(
                    ["setsid", "--ctty", "--wait", *words], stdin=terminal, stdout=terminal, stderr=terminal
                )
                until(lambda: not is_shown())
                os.write(screen, key)
                asked.wait(60)
                self.assertTrue(is_shown(), f"after {key!r}")
                os.close(screen)
                os.close(terminal)

    def test_users_are_added_listed_and_removed(self) -> None:
        with Folder() as folder:
            self.assertEqual(
                monitor_command(folder, "user", "add", "ada", "--role", "operator", password="short").returncode, 2
            )
            self.assertEqual(
                monitor_command(folder, "user", "add", "ada", "--role", "boss", password=PASSWORD).returncode, 2
            )
            self.assertEqual(
                monitor_command(folder, "user", "add", "ada", "--role", "operator", password=PASSWORD).returncode, 0
            )
            elsewhere = [MONITOR, "user", "list", "--state", folder / "none"]
            self.assertEqual(subprocess.run(elsewhere, check=False).returncode, 0)
            self.assertFalse((folder / "none").exists(), "a list creates no folder")
            monitor_command(folder, "user", "add", "bob", "--role", "viewer", password=PASSWORD)
            replaced = monitor_command(folder, "user", "add", "bob", "--role", "operator", password=PASSWORD)
            self.assertIn("bob: replaced the password; role viewer → operator", replaced.stderr)
            monitor_command(folder, "user", "remove", "bob")
            token = monitor_command(folder, "token", "add", "script", "--role", "viewer").stdout.strip()
            self.assertEqual(len(token), 43)
            listed = monitor_command(folder, "user", "list").stdout
            self.assertIn("operator       ada", listed)
            self.assertIn("script (token)", listed)
            with open("/dev/full", "w") as full:
                words = [MONITOR, "token", "add", "lost", "--role", "viewer", "--state", folder / "state"]
                self.assertEqual(subprocess.run(words, stdout=full, stderr=full, check=False).returncode, 4)
            self.assertNotIn("lost", monitor_command(folder, "user", "list").stdout)
            (folder / "runs").mkdir()
            monitor = Monitor(folder, runs=folder / "runs")
            self.assertEqual(monitor.ask("/api/v1/runs").status, 401)
            self.assertEqual(monitor.ask("/api/v1/runs", None, {"Authorization": "Bearer " + token}).status, 200)
            ada = Browser(monitor, "ada")
            self.assertEqual(monitor_command(folder, "user", "remove", "ada").returncode, 0)
            self.assertEqual(ada.ask("/api/v1/runs").status, 401)
            tries = [
                monitor.ask(
                    "/api/v1/login", {"name": "ada", "password": "wrong wrong"}, {"Sec-Fetch-Site": "same-origin"}
                ).status
                for _ in range(12)
            ]
            self.assertIn(429, tries)
            self.assertNotIn(200, tries)
            self.assertEqual(monitor.stop(), 0)

    def test_it_ends_whenever_it_is_asked_to(self) -> None:
        with Folder() as folder:
            for i in range(24):
                options = ["--folder", str(folder), "--listen", "127.0.0.1:0", "--state", str(folder / "state")]
                starting = subprocess.Popen([MONITOR, *options], stdout=subprocess.DEVNULL)
                time.sleep(0.004 * i)
                starting.terminate()
                try:
                    self.assertIn(starting.wait(timeout=60), (0, -signal.SIGTERM), i)
                finally:
                    starting.kill()

    def test_a_store_that_does_not_answer_costs_one_thread_and_once(self) -> None:
        with Folder() as folder:
            (folder / "runs").mkdir()
            program, store = folder / "gyrotherm-monitor", folder / "gyrotherm-site"
            shutil.copy(MONITOR, program)
            end = folder / "end"
            wait = f"while [ ! -e {end} ]; do sleep 0.05; done"
            store.write_text(f"#!/bin/sh\necho asked >> {folder}/asked\n{wait}\necho no answer\nexit 4\n")
            store.chmod(0o755)
            (folder / "site.toml").write_text(
                'schema = "gyrotherm-site/1"\nname = "s"\nrig = "r"\n'
                f'folders = ["{folder}/runs"]\n[store]\naddress = "host=127.0.0.1 dbname=g"\n'
            )
            monitor = Monitor(folder, "--site", str(folder / "site.toml"), runs=folder / "runs", program=str(program))
            answers = []
            ask = lambda: answers.append(monitor.ask("/api/v1/site/rigs"))
            asking = [threading.Thread(target=ask) for _ in range(40)]
            for one in asking:
                one.start()
                time.sleep(0.02)
            self.assertEqual(monitor.ask("/api/v1/session").status, 200)
            self.assertTrue(until(lambda: len(answers) == 39, 15), "all but who asked, while the store is being asked")
            end.touch()
            for one in asking:
                one.join()
            self.assertEqual({answer.status for answer in answers}, {503})
            self.assertEqual([answer.json.get("asking", False) for answer in answers], [True] * 39 + [False])
            self.assertIn("no answer", monitor.ask("/api/v1/site/rigs").json["error"])
            self.assertEqual((folder / "asked").read_text().count("asked"), 1, "that it did not answer is kept")
            self.assertEqual(monitor.stop(), 0)

    def test_the_list_of_rigs_is_asked_for_rarely_and_not_for_long(self) -> None:
        with Folder() as folder:
            (folder / "runs").mkdir()
            program, store = folder / "gyrotherm-monitor", folder / "gyrotherm-site"
            shutil.copy(MONITOR, program)
            answers = '[{"rig": "a", "age_s": 2, "state": "execute"}]'
            store.write_text(f"#!/bin/sh\necho asked >> {folder}/asked\n[ -e {folder}/hangs ] && exec sleep 60\n"
                             f"echo '{answers}'\n")
            store.chmod(0o755)
            (folder / "site.toml").write_text(
                f'schema = "gyrotherm-site/1"\nname = "s"\n[store]\naddress = "host=127.0.0.1 dbname=g"\n'
            )
            monitor = Monitor(folder, "--site", str(folder / "site.toml"), runs=folder / "runs", program=str(program))
            asked = lambda: (folder / "asked").read_text().count("asked")
            site = monitor.ask("/api/v1/site").json
            self.assertEqual((site["store"]["error"], [rig["rig"] for rig in site["rigs"]]), ("", ["a"]))
            for _ in range(50):
                monitor.ask("/api/v1/site")
            self.assertLess(asked(), 5, "of 51 looks")
            (folder / "hangs").touch()
            lost = until(lambda: (now := monitor.ask("/api/v1/site").json)["store"]["error"] and now)
            self.assertTrue(lost, "within a bound that is less than what until() waits for")
            self.assertEqual(lost["rigs"][0]["state"], "execute", "as it was")
            self.assertAlmostEqual(lost["rigs"][0]["age_s"], 2 + lost["store"]["age_s"], places=3)
            self.assertGreater(lost["store"]["age_s"], 3)
            (folder / "hangs").unlink()
            self.assertTrue(until(lambda: not monitor.ask("/api/v1/site").json["store"]["error"]))
            self.assertEqual(monitor.stop(), 0)

    def test_tls_is_spoken_where_it_was_asked_for(self) -> None:
        with Folder() as folder:
            certificate, key = folder / "page.pem", folder / "page.key"
            made = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost"]
            names = ["-addext", "subjectAltName=DNS:localhost", "-keyout", key, "-out", certificate]
            subprocess.run([*made, *names], capture_output=True, check=True)
            other = folder / "other.key"
            subprocess.run(["openssl", "ecparam", "-name", "prime256v1", "-genkey", "-noout", "-out", other], check=True)
            for wrong, why in ((other, "is not the key of the certificate"), (folder / "none", "cannot be read")):
                code, said = self.starts("--folder", str(folder), "--certificate", str(certificate), "--key", str(wrong))
                self.assertEqual((code, why in said), (4, True), said)
            monitor_command(folder, "user", "add", "ada", "--role", "viewer", password=PASSWORD)
            (folder / "runs").mkdir()
            monitor = Monitor(folder, "--certificate", str(certificate), "--key", str(key), runs=folder / "runs")
            trusted = ssl.create_default_context(cafile=str(certificate))
            line = http.client.HTTPSConnection("localhost", monitor.port, context=trusted, timeout=10)
            body = json.dumps({"name": "ada", "password": PASSWORD})
            origin = {"Origin": f"https://localhost:{monitor.port}", "Content-Type": "application/json"}
            line.request("POST", "/api/v1/login", body, origin)
            reply = line.getresponse()
            self.assertEqual(reply.status, 200, reply.read())
            self.assertIn("; Secure", reply.headers["Set-Cookie"])
            self.assertIn("HttpOnly; SameSite=Strict", reply.headers["Set-Cookie"])
            line.close()
            self.expect_a_goodbye(monitor, certificate)
            self.assertEqual(monitor.raw(b"GET / HTTP/1.1\r\nHost: localhost:%d\r\n\r\n" % monitor.port), b"")
            old = ssl.create_default_context(cafile=str(certificate))
            old.minimum_version, old.maximum_version = ssl.TLSVersion.TLSv1, ssl.TLSVersion.TLSv1_1
            with self.assertRaises((ssl.SSLError, OSError)):
                with socket.create_connection(("localhost", monitor.port), timeout=5) as plain:
                    old.wrap_socket(plain, server_hostname="localhost")
            self.assertEqual(monitor.stop(), 0)

    def expect_a_goodbye(self, monitor: Monitor, certificate: pathlib.Path) -> None:
        """A cut connection cannot make an answer seem complete: TLS marks its end."""
        trusted = ssl.create_default_context(cafile=str(certificate))
        trusted.options &= ~ssl.OP_IGNORE_UNEXPECTED_EOF
        with socket.create_connection(("localhost", monitor.port), timeout=5) as plain:
            with trusted.wrap_socket(plain, server_hostname="localhost", suppress_ragged_eofs=False) as line:
                host = b"Host: localhost:%d\r\n" % monitor.port
                line.sendall(b"GET /icon.svg HTTP/1.1\r\n" + host + b"Connection: close\r\n\r\n")
                answer = b""
                while piece := line.recv(65536):
                    answer += piece
                self.assertIn(b"</svg>", answer)

    def test_a_proxy_says_who_asks_and_how(self) -> None:
        with Folder() as folder:
            (folder / "runs").mkdir()
            options = ("--behind-proxy", "--host", "rig.example.org")
            alone = Monitor(folder, *options, runs=folder / "runs")
            host = {"Host": "rig.example.org", "X-Forwarded-For": "10.1.2.3", "X-Forwarded-Proto": "https"}
            self.assertEqual(
                alone.ask("/api/v1/runs", None, host).status, 401, "an open door is for this machine alone"
            )
            self.assertEqual(alone.stop(), 0)
            monitor_command(folder, "user", "add", "ada", "--role", "viewer", password=PASSWORD)
            monitor = Monitor(folder, *options, runs=folder / "runs")
            login = {"name": "ada", "password": PASSWORD}
            page = host | {"Origin": "https://rig.example.org"}
            self.assertEqual(monitor.ask("/api/v1/login", login, page).status, 200)
            plain = host | {"Origin": "http://rig.example.org"}
            self.assertEqual(monitor.ask("/api/v1/login", login, plain).status, 403)
            wrong = [monitor.ask("/api/v1/login", login | {"password": "wrong wrong"}, page).status for _ in range(12)]
            self.assertIn(429, wrong)
            other = page | {"X-Forwarded-For": "10.1.2.3, 10.9.9.9"}
            self.assertIn(monitor.ask("/api/v1/session", None, other).status, (200,))
            self.assertEqual(monitor.stop(), 0)

    def test_the_unit_is_understood_and_well_shut_in(self) -> None:
        text = (SOURCE / "apps/monitor/systemd/gyrotherm-monitor.service.in").read_text()
        self.assertIn("MemoryMax=64M", text)
        self.assertIn("Restart=always", text)
        if not shutil.which("systemd-analyze"):
            self.skipTest("systemd-analyze is not installed")
        with Folder() as folder:
            unit = folder / "gyrotherm-monitor.service"
            unit.write_text(
                text.replace("@GYROTHERM_BIN@/gyrotherm-monitor", "/bin/true").replace("@GYROTHERM_DOCS@", "/")
            )
            said = subprocess.run(["systemd-analyze", "verify", "--man=no", unit], capture_output=True, text=True, check=False)
            self.assertNotIn("gyrotherm-monitor.service:", said.stdout + said.stderr)
            judged = subprocess.run(
                ["systemd-analyze", "security", "--offline=true", "--threshold=25", "--no-pager", unit],
                capture_output=True,
                text=True,
                check=False,
            )
            self.assertEqual(judged.returncode, 0, judged.stdout[-300:])


if __name__ == "__main__":
    unittest.main(verbosity=1)
