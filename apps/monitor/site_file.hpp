// SPDX-License-Identifier: Apache-2.0
/// A site file: who is told of what, and how (docs/monitor.md).
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

/// A program that is given the text on stdin, and the subject as its last argument.
struct CommandAddress {
  std::vector<std::string> command;
};
struct MailAddress {
  std::vector<std::string> to;
};
/// Any other service, by the program apprise.
struct AppriseAddress {
  std::string url;
};
struct NotifyAddress {
  std::string name;
  std::variant<CommandAddress, MailAddress, AppriseAddress> how;
};

/// The server that takes mail.
struct MailServer {
  std::string url;  ///< "smtp://mail.example.org:587", "smtps://…"
  std::string from;
  std::string user;      ///< empty: nobody logs in
  std::string password;  ///< from the file that the site file names
  bool must_be_secure = true;
};

/// What a rule watches for.
enum class Occasion {
  alarm,     ///< one is raised; and as long as nobody acknowledges it the next address is told
  ended,     ///< a run has ended
  disk_low,  ///< where a run is recorded there is less space than `free_bytes`
  silent,    ///< the program that carries a run out, or another monitor, has not answered for `after`
};

struct NotifyRule {
  std::string name{};
  Occasion when{};
  std::vector<std::string> tell{};  ///< names of addresses, in order
  Duration after{};                 ///< alarm: before the next address is told; silent: before the first is
  std::uint64_t free_bytes{};
  std::string monitor{};  ///< silent: the URL of another monitor; empty: the runs of this one
  bool simulated{};       ///< runs on virtual rigs too
};

struct Site {
  std::string name{};
  std::vector<NotifyAddress> addresses{};
  std::vector<NotifyRule> rules{};
  std::optional<MailServer> mail{};
  bool has_store{};  ///< which `gyrotherm-site --site FILE` asks
};

/// Fails with bad_file, all mistakes with their places.
[[nodiscard]] Result<Site> parse_site(std::string_view text, const std::string& file);
[[nodiscard]] Result<Site> read_site(const std::string& file);

}  // namespace gyrotherm::monitor
