#include "bench/svr/replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/stopwatch.hpp"
#include "bench/svr/own_solver.hpp"

namespace gyrotherm {
namespace {

constexpr double kAgreement = 0.005;

bool near(double a, double b) { return std::abs(a - b) <= kAgreement * std::abs(b); }

void say(const ReplayedPosition& p) {
  const auto& at = p.position;
  std::string text = fmt::format("C 2^{:.3f} gamma 2^{:.3f} epsilon 2^{:.3f}: LIBSVM {:.4f} s, error {:.6g}; ",
                                 at.log2_c, at.log2_gamma, at.log2_epsilon, p.peer.seconds, p.peer.error);
  text += p.own ? fmt::format("ours {:.4f} s, error {:+.3f} %, gain {:.1f}", p.own->seconds,
                              100 * (p.own->error / p.peer.error - 1), p.peer.seconds / p.own->seconds)
                : "ours not certified";
  if (p.reference) {
    text += fmt::format("; reference: LIBSVM {:+.3f} %", 100 * (p.peer.error / *p.reference - 1));
    if (p.own) text += fmt::format(", ours {:+.3f} %", 100 * (p.own->error / *p.reference - 1));
  }
  say_progress(text);
}

}  // namespace

bool ReplayedPosition::agrees() const {
  if (!own) return false;
  if (near(own->error, peer.error)) return true;
  return reference && std::abs(own->error - *reference) < std::abs(peer.error - *reference);
}

double Replay::peer_seconds() const {
  double sum = 0;
  for (const auto& p : positions) sum += p.peer.seconds;
  return sum;
}

double Replay::own_seconds() const {
  double sum = 0;
  for (const auto& p : positions) sum += p.own ? p.own->seconds : std::numeric_limits<double>::infinity();
  return sum;
}

double Replay::peer_mean_error_s() const {
  const auto n = static_cast<double>(positions.size());
  const double mean = peer_seconds() / n;
  double squares = 0;
  for (const auto& p : positions) squares += (p.peer.seconds - mean) * (p.peer.seconds - mean);
  return std::sqrt(squares / (n - 1) / n);
}

int Replay::disagreements() const {
  return static_cast<int>(std::ranges::count_if(positions, [](const auto& p) { return !p.agrees(); }));
}

Replay replay(std::span<const TuningFold> folds, std::span<const TracePosition> positions, const LibsvmPeer* peer) {
  Replay out;
  for (const TracePosition& position : positions) {
    ReplayedPosition p{.position = position, .peer = {position.error, position.seconds}, .own = {}, .reference = {}};
    if (peer != nullptr) p.peer = peer->cross_validate(folds, position.parameters());
    if (const auto own = cross_validate_own(folds, position)) p.own = *own;
    if (p.own && !near(p.own->error, p.peer.error)) {
      const auto reference = reference_error(folds, position.parameters());
      if (reference) p.reference = *reference;
      if (!reference) say_progress("no reference: " + text(reference.error()));
    }
    say(p);
    out.positions.push_back(std::move(p));
  }
  return out;
}

}  // namespace gyrotherm
