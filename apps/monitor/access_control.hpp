// SPDX-License-Identifier: Apache-2.0
/// Access control: whether a request comes from the page itself, which user sent it, and what this user may do. All
/// requests that are not explicitly allowed are refused here, before any data is read or returned.
#pragma once

#include <optional>
#include <string>
#include <variant>

#include "apps/monitor/sessions.hpp"
#include "apps/monitor/users.hpp"
#include "apps/monitor/web.hpp"
#include "core/clock.hpp"

namespace gyrotherm::monitor {

struct AccessOptions {
  /// The page may control runs.
  bool control{};
  /// Clients at this machine's own address may view runs while there are no users.
  bool open{};
};

/// The sender of a request.
struct Sender {
  /// Empty for a guest without login, who may only view runs.
  std::optional<Identity> identity{};
  /// A browser's session. Scripts have none.
  std::optional<Sessions::Session> session{};
  [[nodiscard]] std::string name() const { return identity ? identity->name : std::string(); }
  [[nodiscard]] bool has_role(Role role) const { return identity && identity->role >= role; }
};

/// The access control. Usable from any thread.
class AccessControl {
 public:
  AccessControl(const AccessOptions& options, Users& users, Sessions& sessions, const Clock& clock);

  /// Returns a refusal that applies to any sender: too many requests from the address, or a request of another site.
  [[nodiscard]] std::optional<WebAnswer> general_refusal(const WebRequest& request);
  /// Returns the sender of a request, identified by a session's cookie or a bearer token in the header, or a refusal.
  [[nodiscard]] std::variant<Sender, WebAnswer> identify_sender(const WebRequest& request);
  /// Returns a refusal if this guest may not change anything with this request: control is disabled, the role does not
  /// permit it, or the session's second secret is missing.
  [[nodiscard]] std::optional<WebAnswer> change_refusal(const Sender& sender, const WebRequest& request,
                                                        Role role) const;

  /// Answer POST /api/v1/login {"name", "password"}, POST /api/v1/logout, and GET /api/v1/session: the user and its
  /// rights.
  [[nodiscard]] WebAnswer log_in(const WebRequest& request);
  [[nodiscard]] WebAnswer log_out(const WebRequest& request);
  [[nodiscard]] WebAnswer session(const WebRequest& request);
  /// Answers GET and POST /api/v1/sessions for administrators: lists the sessions; {"user"} ends the sessions of a
  /// user.
  [[nodiscard]] WebAnswer sessions(const WebRequest& request);

  [[nodiscard]] const AccessOptions& options() const { return options_; }

 private:
  /// Returns the user of a session. Returns nothing, and ends the session, if the user was removed or has changed the
  /// password since the session began.
  [[nodiscard]] std::optional<Identity> session_user(const Sessions::Session& session);

  AccessOptions options_;
  Users& users_;
  Sessions& sessions_;
  RateLimit requests_, logins_, names_;
};

}  // namespace gyrotherm::monitor
