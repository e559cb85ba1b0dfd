// SPDX-License-Identifier: Apache-2.0
#include "tests/sequencer/faults/schedule.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>

namespace gyrotherm::faults {
namespace {

constexpr int kChannels = 9, kThermometerLines = 2, kRecordFiles = 2;
/// Longest delay of an answer, s. An answer without a transaction number is attributed to the right request if it
/// arrives within 1 s, which is twice the time-out.
constexpr double kLatestAnswer = 0.95;

struct KindRow {
  InjectedFaultKind kind{};
  const char* name = "";
  int targets = 1;
  bool lasting = true;
  double least = 0, most = 0;  ///< size
  /// Faults that end a run are drawn less often.
  int weight = 4;
};

using Kind = InjectedFaultKind;
constexpr std::array<KindRow, kInjectedFaultKinds> kKinds{{
    {Kind::chamber_silent, "chamber_silent"},
    {Kind::chamber_gone, "chamber_gone"},
    {Kind::chamber_half_open, "chamber_half_open"},
    {Kind::chamber_exchanged, "chamber_exchanged"},
    {Kind::chamber_answers_lost, "chamber_answers_lost"},
    {Kind::chamber_lossy, "chamber_lossy", 1, true, 0.1, 0.8},
    {Kind::chamber_late, "chamber_late", 1, true, 0.1, kLatestAnswer},
    {Kind::chamber_doubled, "chamber_doubled", 1, true, 0.01, 1},
    {Kind::chamber_noise, "chamber_noise", 1, true, 0.01, 0.8},
    {Kind::chamber_cut, "chamber_cut", 1, true, 0.01, 0.8},
    {Kind::chamber_exception, "chamber_exception", 1, true, 1, 11.99},
    {Kind::chamber_write_exception, "chamber_write_exception", 1, true, 1, 11.99},
    {Kind::chamber_foreign_unit, "chamber_foreign_unit"},
    {Kind::chamber_wrong_number, "chamber_wrong_number"},
    {Kind::chamber_ignores_writes, "chamber_ignores_writes"},
    {Kind::chamber_clamps, "chamber_clamps", 1, true, 5, 60},
    {Kind::chamber_restarts, "chamber_restarts", 3, false, 20, 25},
    {Kind::chamber_switched_off, "chamber_switched_off", 1, false},
    {Kind::chamber_manual, "chamber_manual", 1, false},
    {Kind::panel_set_point, "panel_set_point", 1, false, -40, 85},
    {Kind::heater_weak, "heater_weak", 1, true, 0, 1},
    {Kind::cooler_weak, "cooler_weak", 1, true, 0, 1},
    {Kind::machinery_stuck, "machinery_stuck", 1, true, -1, 1},
    {Kind::door_open, "door_open"},
    {Kind::limiter_trips, "limiter_trips", 1, false, 0, 0, 2},
    {Kind::filter_dirty, "filter_dirty"},
    {Kind::air_sensor_error, "air_sensor_error", 1, true, -30, 30},
    {Kind::air_sensor_frozen, "air_sensor_frozen"},
    {Kind::air_sensor_broken, "air_sensor_broken"},
    {Kind::thermometer_open, "thermometer_open", kChannels},
    {Kind::thermometer_short, "thermometer_short", kChannels},
    {Kind::thermometer_lost, "thermometer_lost", kChannels},
    {Kind::thermometer_stuck, "thermometer_stuck", kChannels},
    {Kind::thermometer_spike, "thermometer_spike", kChannels, false, -60, 60},
    {Kind::thermometer_drift, "thermometer_drift", kChannels, true, -5, 5},
    {Kind::thermometers_swapped, "thermometers_swapped", kChannels},
    {Kind::thermometer_alternates, "thermometer_alternates", kChannels, true, 110, 200, 2},
    {Kind::thermometers_frozen, "thermometers_frozen", kThermometerLines},
    {Kind::thermometer_silent, "thermometer_silent", kThermometerLines},
    {Kind::thermometer_gone, "thermometer_gone", kThermometerLines},
    {Kind::thermometer_exchanged, "thermometer_exchanged", kThermometerLines},
    {Kind::thermometer_lossy, "thermometer_lossy", kThermometerLines, true, 0.1, 0.8},
    {Kind::thermometer_noise, "thermometer_noise", kThermometerLines, true, 0.01, 0.8},
    {Kind::thermometer_late, "thermometer_late", kThermometerLines, true, 0.1, kLatestAnswer},
    {Kind::thermometer_doubled, "thermometer_doubled", kThermometerLines, true, 0.01, 1},
    {Kind::gyro_silent, "gyro_silent"},
    {Kind::gyro_gone, "gyro_gone"},
    {Kind::gyro_garbled, "gyro_garbled", 1, true, 0.01, 1},
    {Kind::gyro_loses_frames, "gyro_loses_frames", 1, true, 0.01, 1},
    {Kind::gyro_bursts, "gyro_bursts"},
    {Kind::gyro_dead, "gyro_dead"},
    {Kind::gyro_restarts, "gyro_restarts", 1, false},
    {Kind::disk_full, "disk_full"},
    {Kind::disk_fails, "disk_fails"},
    {Kind::disk_fails_once, "disk_fails_once", 1, false, 1, 60},
    {Kind::disk_loses_syncs, "disk_loses_syncs"},
    {Kind::disk_slow, "disk_slow", 1, true, 1, 30},
    {Kind::disk_hangs, "disk_hangs"},
    {Kind::file_removed, "file_removed", kRecordFiles, false},
    {Kind::file_replaced, "file_replaced", kRecordFiles, false},
    {Kind::file_cut, "file_cut", kRecordFiles, false, 0, 0.99},
    {Kind::file_overwritten, "file_overwritten", kRecordFiles, false, 0, 0.99},
    {Kind::machine_sleeps, "machine_sleeps"},
    {Kind::wall_clock_steps, "wall_clock_steps", 1, false, -86400, 86400},
    {Kind::program_late, "program_late"},
    {Kind::program_crashes, "program_crashes"},
    {Kind::program_stopped, "program_stopped"},
    {Kind::outputs_blocked, "outputs_blocked"},
    {Kind::power_cut, "power_cut"},
    {Kind::operator_pauses, "operator_pauses"},
    {Kind::operator_stops, "operator_stops", 1, false, 0, 0, 1},
    {Kind::operator_aborts, "operator_aborts", 1, false, 0, 0, 1},
    {Kind::operators_at_once, "operators_at_once", 1, false, 16, 1023, 2},
    {Kind::unit_dropped, "unit_dropped"},
}};

constexpr bool rows_are_in_order() {
  for (std::size_t i = 0; i < kKinds.size(); ++i)
    if (kKinds[i].kind != static_cast<InjectedFaultKind>(i)) return false;
  return true;
}
static_assert(rows_are_in_order());

/// A random generator that, unlike the standard's distributions, gives the same results on every machine.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : bits_(seed) {}
  double uniform(double low, double high) {
    constexpr double kTo53Bits = 0x1p-53;
    return low + (high - low) * static_cast<double>(bits_() >> 11) * kTo53Bits;
  }
  std::int64_t whole(std::int64_t below) {
    return static_cast<std::int64_t>(bits_() % static_cast<std::uint64_t>(below));
  }
  /// Draws a duration. Most are short, some are long.
  std::int64_t seconds(std::int64_t longest) {
    return std::llround(std::exp(uniform(0, std::log(static_cast<double>(longest)))));
  }

 private:
  std::mt19937_64 bits_;
};

const KindRow& row_of(InjectedFaultKind kind) { return kKinds[static_cast<std::size_t>(kind)]; }

/// Draws the kinds of fault of a schedule. Selects each kind with a probability that is drawn from the seed, and lists
/// a selected kind as often as its weight.
std::vector<InjectedFaultKind> enabled_kinds(Draw& draw, const ScheduleOptions& options) {
  std::vector<InjectedFaultKind> kinds;
  const double share = draw.uniform(0.05, 1);
  for (const auto& row : kKinds)
    if ((row.kind != Kind::unit_dropped || options.units > 1) && draw.uniform(0, 1) < share)
      kinds.insert(kinds.end(), static_cast<std::size_t>(row.weight), row.kind);
  if (kinds.empty()) kinds.push_back(static_cast<InjectedFaultKind>(draw.whole(kInjectedFaultKinds)));
  return kinds;
}

bool is_unit_fault(InjectedFaultKind kind) {
  return (kind >= Kind::gyro_silent && kind <= Kind::gyro_restarts) || kind == Kind::unit_dropped;
}

InjectedFault draw_fault(Draw& draw, const std::vector<InjectedFaultKind>& kinds, const ScheduleOptions& options) {
  const auto& row = row_of(kinds[static_cast<std::size_t>(draw.whole(static_cast<std::int64_t>(kinds.size())))]);
  const double in_one = row.most - row.least > 20 ? 1 : 100;
  return {.at = draw.whole(options.seconds),
          .kind = row.kind,
          .target = static_cast<int>(draw.whole(is_unit_fault(row.kind) ? options.units : row.targets)),
          .lasts = row.lasting ? draw.seconds(options.longest) : 0,
          .size = std::round(draw.uniform(row.least, row.most) * in_one) / in_one};
}

}  // namespace

Schedule draw_schedule(std::uint64_t seed, const ScheduleOptions& options) {
  Draw draw(seed);
  const auto kinds = enabled_kinds(draw, options);
  Schedule schedule;
  for (auto left = 1 + draw.whole(options.most); left > 0; --left) schedule.push_back(draw_fault(draw, kinds, options));
  std::ranges::stable_sort(schedule, {}, &InjectedFault::at);
  return schedule;
}

const char* name(InjectedFaultKind kind) { return row_of(kind).name; }

std::string text(const InjectedFault& fault) {
  return fmt::format("{} {} {} {} {:g}", fault.at, name(fault.kind), fault.target, fault.lasts, fault.size);
}

std::string text(const Schedule& schedule) {
  std::string lines;
  for (const auto& fault : schedule) lines += text(fault) + "\n";
  return lines;
}

std::optional<InjectedFault> parse_fault(std::string_view line) {
  std::istringstream words{std::string(line)};
  InjectedFault fault;
  std::string kind;
  if (!(words >> fault.at >> kind >> fault.target >> fault.lasts >> fault.size)) return std::nullopt;
  const auto row = std::ranges::find_if(kKinds, [&](const auto& one) { return one.name == kind; });
  if (row == kKinds.end()) return std::nullopt;
  fault.kind = row->kind;
  return fault;
}

}  // namespace gyrotherm::faults
