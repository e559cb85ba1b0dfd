// SPDX-License-Identifier: Apache-2.0
/// Runs a monitor.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::monitor {

struct MonitorOptions {
  std::vector<std::string> folders{};
  /// Path of the site file; empty: no notifications and no site.
  std::string site_file{};
  /// ADDRESS:PORT; port 0 selects a free one.
  std::string listen = "127.0.0.1:8321";
  /// Host names of the page in addition to the address.
  std::vector<std::string> hosts{};
  /// Folder of users, sessions and the memory of notifications; empty: the default (resolve_state_folder()).
  std::string state_folder{};
  bool control{};
  bool behind_proxy{};
  std::string certificate{}, key{};
};

/// Serves the page until SIGINT or SIGTERM. Calls `report_address` once with the address of the page, and
/// `report_fault` for each failed notification, from a separate thread. Fails with usage if a folder does not exist, if
/// another address than loopback is used without users or TLS, or if the port is in use. Fails with bad_file if a file
/// of the monitor is invalid.
[[nodiscard]] Result<void> serve(const MonitorOptions& options,
                                 const std::function<void(const std::string&)>& report_address,
                                 const std::function<void(const Fault&)>& report_fault);

}  // namespace gyrotherm::monitor
