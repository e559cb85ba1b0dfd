/// Positions of a tuning job, kept as text so that every solver can be asked the same questions.
#pragma once

#include <string>
#include <vector>

#include "bench/svr/judge.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// One evaluation of the job: where, and what the peer made of it.
struct TracePosition {
  double log2_c{};
  double log2_gamma{};
  double log2_epsilon{};
  double error{};    ///< five-fold mean squared error
  double seconds{};  ///< it took when the trace was made; not used in a comparison

  [[nodiscard]] PeerParameters parameters() const;
};

/// "log2 C, log2 γ, log2 ε, error, seconds" by line, in the order of evaluation; '#' begins a remark. Fails with
/// bad_file, with file:line.
[[nodiscard]] Result<std::vector<TracePosition>> load_trace(const std::string& path);
[[nodiscard]] std::string line_of(const TracePosition& position);

/// `count` positions at equal stride over the whole job, from the middle of the first stride; all if there are fewer.
[[nodiscard]] std::vector<TracePosition> spread_over(const std::vector<TracePosition>& trace, std::size_t count);

}  // namespace gyrotherm
