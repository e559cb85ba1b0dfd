// SPDX-License-Identifier: Apache-2.0
/// Sessions of logged-in users, confirmations of commands, and limits on the rate of requests.
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

/// Sessions of logged-in users. A session is identified by the SHA-256 of a random secret in the browser's cookie. The
/// list is stored in a file (mode 0600), so sessions survive a restart of the monitor. Usable from any thread.
class Sessions {
 public:
  struct Session {
    /// SHA-256 of the secret.
    std::string id;
    std::string user;
    /// Identity::password_id of the user when the session began.
    std::string password_id;
    /// A second secret that the page must send with each change.
    std::string csrf;
    Duration begun{}, used{};
  };
  static constexpr Duration kLongest = std::chrono::hours(7 * 24), kIdleLifetime = std::chrono::hours(12);
  /// Limit of sessions. If it is exceeded, the least recently used session ends.
  static constexpr std::size_t kMost = 256;

  /// Creates the list. If `path` is empty it is kept in memory only.
  Sessions(std::string path, const Clock& clock) : path_(std::move(path)), clock_(clock) {}

  /// Loads the list. Fails with bad_file.
  [[nodiscard]] Result<void> load();
  /// Opens a session. Returns the secret for the cookie.
  [[nodiscard]] std::string open(const std::string& user, const std::string& password_id);
  [[nodiscard]] std::optional<Session> find(const std::string& secret);
  void close(const std::string& id);
  void close_all_for_user(const std::string& user);
  [[nodiscard]] std::vector<Session> all();

 private:
  void remove_expired();
  void save() const;

  std::string path_;
  const Clock& clock_;
  std::mutex mutex_;
  std::map<std::string, Session> sessions_;
};

/// Confirmations of commands: a token that is valid once, for 30 s. Usable from any thread.
class Confirmations {
 public:
  static constexpr Duration kWithin = std::chrono::seconds(30);
  explicit Confirmations(const Clock& clock) : clock_(clock) {}

  /// Returns a token for this user, run and command.
  [[nodiscard]] std::string issue(const std::string& user, const std::string& run, const std::string& verb);
  /// Returns whether the token is valid, and invalidates it.
  [[nodiscard]] bool take(const std::string& token, const std::string& user, const std::string& run,
                          const std::string& verb);

 private:
  struct Pending {
    std::string what;
    Duration at{};
  };
  const Clock& clock_;
  std::mutex mutex_;
  std::map<std::string, Pending> pending_;
};

/// Limits the rate of attempts per name (of an address or a user): a burst of `most` attempts, then `per_second`
/// attempts per second. Usable from any thread.
class RateLimit {
 public:
  RateLimit(double most, double per_second, const Clock& clock) : most_(most), per_second_(per_second), clock_(clock) {}

  /// Uses up one attempt. Returns false if none remains.
  [[nodiscard]] bool take(const std::string& name);

 private:
  struct Allowance {
    double tries{};
    Duration at{};
  };
  static constexpr std::size_t kMaxNames = 4096;
  double most_, per_second_;
  const Clock& clock_;
  std::mutex mutex_;
  std::map<std::string, Allowance> allowances_;
};

}  // namespace gyrotherm::monitor
