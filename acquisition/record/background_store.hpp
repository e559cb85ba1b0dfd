/// A store whose rows a worker makes durable, so that a disk that is full, slow or failing delays nobody.
#pragma once

#include <functional>
#include <memory>

#include "acquisition/record/record_writer.hpp"
#include "acquisition/record/status.hpp"
#include "acquisition/record/store.hpp"

namespace gyrotherm {

/// Keeps the rules of Store for `options.background`. Its destruction waits at most 10 s for a write under way.
[[nodiscard]] std::unique_ptr<Store> make_background_store(RecordWriter writer, RunInfo info, RunStatus status,
                                                           const StoreOptions& options);

/// The same without workers, for whoever has a time of his own; it has no status file.
struct AttendedStore {
  std::unique_ptr<Store> store;
  /// One transaction, if one is wanted or the last one failed. The store outlives it.
  std::function<void()> attend;
};
[[nodiscard]] AttendedStore make_attended_store(RecordWriter writer, RunInfo info, RunStatus status,
                                                const StoreOptions& options);

}  // namespace gyrotherm
