// SPDX-License-Identifier: Apache-2.0
/// A monitor as it was asked for on its command line.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::monitor {

struct MonitorOptions {
  std::vector<std::string> folders{};
  std::string site_file{};                ///< who is told of what; empty: nobody
  std::string listen = "127.0.0.1:8321";  ///< ADDRESS:PORT; port 0: any
  std::vector<std::string> hosts{};       ///< further names of the page
  std::string state_folder{};             ///< users, sessions, what was told
  bool control{};
  bool behind_proxy{};
  std::string certificate{}, key{};
};

/// Serves until SIGINT or SIGTERM; `say` gets the address of the page once, `complain` each person who cannot be
/// notified, from a thread of its own. Fails with usage where the options cannot be: a folder that is none;
/// another address than the machine's own without users, or without TLS; a port that another program has; with bad_file
/// where a file of its own is wrong.
[[nodiscard]] Result<void> serve(const MonitorOptions& options, const std::function<void(const std::string&)>& say,
                                 const std::function<void(const Fault&)>& complain);

}  // namespace gyrotherm::monitor
