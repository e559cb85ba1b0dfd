#include "bench/svr/trace.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/file.hpp"

namespace gyrotherm {

PeerParameters TracePosition::parameters() const {
  return {.C = std::exp2(log2_c), .gamma = std::exp2(log2_gamma), .epsilon = std::exp2(log2_epsilon)};
}

Result<std::vector<TracePosition>> load_trace(const std::string& path) {
  const auto text = read_text_file(path, kLargestTable);
  if (!text) return failure(text.error());
  std::vector<TracePosition> trace;
  std::istringstream lines(*text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream fields(line);
    TracePosition p;
    if (!(fields >> p.log2_c >> p.log2_gamma >> p.log2_epsilon >> p.error >> p.seconds))
      return failure(FaultKind::bad_file, fmt::format("{}:{}", path, number), "expected five numbers");
    trace.push_back(p);
  }
  if (trace.empty()) return failure(FaultKind::bad_file, path, "no position");
  return trace;
}

std::string line_of(const TracePosition& p) {
  return fmt::format("{:.6f} {:.6f} {:.6f} {:.8g} {:.4f}\n", p.log2_c, p.log2_gamma, p.log2_epsilon, p.error,
                     p.seconds);
}

std::vector<TracePosition> spread_over(const std::vector<TracePosition>& trace, std::size_t count) {
  count = std::min(count, trace.size());
  std::vector<TracePosition> out;
  for (std::size_t i = 0; i < count; ++i) out.push_back(trace[(2 * i + 1) * trace.size() / (2 * count)]);
  return out;
}

}  // namespace gyrotherm
