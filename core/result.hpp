// SPDX-License-Identifier: Apache-2.0
/// How work ends. What the world may refuse returns a Result, and its Fault says where and what; this is the one way to
/// fail. Long work tells through a ProgressSink how far it is, and is asked through it to stop.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

namespace gyrotherm {

enum class FaultKind {
  timeout,       ///< an instrument did not answer in time
  disconnected,  ///< the line is gone or could not be opened
  refused,       ///< an instrument said no
  corrupted,     ///< bytes that fail their own check
  out_of_range,  ///< a value that its instrument marks as invalid, or that cannot be
  mismatch,      ///< what was read back is not what was written
  interlock,     ///< a limit of the rig was passed; the run was ended
  bad_file,      ///< a file's content is wrong; `where` is file:line:column
  storage,       ///< the disk or the record failed
  numeric,       ///< a computation did not reach its certificate
  interrupted,   ///< a person asked to stop
  usage,         ///< the command line is wrong
};

/// The word at the place of an enumerator; there is one for each up to `Last`, and for any other value "unknown".
template <auto Last, std::size_t N>
[[nodiscard]] constexpr const char* word_in(const char* const (&words)[N], decltype(Last) value) {
  static_assert(N == static_cast<std::size_t>(Last) + 1);
  const auto place = static_cast<std::size_t>(value);
  return place < N ? words[place] : "unknown";
}

/// The kind as the record and JSON spell it: "timeout", "bad_file", …
[[nodiscard]] constexpr const char* name(FaultKind kind) {
  return word_in<FaultKind::usage>({"timeout", "disconnected", "refused", "corrupted", "out_of_range", "mismatch",
                                    "interlock", "bad_file", "storage", "numeric", "interrupted", "usage"},
                                   kind);
}

struct Fault {
  FaultKind kind{};
  std::string where;  ///< the place: "chamber read holding 2782", "profile.toml:12:3"
  std::string what;   ///< what happened, and what was expected: "no reply in 500 ms"
};

/// The fault for people: "where: what".
[[nodiscard]] inline std::string text(const Fault& fault) {
  return fault.where.empty() ? fault.what : fault.where + ": " + fault.what;
}

template <class T>
using Result = tl::expected<T, Fault>;

[[nodiscard]] inline tl::unexpected<Fault> failure(FaultKind kind, std::string where, std::string what) {
  return tl::unexpected<Fault>(Fault{kind, std::move(where), std::move(what)});
}
[[nodiscard]] inline tl::unexpected<Fault> failure(Fault fault) { return tl::unexpected<Fault>(std::move(fault)); }

/// Work calls it now and then with the name of its stage and the fraction done (0…1). Returning false asks for a clean
/// stop, upon which the work fails with FaultKind::interrupted. It may be called from any thread, never from two at
/// once.
using ProgressSink = std::function<bool(std::string_view stage, double fraction)>;

/// Tells an optional sink where the work stands; whether the work is to go on.
[[nodiscard]] inline bool keep_going(const ProgressSink& sink, std::string_view stage, double fraction) {
  return !sink || sink(stage, fraction);
}

}  // namespace gyrotherm
