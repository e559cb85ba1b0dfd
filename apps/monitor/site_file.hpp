// SPDX-License-Identifier: Apache-2.0
/// The part of a site file that the monitor reads: notification rules and addresses (docs/monitor.md).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::monitor {

inline constexpr const char* kSiteSchema = "gyrotherm-site/1";

/// A program that receives the text on stdin and the subject as its last argument.
struct CommandAddress {
  std::vector<std::string> command;
};
struct MailAddress {
  std::vector<std::string> to;
};
/// A service that the program apprise supports.
struct AppriseAddress {
  std::string url;
};
struct NotifyAddress {
  std::string name;
  std::variant<CommandAddress, MailAddress, AppriseAddress> method;
};

/// A server for outgoing mail.
struct MailServer {
  std::string url;
  std::string from;
  /// Empty: no login.
  std::string user;
  /// Content of the password file.
  std::string password;
  bool requires_tls = true;
};

/// Event for which a rule sends notifications.
enum class RuleTrigger {
  /// An alarm is raised. Until it is acknowledged, one address after another is notified.
  alarm,
  /// A run ends.
  ended,
  /// The disk of an active run has less free space than `free_bytes`.
  disk_low,
  /// The program of a run, or another monitor, has not answered for `after`.
  silent,
};

struct NotifyRule {
  std::string name{};
  RuleTrigger trigger{};
  /// Names of addresses, in order.
  std::vector<std::string> addresses{};
  /// For `alarm`: time from one address to the next. For `silent`: time before the first notification.
  Duration after{};
  std::uint64_t free_bytes{};
  /// For `silent`: URL of another monitor, or empty for the runs of this monitor.
  std::string monitor{};
  /// The rule also applies to runs on virtual rigs.
  bool simulated{};
};

struct Site {
  std::string name{};
  std::vector<NotifyAddress> addresses{};
  std::vector<NotifyRule> rules{};
  std::optional<MailServer> mail{};
  /// The file has a [store] table. `gyrotherm-site --site FILE` queries the store.
  bool has_store{};
};

/// Reads a site file. Fails with bad_file and reports all errors with their positions.
[[nodiscard]] Result<Site> parse_site(std::string_view text, const std::string& file);
[[nodiscard]] Result<Site> read_site(const std::string& file);

}  // namespace gyrotherm::monitor
