/// The paired replay: the same positions of a stored tuning job through LIBSVM and through our solver, one after the
/// other at each position, so that both see the same state of the machine.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "bench/svr/libsvm_peer.hpp"
#include "bench/svr/sample_set.hpp"
#include "bench/svr/trace.hpp"

namespace gyrotherm {

struct ReplayedPosition {
  TracePosition position;
  Evaluated peer;
  std::optional<Evaluated> own;     ///< none if a training missed its certificate
  std::optional<double> reference;  ///< error of solutions of relative gap ≤ 1e-6, where it was asked for and reached
  [[nodiscard]] bool agrees() const;  ///< within 0.5 %, or closer to the reference than the peer
};

struct Replay {
  std::vector<ReplayedPosition> positions;
  [[nodiscard]] double peer_seconds() const;       ///< sum over all positions
  [[nodiscard]] double own_seconds() const;        ///< sum over all positions; infinite if one was not certified
  [[nodiscard]] double peer_mean_error_s() const;  ///< standard error of the peer's mean, as of independent draws
  [[nodiscard]] int disagreements() const;
};

/// Without a peer, what the trace says of it stands for it: good for looking at our own side, not for a figure.
[[nodiscard]] Replay replay(std::span<const TuningFold> folds, std::span<const TracePosition> positions,
                            const LibsvmPeer* peer);

}  // namespace gyrotherm
