// SPDX-License-Identifier: Apache-2.0
/// A monitor with the options of its command line.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::monitor {

struct MonitorOptions {
  std::vector<std::string> folders{};
  /// Notification rules; empty: no notifications.
  std::string site_file{};
  /// ADDRESS:PORT; port 0 selects a free one.
  std::string listen = "127.0.0.1:8321";
  /// Further host names of the page.
  std::vector<std::string> hosts{};
  /// Folder of users, sessions and sent messages.
  std::string state_folder{};
  bool control{};
  bool behind_proxy{};
  std::string certificate{}, key{};
};

/// Serves until SIGINT or SIGTERM. Calls `report_address` once with the address of the page, and `complain` for each
/// failed notification, from a separate thread. Fails with usage if the options are invalid: a folder does not exist;
/// an address other than loopback is used without users or without TLS; another program uses the port. Fails with
/// bad_file if one of its own files is invalid.
[[nodiscard]] Result<void> serve(const MonitorOptions& options,
                                 const std::function<void(const std::string&)>& report_address,
                                 const std::function<void(const Fault&)>& report_fault);

}  // namespace gyrotherm::monitor
