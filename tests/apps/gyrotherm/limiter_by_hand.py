# SPDX-License-Identifier: Apache-2.0
"""Plays the person at a virtual chamber: runs a command on a terminal, sets the limiter when it is asked, and once the
chamber heats does nothing ("finish"), kills the command ("kill") or presses Ctrl-C ("interrupt"). Prints the output and
returns the exit code of the command, or 137 after a kill."""
import os
import pty
import re
import signal
import socket
import struct
import sys

mode, port, command = sys.argv[1], int(sys.argv[2]), sys.argv[3:]


def write(address, words):
    body = struct.pack(">BHHB", 16, address, len(words), 2 * len(words)) + b"".join(struct.pack(">H", w) for w in words)
    if len(words) == 1:
        body = struct.pack(">BHH", 6, address, words[0])
    with socket.create_connection(("127.0.0.1", port), 5) as line:
        line.sendall(struct.pack(">HHHB", 1, 0, len(body) + 1, 1) + body)
        line.recv(64)


def set_limiter(celsius):
    write(108, struct.unpack(">HH", struct.pack(">f", celsius)))


child, terminal = pty.fork()
if child == 0:
    os.execv(command[0], command)
seen = ""
done = set()


def once(text):
    if text in seen and text not in done:
        done.add(text)
        return True
    return False


while True:
    try:
        piece = os.read(terminal, 4096)
    except OSError:
        break
    if not piece:
        break
    seen += piece.decode("utf-8", "replace")
    asked = re.search(r"limiter of the chamber to (-?\d+) ", seen)
    if asked and once(asked[0]):
        set_limiter(int(asked[1]))
        os.write(terminal, b"\n")
    if once("Set the limiter back"):
        set_limiter(80)
        write(110, [1])
        os.write(terminal, b"\n")
    if mode == "kill" and once("set point sent"):
        os.kill(child, signal.SIGKILL)
    if mode == "interrupt" and once("set point sent"):
        os.write(terminal, b"\x03")
print(seen)
status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
sys.exit(status if status >= 0 else 128 - status)
