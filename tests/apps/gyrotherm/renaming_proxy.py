# SPDX-License-Identifier: Apache-2.0
"""A line to an instrument under another identity: renaming_proxy.py PORT UPSTREAM OLD NEW. Listens at PORT (0: any),
prints its port, and forwards the bytes between each client and the port UPSTREAM. Replaces OLD by NEW in the answers,
which must arrive in one piece."""

import socket
import sys
import threading


def forward(source, target, old=b"", new=b""):
    try:
        while received := source.recv(4096):
            target.sendall(received.replace(old, new) if old else received)
    except OSError:
        pass
    for end in (source, target):
        try:
            end.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass


with socket.create_server(("127.0.0.1", int(sys.argv[1]))) as server:
    print(server.getsockname()[1], flush=True)
    while True:
        client, _ = server.accept()
        upstream = socket.create_connection(("127.0.0.1", int(sys.argv[2])))
        threading.Thread(target=forward, args=(client, upstream), daemon=True).start()
        threading.Thread(target=forward, args=(upstream, client, sys.argv[3].encode(), sys.argv[4].encode()),
                         daemon=True).start()
