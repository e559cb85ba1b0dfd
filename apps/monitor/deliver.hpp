// SPDX-License-Identifier: Apache-2.0
/// Delivers messages to addresses: by a program, by mail, or by the program apprise. Each delivery may take half a
/// minute.
#pragma once

#include <string>
#include <vector>

#include "apps/monitor/site_file.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::monitor {

inline constexpr Duration kDeliveryTimeout = std::chrono::seconds(30);

struct NotificationText {
  std::string subject;
  std::string text;
};

/// Runs a program with `input` on its stdin and waits for its end. Fails with usage if it cannot be started, with
/// refused if its exit code is not 0, or with timeout if it does not end in time. In that case it is killed.
[[nodiscard]] Result<void> run_program(const std::vector<std::string>& command, const std::string& input,
                                       Duration within);

/// Returns the mail as sent: headers, protected against injection of further headers, and the text.
[[nodiscard]] std::string mail_text(const MailServer& server, const MailAddress& to,
                                    const NotificationText& notification, Duration utc);

/// Sends a mail. Fails with disconnected or refused if the server does not accept it.
[[nodiscard]] Result<void> send_mail(const MailServer& server, const MailAddress& to,
                                     const NotificationText& notification, Duration utc);

[[nodiscard]] Result<void> deliver(const Site& site, const NotifyAddress& address, const NotificationText& notification,
                                   Duration utc);

/// Returns whether another monitor answers GET /api/v1/session with status 200. This needs no login.
[[nodiscard]] bool is_monitor_responding(const std::string& url, Duration within);

}  // namespace gyrotherm::monitor
