// SPDX-License-Identifier: Apache-2.0
/// A connection to a PostgreSQL server, and query results. Every wait has a time limit, and ends when the program is
/// requested to stop.
///
/// Kinds of faults:
/// interrupted: a stop was requested;
/// disconnected, timeout: the server or the network is unavailable, and a new connection may succeed;
/// storage: the server cannot respond now, for example because its disk is full, it shuts down, or another transaction
///   took precedence;
/// refused: a repetition would be refused again (SQLSTATE classes 0A, 22, 23, 28, 3D, 3F, 42, P0).
///
/// Used by one thread at a time.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/file.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

struct pg_conn;
struct pg_result;

namespace gyrotherm::site {

/// The address of the store and the user. A password is read only from a file.
struct StoreAddress {
  /// For libpq: "host=db dbname=gyrotherm user=rig_1 sslmode=verify-full".
  std::string conninfo;
  /// A file in the format of libpq (host:port:database:user:password); empty: ~/.pgpass.
  std::string passfile{};
  /// True if `passfile` is a systemd credential. Its mode may grant the group access, because systemd 254 and later
  /// give it to the service by an access control list.
  bool is_credential{};
};

/// Location (`where`) of faults of the server and the connection.
inline constexpr const char* kStore = "store";

/// Fails with usage if the text is not a conninfo, or if it contains a password.
[[nodiscard]] Result<void> check_conninfo(const std::string& conninfo);

/// Time limits of the waits for the server, and the descriptor that ends a wait early.
struct WaitLimits {
  Duration connect = std::chrono::seconds(10);
  Duration answer = std::chrono::seconds(60);
  /// Descriptor that becomes readable when the program must end.
  int stop = kNoDescriptor;
};

/// The rows that a statement returned.
class QueryResult {
 public:
  explicit QueryResult(pg_result* result) : result_(result) {}
  [[nodiscard]] int rows() const;
  [[nodiscard]] int columns() const;
  [[nodiscard]] std::string name(int column) const;
  [[nodiscard]] bool null(int row, int column) const;
  [[nodiscard]] std::string_view text(int row, int column) const;  ///< empty for NULL
  /// Returns the value, or 0 for NULL or text.
  [[nodiscard]] std::int64_t integer(int row, int column) const;
  [[nodiscard]] bool boolean(int row, int column) const;
  /// Returns PostgreSQL's number (OID) of the column's type.
  [[nodiscard]] unsigned type(int column) const;

 private:
  struct Clear {
    void operator()(pg_result* result) const;
  };
  std::unique_ptr<pg_result, Clear> result_;
};

/// A parameter of a statement, as text; absent: NULL.
using Parameter = std::optional<std::string>;

class Postgres {
 public:
  /// Connects. Fails as described above, with usage if the address is invalid or contains a password, or with bad_file
  /// if the passfile does not exist, or if it is not a credential and other users may read it.
  [[nodiscard]] static Result<Postgres> connect(const StoreAddress& address, const WaitLimits& limits);

  /// Sends a statement with its parameters, $1 first, and returns its result.
  [[nodiscard]] Result<QueryResult> query(const std::string& statement, const std::vector<Parameter>& parameters = {});
  /// Sends a statement and returns before the result arrives. Call read_result() before sending the next statement.
  [[nodiscard]] Result<void> send(const std::string& statement, const std::vector<Parameter>& parameters);
  [[nodiscard]] Result<QueryResult> read_result();
  /// Executes one or more statements without parameters, as one transaction unless they contain transaction commands.
  [[nodiscard]] Result<void> execute(const std::string& statements);

  /// Returns true if the connection is lost, so a new one is required.
  [[nodiscard]] bool is_broken() const;
  /// Describes the connection: "host=db dbname=gyrotherm user=rig_1, TLSv1.3".
  [[nodiscard]] std::string describe() const;

 private:
  struct Finish {
    void operator()(pg_conn* connection) const;
  };
  Postgres(pg_conn* connection, const WaitLimits& limits) : connection_(connection), limits_(limits) {}
  [[nodiscard]] Result<void> wait_until_connected();
  [[nodiscard]] Result<void> flush();
  [[nodiscard]] Result<void> wait(short events, Duration within);
  [[nodiscard]] tl::unexpected<Fault> make_connection_fault() const;

  std::unique_ptr<pg_conn, Finish> connection_;
  WaitLimits limits_;
};

}  // namespace gyrotherm::site
