// SPDX-License-Identifier: Apache-2.0
/// Serves instruments that answer requests, on one thread for all their sockets.
#pragma once

#include <cstddef>
#include <mutex>
#include <thread>
#include <unordered_map>
#include <vector>

#include "simulator/servers/session.hpp"

namespace gyrotherm::simulator {

/// A server for any number of instruments. A pseudo-terminal is a line with one permanent client. Each listener accepts
/// at most kMaxClients at the same time and closes further connections immediately. A client that closes, violates its
/// protocol or does not accept its replies is dropped.
class ReplyServer {
 public:
  static constexpr std::size_t kMaxClients = 16;

  /// Creates a server. Sessions are made and fed while `laboratory_guard` is held.
  explicit ReplyServer(std::mutex& laboratory_guard);
  /// Ends the thread, then every connection.
  ~ReplyServer();
  ReplyServer(const ReplyServer&) = delete;
  ReplyServer& operator=(const ReplyServer&) = delete;

  /// Adds an instrument. Call before start().
  void add(Descriptor listener, MakeSession make_session);
  void add(Pty line, MakeSession make_session);
  /// Starts the thread of the server.
  void start();

 private:
  struct Listener {
    Descriptor socket;
    MakeSession make_session;
    std::size_t clients{};
  };
  struct Client {
    Descriptor socket;
    std::unique_ptr<Session> session;
    Listener& listener;
  };
  struct Line {
    Pty pty;
    MakeSession make_session;
    /// Made with the first bytes.
    std::unique_ptr<Session> session;
  };

  void run();
  /// Waits for clients and serves them. Returns false when the server ends.
  [[nodiscard]] bool serve_once();
  void watch(int descriptor);
  void admit(Listener& listener);
  void serve(int descriptor);
  [[nodiscard]] bool exchange(Client& client);
  void exchange(Line& line);

  std::mutex& laboratory_guard_;
  Descriptor poll_;
  Descriptor stop_;
  std::unordered_map<int, Listener> listeners_;
  std::unordered_map<int, Client> clients_;
  /// Keyed by the descriptor of our end.
  std::unordered_map<int, Line> lines_;
  std::vector<std::byte> incoming_;
  std::vector<std::byte> reply_;
  std::thread thread_;
};

}  // namespace gyrotherm::simulator
