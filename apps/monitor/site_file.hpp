// SPDX-License-Identifier: Apache-2.0
/// A site file: notification rules and addresses (docs/monitor.md).
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
/// Any other service, through the program apprise.
struct AppriseAddress {
  std::string url;
};
struct NotifyAddress {
  std::string name;
  std::variant<CommandAddress, MailAddress, AppriseAddress> how;
};

/// A server for outgoing mail.
struct MailServer {
  std::string url;
  std::string from;
  /// Empty: no login.
  std::string user;
  /// Read from the file that the site file names.
  std::string password;
  bool requires_tls = true;
};

/// Event that a rule watches.
enum class RuleTrigger {
  /// An alarm is raised. While it is not acknowledged, further addresses are notified.
  alarm,
  ended,
  /// The disk of a run has less free space than `free_bytes`.
  disk_low,
  /// The program of a run, or another monitor, has not answered for `after`.
  silent,
};

struct NotifyRule {
  std::string name{};
  RuleTrigger when{};
  /// Names of addresses, in order.
  std::vector<std::string> addresses{};
  /// For an alarm: time between addresses. For a silent run or monitor: time before the first message.
  Duration after{};
  std::uint64_t free_bytes{};
  /// For `silent`: URL of another monitor, or empty for the runs of this monitor.
  std::string monitor{};
  /// Includes runs on virtual rigs.
  bool simulated{};
};

struct Site {
  std::string name{};
  std::vector<NotifyAddress> addresses{};
  std::vector<NotifyRule> rules{};
  std::optional<MailServer> mail{};
  /// The store is queried by `gyrotherm-site --site FILE`.
  bool has_store{};
};

/// Reads a site. Fails with bad_file and reports all errors with their positions.
[[nodiscard]] Result<Site> parse_site(std::string_view text, const std::string& file);
[[nodiscard]] Result<Site> read_site(const std::string& file);

}  // namespace gyrotherm::monitor
