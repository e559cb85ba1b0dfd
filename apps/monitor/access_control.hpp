// SPDX-License-Identifier: Apache-2.0
/// Access control: checks whether a request comes from the page itself, which user sent it, and whether the user may do
/// what it requests. A request that is not explicitly allowed is refused before any data is read.
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
  /// Operators may control runs.
  bool control{};
  /// If no users are defined, a client may view runs without a login.
  bool allows_guests{};
};

/// The sender of a request.
struct Sender {
  /// Empty for a guest, who has no login and may only view runs.
  std::optional<Identity> identity{};
  /// Session of a browser; empty for a script, which sends a token.
  std::optional<Sessions::Session> session{};
  [[nodiscard]] std::string name() const { return identity ? identity->name : std::string(); }
  [[nodiscard]] bool has_role(Role role) const { return identity && identity->role >= role; }
};

/// The access control. Usable from any thread.
class AccessControl {
 public:
  AccessControl(const AccessOptions& options, Users& users, Sessions& sessions, const Clock& clock);

  /// Returns a refusal if the address has sent too many requests, or if the request comes from another site.
  [[nodiscard]] std::optional<WebAnswer> general_refusal(const WebRequest& request);
  /// Returns the sender of a request, identified by its session cookie or bearer token, or a refusal.
  [[nodiscard]] std::variant<Sender, WebAnswer> identify_sender(const WebRequest& request);
  /// Returns a refusal if the sender may not change anything by this request: control is disabled, the sender's role is
  /// below `role`, or the second secret of the session is missing.
  [[nodiscard]] std::optional<WebAnswer> change_refusal(const Sender& sender, const WebRequest& request,
                                                        Role role) const;

  /// Answer POST /api/v1/login {"name", "password"}, POST /api/v1/logout, and GET /api/v1/session, which returns the
  /// user and the permissions. A logout whose end of the session cannot be stored is answered with 500.
  [[nodiscard]] WebAnswer log_in(const WebRequest& request);
  [[nodiscard]] WebAnswer log_out(const WebRequest& request);
  [[nodiscard]] WebAnswer answer_session(const WebRequest& request);
  /// Answers GET and POST /api/v1/sessions for administrators. A POST of {"user"} first ends the sessions of that user,
  /// and is answered with 500 if that cannot be stored. Both return the list of sessions.
  [[nodiscard]] WebAnswer answer_sessions(const WebRequest& request);

  [[nodiscard]] const AccessOptions& options() const { return options_; }

 private:
  /// Returns the user of a session, or nothing if the user was removed. If the password has changed since the session
  /// began, returns nothing and ends the session.
  [[nodiscard]] std::optional<Identity> session_user(const Sessions::Session& session);

  AccessOptions options_;
  Users& users_;
  Sessions& sessions_;
  RateLimit requests_per_address_, logins_per_address_, logins_per_name_;
};

}  // namespace gyrotherm::monitor
