/// One way to fail: what the world may refuse returns a Result, and its Fault says where and what.
#pragma once

#include <string>
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

struct Fault {
  FaultKind kind{};
  std::string where;  ///< the place: "chamber read holding 2782", "profile.toml:12:3"
  std::string what;   ///< what happened, and what was expected: "no reply in 500 ms"
};

template <class T>
using Result = tl::expected<T, Fault>;

[[nodiscard]] inline tl::unexpected<Fault> failure(FaultKind kind, std::string where, std::string what) {
  return tl::unexpected<Fault>(Fault{kind, std::move(where), std::move(what)});
}
[[nodiscard]] inline tl::unexpected<Fault> failure(Fault fault) { return tl::unexpected<Fault>(std::move(fault)); }

/// "timeout", "bad_file", … as the record and JSON spell them.
[[nodiscard]] const char* name(FaultKind kind);

/// "where: what", for people.
[[nodiscard]] std::string text(const Fault& fault);

}  // namespace gyrotherm
