// SPDX-License-Identifier: Apache-2.0
/// A relay between a client and a real server, on sockets or pseudo-terminals and in real time. It makes some answers
/// lost, late, duplicated, truncated, corrupted, preceded by another answer, or split.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "core/deadline.hpp"
#include "core/file.hpp"
#include "tests/drivers/line/faults.hpp"

namespace gyrotherm::drivers {

/// Functions that depend on the framing.
struct RelayFraming {
  /// Returns the size of the reply at the start of `bytes`, as soon as it is known.
  std::function<std::optional<std::size_t>(std::span<const std::byte> request, std::span<const std::byte> bytes)> size;
  /// Corrupts a valid reply such that it must be rejected.
  std::function<void(std::vector<std::byte>& reply, Chance& chance)> falsify;
  /// Returns the reply to another request.
  std::function<std::vector<std::byte>(const std::vector<std::byte>& reply)> foreign;
};

class FaultyRelay {
 public:
  using Bytes = std::vector<std::byte>;
  using Open = std::function<Descriptor()>;  ///< closed after the test

  /// Answers are late by up to half of `timeout`, the client's timeout. One in `spoils_one_in` answers gets a fault; 0
  /// for none.
  FaultyRelay(Open client, Open server, RelayFraming framing, Duration timeout, unsigned seed,
              std::size_t spoils_one_in = 5)
      : client_(std::move(client)),
        server_(std::move(server)),
        framing_(std::move(framing)),
        timeout_(timeout),
        chance_(seed),
        spoils_one_in_(spoils_one_in),
        thread_([this] { serve(); }) {}
  ~FaultyRelay() {
    stopping_ = true;
    thread_.join();
  }
  [[nodiscard]] int faults() const { return faults_; }

 private:
  static constexpr auto kLookUpEvery = std::chrono::milliseconds(20);

  void serve() {
    while (!stopping_) {
      const auto client = client_();
      if (!client.is_open()) continue;
      const auto server = server_();
      while (!stopping_ && pass_on_one(client.number(), server.number())) {
      }
    }
  }

  bool pass_on_one(int client, int server) {
    if (!wait_until_ready(client, POLLIN, Deadline(kLookUpEvery))) return true;
    Bytes request(512);
    const auto size = read(client, request.data(), request.size());
    if (size <= 0) return false;
    request.resize(static_cast<std::size_t>(size));
    const Deadline asked(timeout_);
    auto reply = query(server, request);
    // Later than the faults made here.
    if (reply.empty() || asked.has_passed()) return true;
    return answer(client, std::move(reply));
  }

  Bytes query(int server, const Bytes& request) const {
    if (write(server, request.data(), request.size()) < 0) return {};
    Bytes reply;
    const Deadline patience(std::chrono::seconds(2));
    while (wait_until_ready(server, POLLIN, patience)) {
      std::array<std::byte, 512> more;
      const auto size = read(server, more.data(), more.size());
      if (size <= 0) return {};
      reply.insert(reply.end(), more.begin(), more.begin() + size);
      if (const auto whole = framing_.size(request, reply); whole && reply.size() >= *whole) return reply;
    }
    return {};
  }

  bool answer(int client, Bytes reply) {
    if (spoils_one_in_ == 0 || !chance_.one_in(spoils_one_in_)) return say(client, reply);
    ++faults_;
    switch (chance_.below(7)) {
      case 0: return true;
      case 1: pause(chance_.between(timeout_, timeout_ * 3 / 2)); return say(client, reply);
      case 2: reply.insert(reply.end(), reply.begin(), reply.end()); return say(client, reply);
      case 3: reply.resize(chance_.below(reply.size())); return say(client, reply);
      case 4: framing_.falsify(reply, chance_); return say(client, reply);
      case 5: return say(client, framing_.foreign(reply)) && say(client, reply);
      default: return in_pieces(client, reply);
    }
  }

  bool in_pieces(int client, const Bytes& reply) {
    const auto cut = static_cast<std::ptrdiff_t>(1 + chance_.below(reply.size() - 1));
    if (!say(client, Bytes(reply.begin(), reply.begin() + cut))) return false;
    pause(std::chrono::milliseconds(5));
    return say(client, Bytes(reply.begin() + cut, reply.end()));
  }

  static void pause(Duration time) { (void)wait_until_ready(kNoDescriptor, POLLIN, Deadline(time)); }
  static bool say(int client, const Bytes& bytes) {
    return bytes.empty() || write(client, bytes.data(), bytes.size()) >= 0;
  }

  Open client_, server_;
  RelayFraming framing_;
  Duration timeout_;
  Chance chance_;
  std::size_t spoils_one_in_;
  std::atomic<int> faults_ = 0;
  std::atomic<bool> stopping_ = false;
  std::thread thread_;  // last member: uses the others
};

}  // namespace gyrotherm::drivers
