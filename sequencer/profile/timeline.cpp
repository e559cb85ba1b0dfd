#include "sequencer/profile/timeline.hpp"

namespace gyrotherm {
namespace {

constexpr Duration kCluster = std::chrono::seconds(100);

void count(const Segment& segment, CycleTotal& total) {
  (segment.kind == SegmentKind::ramp ? total.ramps : total.holds) += shortest(segment);
  total.clusters = (total.ramps + total.holds) / kCluster;
}

}  // namespace

Timeline plan(const Profile& profile) {
  Timeline timeline;
  timeline.all.name = "all";
  for (const auto& name : profile.cycles) timeline.cycles.push_back({.name = name});
  Duration start{};
  for (std::size_t i = 0; i < profile.segments.size(); ++i) {
    const auto& segment = profile.segments[i];
    const auto from = segment.kind == SegmentKind::ramp ? set_point_before(profile, i) : segment.target;
    timeline.segments.push_back({start, shortest(segment), from, segment.target});
    start += shortest(segment);
    count(segment, timeline.all);
    if (segment.cycle >= 0) count(segment, timeline.cycles[static_cast<std::size_t>(segment.cycle)]);
  }
  return timeline;
}

}  // namespace gyrotherm
