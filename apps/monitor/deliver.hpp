// SPDX-License-Identifier: Apache-2.0
/// Delivers notifications by mail, by a command, or by the program apprise. A delivery takes at most half a minute.
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

/// Runs a program with `input` on its stdin and waits for its end. Kills it if it does not end in time. Fails with
/// usage if it cannot be started, with refused if its exit code is not 0, or with timeout.
[[nodiscard]] Result<void> run_program(const std::vector<std::string>& command, const std::string& input,
                                       Duration timeout);

/// Returns the mail as it is sent: headers and text. A subject or address cannot inject further headers.
[[nodiscard]] std::string mail_text(const MailServer& server, const MailAddress& to,
                                    const NotificationText& notification, Duration utc);

/// Sends a mail. Fails with disconnected or refused if the server does not accept it.
[[nodiscard]] Result<void> send_mail(const MailServer& server, const MailAddress& to,
                                     const NotificationText& notification, Duration utc);

/// Delivers a notification to an address. Fails like run_program() or send_mail().
[[nodiscard]] Result<void> deliver(const Site& site, const NotifyAddress& address, const NotificationText& notification,
                                   Duration utc);

/// Returns whether another monitor responds to GET /api/v1/session, which needs no login, with status 200.
[[nodiscard]] bool is_monitor_responding(const std::string& url, Duration timeout);

}  // namespace gyrotherm::monitor
