// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/run/pace.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "core/program_start.hpp"

namespace gyrotherm::app {
namespace {

/// Lateness up to which the following seconds are shorter.
constexpr auto kLargestBacklog = std::chrono::milliseconds(500);

std::optional<double> read_pace(const std::string& text) {
  constexpr double kFastest = 1e6;
  if (text == "real") return 1;
  if (text == "max") return 0;
  if (!text.starts_with('x')) return {};
  const auto factor = text.substr(1);
  if (!value_refusal_reason(factor, "FLOAT").empty()) return {};
  const double times = std::strtod(factor.c_str(), nullptr);
  return times > 0 && times <= kFastest ? std::optional(times) : std::nullopt;
}

}  // namespace

Result<double> parse_pace(const std::string& text) {
  if (const auto pace = read_pace(text)) return *pace;
  return failure(FaultKind::usage, "--pace",
                 fmt::format("\"{}\", expected real, max or xN for N times real time", text));
}

Result<double> pace_of_run(const std::string& text, bool is_virtual) {
  if (text.empty()) return 0;
  if (!is_virtual)
    return failure(FaultKind::usage, "--pace", "only valid on a virtual rig; a real rig runs in real time");
  return parse_pace(text);
}

CLI::Option* add_pace_option(CLI::App& command, std::string& pace, const std::string& help) {
  return command.add_option("--pace", pace, help)->type_name("PACE:{real,x10,max}");
}

std::optional<Pacer::TimePoint> Pacer::next_second(TimePoint now, bool is_paused) {
  const bool is_faster = pace_ == 0 || pace_ > 1;
  const double pace = is_paused && is_faster ? 1 : pace_;
  if (pace == 0) {
    due_.reset();
    return {};
  }
  const auto last = due_ && now - *due_ <= kLargestBacklog ? *due_ : now;
  due_ = last + std::chrono::duration_cast<TimePoint::duration>(std::chrono::duration<double>(1 / pace));
  return *due_ > now ? due_ : std::nullopt;
}

}  // namespace gyrotherm::app
