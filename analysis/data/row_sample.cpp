// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/row_sample.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>

namespace gyrotherm::data {

namespace {

constexpr std::size_t kSampledHashes = 256, kRowsOfHash = 16;

/// Returns the mix of splitmix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014).
std::uint64_t mix_bits(std::uint64_t bits) {
  bits = (bits ^ (bits >> 30)) * 0xBF58476D1CE4E5B9ULL;
  bits = (bits ^ (bits >> 27)) * 0x94D049BB133111EBULL;
  return bits ^ (bits >> 31);
}

/// Hash of the last 16 rates, updated with each rate.
class RollingHash {
 public:
  /// Takes the next rate. A missing rate starts the sequence again.
  void push(double rate) {
    if (!std::isfinite(rate)) {
      *this = {};
      return;
    }
    // The precision of float makes the hash independent of the rounding of scale and Earth rate.
    const auto next = mix_bits(std::bit_cast<std::uint32_t>(static_cast<float>(rate) + 0.0F));
    std::uint64_t& oldest = window_[count_ % kRowsOfHash];
    const bool changes = count_ > 0 && next != window_[(count_ - 1) % kRowsOfHash];
    hash_ = hash_ * kBase + next - oldest * kBaseToWindow;
    oldest = next;
    bool& had_changed = changed_[count_ % kRowsOfHash];
    changes_ += (changes ? 1 : 0) - (had_changed ? 1 : 0);
    had_changed = changes;
    ++count_;
  }
  [[nodiscard]] bool is_ready() const { return count_ >= kRowsOfHash && 2 * changes_ >= static_cast<int>(kRowsOfHash); }
  /// Returns a number of 53 bits, which JSON stores exactly.
  [[nodiscard]] std::int64_t value() const { return static_cast<std::int64_t>(mix_bits(hash_) >> 11); }

 private:
  static constexpr std::uint64_t kBase = 0x9E3779B97F4A7C15ULL;
  static constexpr std::uint64_t kBaseToWindow = [] {
    std::uint64_t power = 1;
    for (std::size_t i = 0; i < kRowsOfHash; ++i) power *= kBase;
    return power;
  }();

  std::array<std::uint64_t, kRowsOfHash> window_{};
  std::array<bool, kRowsOfHash> changed_{};
  std::uint64_t hash_{};
  std::size_t count_{};
  int changes_{};
};

/// Calls visit(hash) for every 16 consecutive rates in the period.
template <class Visit>
void visit_hashes(const Dataset& dataset, double from_s, double to_s, Visit visit) {
  const bool is_reduced = dataset.bias_zero != kNothingRemoved;
  const double removed = is_reduced ? dataset.earth_rate_deg_per_h.value_or(0) : 0;
  RollingHash hash;
  for (Eigen::Index row = 0; row < dataset.time_s.size(); ++row) {
    if (dataset.time_s(row) < from_s || dataset.time_s(row) >= to_s) continue;
    hash.push(dataset.bias_deg_per_h(row) + removed);
    if (hash.is_ready()) visit(hash.value());
  }
}

}  // namespace

std::vector<std::int64_t> sample_rows(const Dataset& dataset, double from_s, double to_s) {
  std::vector<std::int64_t> hashes;
  visit_hashes(dataset, from_s, to_s, [&](std::int64_t hash) { hashes.push_back(hash); });
  std::ranges::sort(hashes);
  hashes.erase(std::ranges::unique(hashes).begin(), hashes.end());
  hashes.resize(std::min(hashes.size(), kSampledHashes));
  return hashes;
}

bool has_rows_of(const Dataset& dataset, const std::vector<std::int64_t>& sample, double from_s, double to_s) {
  constexpr std::size_t kMinCommon = 3;
  std::vector<std::int64_t> common;
  visit_hashes(dataset, from_s, to_s, [&](std::int64_t hash) {
    if (std::ranges::binary_search(sample, hash)) common.push_back(hash);
  });
  std::ranges::sort(common);
  common.erase(std::ranges::unique(common).begin(), common.end());
  return common.size() >= kMinCommon;
}

}  // namespace gyrotherm::data
