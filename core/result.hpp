// SPDX-License-Identifier: Apache-2.0
/// Error handling. A function that can fail for reasons outside the program returns a Result with a Fault; this is the
/// only way to report an operating error. Long computations report progress to a ProgressSink and stop when it returns
/// false.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

namespace gyrotherm {

enum class FaultKind {
  /// An instrument did not answer in time.
  timeout,
  /// The connection was lost or could not be opened.
  disconnected,
  /// An instrument or the operating system refused a request.
  refused,
  /// The data failed their checksum or format check.
  corrupted,
  /// The instrument marks the value as invalid, or the value is impossible.
  out_of_range,
  /// The value read back differs from the value written.
  mismatch,
  /// A limit of the rig was exceeded, and the run was ended.
  interlock,
  /// The content of a file is wrong; `where` is file:line:column.
  bad_file,
  /// The disk or the record failed.
  storage,
  /// A computation did not converge to its tolerance.
  numeric,
  /// A person requested the stop.
  interrupted,
  /// The command line is wrong.
  usage,
};

/// Returns the text of an enumerator, or "unknown" for any other value. The array has one text for each enumerator up
/// to `Last`.
template <auto Last, std::size_t N>
[[nodiscard]] constexpr const char* enumerator_text(const char* const (&texts)[N], decltype(Last) value) {
  static_assert(N == static_cast<std::size_t>(Last) + 1);
  const auto index = static_cast<std::size_t>(value);
  return index < N ? texts[index] : "unknown";
}

/// Returns the kind as the record and JSON spell it: "timeout", "bad_file", …
[[nodiscard]] constexpr const char* name(FaultKind kind) {
  return enumerator_text<FaultKind::usage>(
      {"timeout", "disconnected", "refused", "corrupted", "out_of_range", "mismatch", "interlock", "bad_file",
       "storage", "numeric", "interrupted", "usage"},
      kind);
}

struct Fault {
  FaultKind kind{};
  /// Location of the fault: "chamber read holding 2782", "profile.toml:12:3".
  std::string where;
  /// Description of the fault: "no reply in 500 ms".
  std::string what;
};

/// Returns the fault as one text: "where: what".
[[nodiscard]] inline std::string text(const Fault& fault) {
  return fault.where.empty() ? fault.what : fault.where + ": " + fault.what;
}

template <class T>
using Result = tl::expected<T, Fault>;

[[nodiscard]] inline tl::unexpected<Fault> failure(FaultKind kind, std::string where, std::string what) {
  return tl::unexpected<Fault>(Fault{kind, std::move(where), std::move(what)});
}
[[nodiscard]] inline tl::unexpected<Fault> failure(Fault fault) { return tl::unexpected<Fault>(std::move(fault)); }

/// Called repeatedly by a long computation, with the name of its stage and the completed fraction (0…1). If it returns
/// false, the computation stops cleanly and fails with FaultKind::interrupted. It may be called from any thread, but
/// never from two threads at the same time.
using ProgressSink = std::function<bool(std::string_view stage, double fraction)>;

/// Reports progress to a sink, which may be empty. Returns whether the computation is to continue.
[[nodiscard]] inline bool should_continue(const ProgressSink& sink, std::string_view stage, double fraction) {
  return !sink || sink(stage, fraction);
}

}  // namespace gyrotherm
