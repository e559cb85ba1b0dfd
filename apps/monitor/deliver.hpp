// SPDX-License-Identifier: Apache-2.0
/// How a message reaches an address: by a program, by mail, by the program apprise. Each has half a minute.
#pragma once

#include <string>
#include <vector>

#include "apps/monitor/site_file.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::monitor {

inline constexpr Duration kDeliverWithin = std::chrono::seconds(30);

struct Letter {
  std::string subject;
  std::string text;
};

/// Runs a program with `input` on its stdin and waits for its end. Fails with usage if it cannot be started, refused if
/// its exit code is not 0, timeout if it does not end: then it is ended.
[[nodiscard]] Result<void> run_program(const std::vector<std::string>& command, const std::string& input,
                                       Duration within);

/// The mail as it is sent: headers, of which none can be another than is meant, and the text.
[[nodiscard]] std::string mail_text(const MailServer& server, const MailAddress& to, const Letter& letter,
                                    Duration utc);

/// Fails with disconnected or refused where the server does not take it.
[[nodiscard]] Result<void> send_mail(const MailServer& server, const MailAddress& to, const Letter& letter,
                                     Duration utc);

[[nodiscard]] Result<void> deliver(const Site& site, const NotifyAddress& address, const Letter& letter, Duration utc);

/// Whether another monitor answers: with anything that a monitor says, also that one must log in first.
[[nodiscard]] bool monitor_answers(const std::string& url, Duration within);

}  // namespace gyrotherm::monitor
