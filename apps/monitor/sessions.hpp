// SPDX-License-Identifier: Apache-2.0
/// Sessions of logged-in users, confirmation tokens for commands, and rate limits.
#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "core/result.hpp"

namespace gyrotherm::monitor {

/// Sessions of logged-in users. The browser's cookie contains a random secret; its SHA-256 identifies the session. The
/// list is stored in a file (mode 0600), so sessions survive a restart of the monitor. Usable from any thread.
class Sessions {
 public:
  struct Session {
    /// SHA-256 of the secret.
    std::string id;
    std::string user;
    /// Identity::password_id of the user when the session began.
    std::string password_id;
    /// A second secret, which the page must send with each request that changes something.
    std::string csrf;
    /// Start and last recorded use, UTC.
    Duration begun{}, used{};
  };
  static constexpr Duration kLifetime = std::chrono::hours(7 * 24), kIdleLifetime = std::chrono::hours(12);
  /// If a user would have more sessions, or all users together, the least recently used one ends. The limit for a user
  /// prevents that repeated logins of one user end the sessions of others.
  static constexpr std::size_t kMaxPerUser = 16, kMaxSessions = 256;

  /// Creates an empty list. If `path` is empty, the list is never stored.
  Sessions(std::string path, const Clock& clock) : path_(std::move(path)), clock_(clock) {}

  /// Loads the list from its file, if that exists. Fails with bad_file.
  [[nodiscard]] Result<void> load();
  /// Opens a session. Returns the secret for the cookie. If the list cannot be stored, the session ends with the
  /// monitor.
  [[nodiscard]] std::string open(const std::string& user, const std::string& password_id);
  /// Returns the unexpired session of a cookie's secret, and records its use.
  [[nodiscard]] std::optional<Session> find(const std::string& secret);
  /// End a session, or all sessions of a user. Fail with storage if the list cannot be stored: the sessions have ended,
  /// but a restart of the monitor would revive them. The next calls of find() try to store the list again.
  [[nodiscard]] Result<void> close(const std::string& id);
  [[nodiscard]] Result<void> close_all_for_user(const std::string& user);
  /// Stores the list if that failed before. Fails with storage.
  [[nodiscard]] Result<void> store_again();
  [[nodiscard]] std::vector<Session> all();

 private:
  void remove_expired();
  [[nodiscard]] Result<void> save();

  std::string path_;
  const Clock& clock_;
  std::mutex mutex_;
  std::map<std::string, Session> sessions_;
  /// The last attempt to store the list succeeded.
  bool is_stored_ = true;
  /// Time of the last attempt, since the start.
  Duration tried_at_{};
};

/// Confirmation tokens for commands. A token is valid once, for 30 s. A user has at most one token for a command to a
/// run and at most kMaxPerUser tokens, so no user can invalidate the tokens of another. Usable from any thread.
class Confirmations {
 public:
  static constexpr Duration kLifetime = std::chrono::seconds(30);
  static constexpr std::size_t kMaxPerUser = 16;
  explicit Confirmations(const Clock& clock) : clock_(clock) {}

  /// Creates a token for a user, a run and a command. Invalidates the earlier token for them, and the oldest token of
  /// the user if there would be too many.
  [[nodiscard]] std::string issue_token(const std::string& user, const std::string& run, const std::string& verb);
  /// Invalidates the token. Returns whether it was valid for this user, run and command.
  [[nodiscard]] bool redeem(const std::string& token, const std::string& user, const std::string& run,
                            const std::string& verb);

 private:
  struct Pending {
    std::string user;
    /// User, run and command.
    std::string subject;
    Duration issued_at{};
  };
  const Clock& clock_;
  std::mutex mutex_;
  std::map<std::string, Pending> pending_;
};

/// Returns the name of a client's network for a rate limit. One client can use all addresses of an IPv6 network of 64
/// bits, so the name is that network: "2001:db8:1:2::/64". For an IPv4 address, also in the form "::ffff:192.0.2.1", it
/// is the address. Ignores brackets and a port, which some proxies add. Returns other texts unchanged.
[[nodiscard]] std::string client_network(const std::string& address);

/// A rate limit (token bucket) for each name: a burst of `burst` attempts, then `per_second` attempts per second. A
/// name is a network or a user. Remembers kMaxNames names. A further name replaces the one with the most attempts left,
/// so a flood of names neither shuts out new ones nor resets a name that has used up its attempts. Usable from any
/// thread.
class RateLimit {
 public:
  static constexpr std::size_t kMaxNames = 4096;

  RateLimit(double burst, double per_second, const Clock& clock)
      : burst_(burst), per_second_(per_second), clock_(clock) {}

  /// Uses up one attempt of a name. Returns false if none is left.
  [[nodiscard]] bool try_acquire(const std::string& name);

 private:
  struct Allowance {
    double attempts_left{};
    Duration updated_at{};
  };
  [[nodiscard]] double attempts_left(const Allowance& allowance, Duration now) const;
  void make_room(Duration now);

  double burst_, per_second_;
  const Clock& clock_;
  std::mutex mutex_;
  std::map<std::string, Allowance> allowances_;
};

}  // namespace gyrotherm::monitor
