#include "bench/svr/tuning_material.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace gyrotherm {

const TracePosition& TuningMaterial::best() const {
  return *std::ranges::min_element(trace, {}, &TracePosition::error);
}

std::string TuningMaterial::name(const std::string& figure) const {
  return fmt::format("n={}: {}", set.y.size(), figure);
}

Result<TuningMaterial> tuning_material(const std::string& data, const std::string& traces, const std::string& name) {
  auto set = load_sample_set(data, name);
  if (!set) return failure(set.error());
  auto trace = load_trace(traces + "/" + name + ".trace");
  if (!trace) return failure(trace.error());
  auto folds = shuffled_folds(*set);
  return TuningMaterial{std::move(*set), std::move(folds), std::move(*trace)};
}

}  // namespace gyrotherm
