# SPDX-License-Identifier: Apache-2.0
"""An instrument for tests: line_peer.py LOG ANSWER. Prints its port, writes each byte that it receives to LOG, and
replies ANSWER to each line."""

import socket
import sys

with socket.create_server(("127.0.0.1", 0)) as server, open(sys.argv[1], "ab", buffering=0) as log:
    print(server.getsockname()[1], flush=True)
    while True:
        client, _ = server.accept()
        with client:
            while received := client.recv(4096):
                log.write(received)
                client.sendall((sys.argv[2] + "\n").encode() * received.count(b"\n"))
