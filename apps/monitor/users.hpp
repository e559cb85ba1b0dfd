// SPDX-License-Identifier: Apache-2.0
/// Users of the page: names, roles, and hashes of passwords and tokens, in a file of mode 0600 that only
/// gyrotherm-monitor writes. A password is hashed with argon2id (libsodium), a token with SHA-256.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/file.hpp"
#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::monitor {

inline constexpr const char* kUsersSchema = "gyrotherm-monitor-users/1";

/// Roles. Each includes the permissions of the previous ones.
enum class Role {
  /// Views runs.
  viewer,
  /// Controls runs. The keyword in files and options is "operator".
  conductor,
  /// Views and ends sessions.
  administrator,
};
inline constexpr std::initializer_list<Role> kRoles = {Role::viewer, Role::conductor, Role::administrator};
[[nodiscard]] inline const char* name(Role role) {
  return enumerator_text<Role::administrator>({"viewer", "operator", "administrator"}, role);
}
[[nodiscard]] std::optional<Role> find_role(std::string_view keyword);

struct User {
  std::string name;
  Role role{};
  /// argon2id string.
  std::string password;
};
/// A token, with which a script identifies itself.
struct Token {
  std::string name;
  Role role{};
  /// SHA-256 of the token.
  std::string sha256;
};

/// The user or token that has sent a request.
struct Identity {
  std::string name;
  Role role{};
  /// SHA-256 of a user's stored password hash, so it changes with the password. Empty for a token.
  std::string password_id{};
};

/// Content of the users file.
struct UserList {
  std::vector<User> users;
  std::vector<Token> tokens;
};

/// Reads the file. Returns an empty list if it does not exist. Fails like read_private_file, or with bad_file if the
/// content is invalid.
[[nodiscard]] Result<UserList> read_users(const std::string& path);
/// Replaces the file atomically. Fails with storage.
[[nodiscard]] Result<void> write_users(const std::string& path, const UserList& list);

inline constexpr std::size_t kMinPasswordBytes = 10, kMaxPasswordBytes = 256;  ///< bytes

/// Adds a user, or replaces the role and password of an existing one. Fails with usage if the name is invalid or
/// belongs to a token, or if the password is too short or too long.
[[nodiscard]] Result<void> add_or_replace_user(UserList& list, const std::string& name, Role role,
                                               const std::string& password);
/// Adds a token, or replaces the token of that name. Returns the token, which cannot be recovered later. Fails with
/// usage if the name is invalid or belongs to a user.
[[nodiscard]] Result<std::string> add_or_replace_token(UserList& list, const std::string& name, Role role);
/// Removes the user or token of a name. Fails with usage if there is none.
[[nodiscard]] Result<void> remove_user_or_token(UserList& list, const std::string& name);

/// Returns 256 random bits as 43 characters of URL-safe base 64.
[[nodiscard]] std::string random_secret();
/// Compares in constant time, so the duration does not reveal the position of the first difference.
[[nodiscard]] bool equal_secrets(std::string_view a, std::string_view b);

/// The users of a running monitor. Reads the file again when it has changed. Usable from any thread.
class Users {
 public:
  explicit Users(std::string path) : path_(std::move(path)) {}

  /// Loads the users. Fails like read_users().
  [[nodiscard]] Result<void> load();
  /// Returns whether there is a user or a token. Also returns true if the file cannot be read.
  [[nodiscard]] bool has_any();
  /// Finds a user by name and password. Takes about 0.1 s and 12 MB, even for an unknown name. Concurrent calls wait
  /// for each other.
  [[nodiscard]] std::optional<Identity> find_by_password(const std::string& name, const std::string& password);
  [[nodiscard]] std::optional<Identity> find_by_token(std::string_view token);
  /// Finds a user by name. Returns the present role.
  [[nodiscard]] std::optional<Identity> find_by_name(const std::string& name);

 private:
  void refresh();

  std::string path_;
  std::mutex mutex_, hashing_mutex_;
  UserList list_;
  /// The file exists but cannot be read.
  bool is_unreadable_{};
  /// State of the file when it was read.
  FileState file_state_;
};

}  // namespace gyrotherm::monitor
