// SPDX-License-Identifier: Apache-2.0
/// The socket next to a record. Other programs on this machine use it to send requests to the program that executes the
/// run. Each request is one message, and so is its answer.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/result.hpp"
#include "sequencer/control/control_message.hpp"

namespace gyrotherm::control {

/// Returns the socket's path: "RUN.db" → "RUN.db.socket".
[[nodiscard]] std::string control_socket_path(const std::string& record);

/// Carries out one request. `user` is the client's user as the kernel reports it, such as "ada (uid 1000)". If the
/// client acts for one of its own users, it contains both, such as "anna (through ada, uid 1000)".
using Listener = std::function<ControlAnswer(const ControlRequest&, const std::string& user)>;

/// The listening end. Every user with write permission may connect: mode 0660, or 0600 if the umask excludes the group.
/// The kernel reports the client's user.
class ControlSocket {
 public:
  /// Opens the socket. Replaces the socket that a crashed program left behind. Fails with storage.
  [[nodiscard]] static Result<ControlSocket> open(const std::string& record);
  ~ControlSocket();
  ControlSocket(ControlSocket&&) noexcept = default;
  ControlSocket& operator=(ControlSocket&&) = delete;

  /// Answers one message of each waiting client and returns immediately. If more than eight clients wait, drops the
  /// oldest one that has sent nothing. Call it when descriptor() is readable, and also at intervals.
  void listen(const Listener& listener);
  [[nodiscard]] int descriptor() const { return socket_.number(); }

 private:
  ControlSocket(Descriptor socket, std::string path) : socket_(std::move(socket)), path_(std::move(path)) {}

  /// Accepts the next client, even if the process has no free descriptor.
  [[nodiscard]] Descriptor accept();

  Descriptor socket_;
  /// Spare descriptor, which is closed to accept a client when no other descriptor is left.
  Descriptor spare_;
  std::string path_;
  std::vector<Descriptor> clients_;
};

/// Sends a request to the program that carries out the run of `record`, and waits at most `within` for its answer.
/// Sends nothing unless the listening process (SO_PEERCRED) is the one that RUN.db.status names, and its user owns that
/// file and is this user, root, or the owner of the record or its folder. Fails with usage if no program listens there,
/// bad_file if the record does not exist either, refused if this user has no permission or another process listens,
/// timeout, disconnected or corrupted.
[[nodiscard]] Result<ControlAnswer> send_request(const std::string& record, const ControlRequest& request,
                                                 Duration within);

}  // namespace gyrotherm::control
