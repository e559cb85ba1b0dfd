/// Our solver as the benchmark asks it: through the public face of analysis/ alone.
#pragma once

#include <span>

#include "analysis/svm/tuning.hpp"
#include "bench/svr/judge.hpp"
#include "bench/svr/libsvm_peer.hpp"
#include "bench/svr/trace.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// The asked and, for a reference, the far tighter relative duality gap.
inline constexpr double kGap = 1e-3;
inline constexpr double kReferenceGap = 1e-6;

/// One position as our tuning job evaluates it, without abort. The seconds are those of the second of two evaluations
/// by a job of two particles in a box 1e-9 wide, so that what a job prepares once is not counted at each position.
/// Fails as tune_svr does; with numeric if a training misses its certificate.
[[nodiscard]] Result<Evaluated> cross_validate_own(std::span<const TuningFold> folds, const TracePosition& position);

/// The error of solutions whose relative gap is at most kReferenceGap by the judge, predicted by a plain loop. Fails
/// with numeric if a fold's solution is not that good.
[[nodiscard]] Result<double> reference_error(std::span<const TuningFold> folds, const PeerParameters& parameters);

/// The tuning options of the whole job: 20 particles, 30 iterations and no early end, hence 620 evaluations, in the
/// peer's box.
[[nodiscard]] TuningOptions whole_job(int threads);

}  // namespace gyrotherm
