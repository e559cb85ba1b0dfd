// SPDX-License-Identifier: Apache-2.0
/// Serves a SEC node over TCP: one thread, few connections, each with bounds on what it may ask and on what may wait
/// for it. Whoever floods it or does not read loses his own connection, and has nothing of the page's threads.
#pragma once

#include <atomic>
#include <functional>
#include <list>
#include <string>

#include "apps/monitor/secop_node.hpp"
#include "apps/monitor/secop_run.hpp"
#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/result.hpp"

namespace gyrotherm::monitor {

inline constexpr std::size_t kMostSecopClients = 16;

/// So much at once, and so much again a second.
class Allowance {
 public:
  Allowance(double most, double per_s, Duration now) : most_(most), per_s_(per_s), left_(most), at_(now) {}
  /// Whether there is one; what went by until `now` is added.
  [[nodiscard]] bool has_one(Duration now);
  void take() { left_ -= 1; }

 private:
  double most_, per_s_, left_;
  Duration at_;
};

/// One thread serves; any may stop it.
class SecopServer {
 public:
  /// `may_look` says whether strangers may see a run now: as soon as they may not, nobody is connected. `run` and
  /// `clock` outlive this.
  SecopServer(SecopRun& run, std::function<bool()> may_look, const Clock& clock);

  /// Listens at a numeric address; the port. Fails with usage.
  [[nodiscard]] Result<int> bind(const std::string& address, int port);
  /// Serves until stop().
  void serve();
  void stop() { stopped_ = true; }

 private:
  struct Client {
    Descriptor socket;
    SecopSession session{};
    std::string in{}, out{};
    Allowance requests;
    Duration heard{};  ///< when it last asked
    Duration sent{};   ///< when it last took what waited, or nothing did
    bool knows{};      ///< it was told something of the node
    bool over{};       ///< nothing more is read; it is closed once what it asked is answered, and `out` is sent
  };
  void wait();
  void accept(Duration now);
  void make_room(Duration now);
  void read(Client& client);
  void answer(Client& client, Duration now);
  static void write(Client& client, Duration now);
  void tell();

  SecopRun& run_;
  std::function<bool()> may_look_;
  const Clock& clock_;
  Descriptor listener_;
  std::list<Client> clients_;
  Allowance newcomers_;
  Duration looked_{};
  std::atomic<bool> stopped_{false};
};

}  // namespace gyrotherm::monitor
