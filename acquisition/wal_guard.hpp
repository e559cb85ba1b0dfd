/// Watches that the write-ahead log being written is the one on disk: a log unlinked by another program takes every
/// commit and keeps none of them, while SQLite reports success.
#pragma once

#include <string>

#include "core/result.hpp"

namespace gyrotherm {

class WalGuard {
 public:
  /// To be called after the first commit to the file at `path`: finds the descriptor by which this process holds the
  /// log, opening neither. Fails with storage if there is none.
  [[nodiscard]] static Result<WalGuard> find(const std::string& path);

  /// Compares the inode under the log's name with the one that is held. Fails with storage.
  [[nodiscard]] Result<void> check() const;

 private:
  WalGuard(std::string log, std::string held) : log_(std::move(log)), held_(std::move(held)) {}
  std::string log_;
  std::string held_;  ///< "/proc/self/fd/N"
};

}  // namespace gyrotherm
