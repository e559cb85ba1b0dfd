// SPDX-License-Identifier: Apache-2.0
/// Serves the instruments that answer when asked: one thread over all their sockets, its own or the caller's.
#pragma once

#include <cstddef>
#include <mutex>
#include <thread>
#include <unordered_map>
#include <vector>

#include "simulator/servers/session.hpp"

namespace gyrotherm::simulator {

/// A pseudo-terminal is a line with one client who never goes. Each listener takes at most kMostClients at once; a
/// further one is closed at once. A client that closes, breaks its protocol or does not take its replies is dropped.
class ReplyServer {
 public:
  static constexpr std::size_t kMostClients = 16;

  /// Sessions are made and fed with `laboratory_guard` held.
  explicit ReplyServer(std::mutex& laboratory_guard);
  /// Ends the thread, then every connection.
  ~ReplyServer();
  ReplyServer(const ReplyServer&) = delete;
  ReplyServer& operator=(const ReplyServer&) = delete;

  /// To be called before start().
  void add(Descriptor listener, MakeSession make_session);
  void add(Pty line, MakeSession make_session);
  /// A client that is connected already, of a server that has no thread.
  void adopt(Descriptor client, const MakeSession& make_session);
  /// Serves from a thread of its own from now on.
  void start();
  /// Serves, without such a thread, what adopted clients sent until now, in the calling one.
  void attend();

 private:
  struct Listener {
    Descriptor socket;
    MakeSession make_session;
    std::size_t clients{};
  };
  struct Client {
    Descriptor socket;
    std::unique_ptr<Session> session;
    Listener* listener{};  ///< that let it in; null: it was adopted, and is served by attend() alone
  };
  struct Line {
    Pty pty;
    MakeSession make_session;
    std::unique_ptr<Session> session;  ///< made with the first bytes
  };

  void run();
  /// Waits for clients. False: the server ends.
  [[nodiscard]] bool serve_once();
  void watch(int descriptor);
  void admit(Listener& listener);
  void serve(int descriptor);
  [[nodiscard]] bool exchange(Client& client);
  void exchange(Line& line);

  std::mutex& laboratory_guard_;
  Descriptor poll_;
  Descriptor stop_;
  std::unordered_map<int, Listener> listeners_;  ///< by descriptor
  std::unordered_map<int, Client> clients_;      ///< by descriptor
  std::unordered_map<int, Line> lines_;          ///< by our descriptor
  std::vector<std::byte> incoming_;
  std::vector<std::byte> reply_;
  std::thread thread_;
};

}  // namespace gyrotherm::simulator
