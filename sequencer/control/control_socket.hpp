// SPDX-License-Identifier: Apache-2.0
/// The socket beside a record by which other programs of this machine speak to the one that carries the run out: one
/// message each way.
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

/// "RUN.db" → "RUN.db.socket".
[[nodiscard]] std::string control_socket_path(const std::string& record);

/// Carries one out, told by `who`: as the kernel says, "ada (uid 1000)"; of one who speaks for a user of their own,
/// both: "anna (through ada, uid 1000)".
using Listener = std::function<ControlAnswer(const ControlRequest&, const std::string& who)>;

/// The listening end. Everyone who may write to the socket may speak: mode 0660, or 0600 if the umask excludes the
/// group. The kernel reports the speaker.
class ControlSocket {
 public:
  /// A socket that a dead program left is replaced. Fails with storage.
  [[nodiscard]] static Result<ControlSocket> open(const std::string& record);
  ~ControlSocket();
  ControlSocket(ControlSocket&&) noexcept = default;
  ControlSocket& operator=(ControlSocket&&) = delete;

  /// Hears who is there now, one message and one answer each, and never waits. Whoever connects and says nothing is
  /// shut out as soon as eight wait. Call it when descriptor() is readable, and now and then.
  void listen(const Listener& listener);
  [[nodiscard]] int descriptor() const { return socket_.number(); }

 private:
  ControlSocket(Descriptor socket, std::string path) : socket_(std::move(socket)), path_(std::move(path)) {}

  /// Accepts the next speaker, also if the process has used up its descriptors.
  [[nodiscard]] Descriptor accept();

  Descriptor socket_;
  Descriptor spare_;  ///< given up for a speaker
  std::string path_;
  std::vector<Descriptor> speakers_;
};

/// Sends a request to the program that carries the run of `record` out, and waits at most `within` for its answer.
/// Nothing is sent unless the process that listens (SO_PEERCRED) is the one that RUN.db.status names, and its user owns
/// that file and is this user, root, or the owner of the record or its folder. Fails with usage if no program listens
/// there, refused if this user may not speak to it or another process listens, timeout or corrupted.
[[nodiscard]] Result<ControlAnswer> tell(const std::string& record, const ControlRequest& request, Duration within);

}  // namespace gyrotherm::control
