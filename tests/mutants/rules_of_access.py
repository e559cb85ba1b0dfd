# SPDX-License-Identifier: Apache-2.0
"""Mutants of the rules about other processes and files: which one is spoken to, believed, waited for or started."""

MUTANTS = [
    ("any process that listens is the run", "sequencer/control/control_socket.cpp",
     "if (const auto known = check_listener(*socket, record); !known) return failure(known.error());", "",
     "control_test", "ControlSocket.RefusesListenerThatStatusFileDoesNotName"),
    ("the user of a run may be anyone", "sequencer/control/control_socket.cpp",
     " && may_carry_out(found.uid, record)) return {};", ") return {};",
     "control_test", "ControlSocket.RefusesListenerOfAnotherUser"),
    ("a status file without a writer is believed", "sequencer/control/control_socket.cpp",
     "if (!expected) return failure(expected.error());", "if (!expected) return {};",
     "control_test", "ControlSocket.RefusesListenerWhenStatusFileIsUnusable"),
    ("the umask does not decide about the group", "core/file.cpp",
     "(made.st_mode & S_IRGRP) != 0 ? mode : mode & S_IRWXU", "mode",
     "core_test", "OwnFile.IsForOwnerAndGroupUnlessUmaskExcludesGroup"),
]
