// SPDX-License-Identifier: Apache-2.0
/// Who may come in: whether a request comes from the page itself, from whom, and what they may do. Everything that is
/// not known to be allowed is refused here, before anything is read or told.
#pragma once

#include <optional>
#include <string>
#include <variant>

#include "apps/monitor/sessions.hpp"
#include "apps/monitor/users.hpp"
#include "apps/monitor/web.hpp"
#include "core/clock.hpp"

namespace gyrotherm::monitor {

struct DoorOptions {
  bool control{};  ///< runs may be spoken to from the page at all
  bool open{};     ///< there are no users, and whoever reaches this machine's own address may look
};

/// A guest whom a request comes from.
struct Guest {
  std::optional<Identity> identity{};          ///< nobody: a guest of an open door, who only looks
  std::optional<Sessions::Session> session{};  ///< of a browser; a script has none
  [[nodiscard]] std::string name() const { return identity ? identity->name : std::string(); }
  [[nodiscard]] bool may(Role role) const { return identity && identity->role >= role; }
};

/// Any thread.
class Door {
 public:
  Door(const DoorOptions& options, Users& users, Sessions& sessions, const Clock& clock);

  /// What speaks against a request whoever it is from: too many from its address, or another site's.
  [[nodiscard]] std::optional<WebAnswer> objection(const WebRequest& request);
  /// Whom it is from, or why nobody may come in: a session's cookie, or a bearer's token in the header.
  [[nodiscard]] std::variant<Guest, WebAnswer> guest_of(const WebRequest& request);
  /// Why this guest may not change anything with this request: no control here, the role, or the session's second
  /// secret that is not with it.
  [[nodiscard]] std::optional<WebAnswer> objection_to_change(const Guest& guest, const WebRequest& request,
                                                             Role role) const;

  /// POST /api/v1/login {"name", "password"}; /api/v1/logout; GET /api/v1/session: who one is, and what one may.
  [[nodiscard]] WebAnswer log_in(const WebRequest& request);
  [[nodiscard]] WebAnswer log_out(const WebRequest& request);
  [[nodiscard]] WebAnswer session(const WebRequest& request);
  /// GET and POST /api/v1/sessions, for administrators: who is logged in; {"user"}: their sessions end.
  [[nodiscard]] WebAnswer sessions(const WebRequest& request);

  [[nodiscard]] const DoorOptions& options() const { return options_; }

 private:
  /// Whose session it is; nobody, and it ends, if that name was removed or has another password since it began.
  [[nodiscard]] std::optional<Identity> user_of(const Sessions::Session& session);

  DoorOptions options_;
  Users& users_;
  Sessions& sessions_;
  RateLimit requests_, logins_, names_;
};

}  // namespace gyrotherm::monitor
