// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/netcdf_export.hpp"

#include <fmt/format.h>
#include <netcdf.h>
#include <netcdf_mem.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <set>
#include <string_view>
#include <vector>

#include "acquisition/record/csv.hpp"
#include "acquisition/record/schema.hpp"
#include "core/clock.hpp"
#include "core/file.hpp"

namespace gyrotherm::exchange {

namespace {

using record::AxisInfo, record::GyroKind, record::kMissing, record::Record, record::RunInfo, record::UnitInfo;

/// A NetCDF file in memory. Keeps the first error and ignores all calls after it.
class NetcdfFile {
 public:
  NetcdfFile() { keep(nc_create_mem("record", NC_NETCDF4, 0, &file_)); }
  ~NetcdfFile() {
    if (file_ >= 0) nc_abort(file_);
  }
  NetcdfFile(const NetcdfFile&) = delete;
  NetcdfFile& operator=(const NetcdfFile&) = delete;

  int dimension(const char* name, std::size_t size) {
    int made = -1;
    if (good()) keep(nc_def_dim(file_, name, size, &made));
    return made;
  }
  /// Defines a variable along a dimension, or a scalar variable if the dimension is −1. Compresses the variable with
  /// DEFLATE, which every HDF5 reader supports.
  int variable(const std::string& name, nc_type type, int dimension) {
    constexpr int kShuffled = 1, kPacked = 1, kLevel = 2;
    int made = -1;
    if (good()) keep(nc_def_var(file_, name.c_str(), type, dimension < 0 ? 0 : 1, &dimension, &made));
    if (good() && dimension >= 0) keep(nc_def_var_deflate(file_, made, kShuffled, kPacked, kLevel));
    return made;
  }
  void attribute(int variable, const char* name, std::string_view text) {
    if (good()) keep(nc_put_att_text(file_, variable, name, text.size(), text.data()));
  }
  void attribute(int variable, const char* name, double number) {
    if (good()) keep(nc_put_att_double(file_, variable, name, NC_DOUBLE, 1, &number));
  }
  void attribute(int variable, const char* name, const std::vector<int>& numbers, nc_type type) {
    if (good()) keep(nc_put_att_int(file_, variable, name, type, numbers.size(), numbers.data()));
  }
  void values(int variable, const std::vector<double>& numbers) {
    if (good()) keep(nc_put_var_double(file_, variable, numbers.data()));
  }
  void values(int variable, const std::vector<int>& numbers) {
    if (good()) keep(nc_put_var_int(file_, variable, numbers.data()));
  }
  void values(int variable, const std::string& text) {
    if (good()) keep(nc_put_var_text(file_, variable, text.data()));
  }

  /// Closes the file and returns its bytes.
  Result<std::string> close(const std::string& path) {
    NC_memio bytes{};
    if (good()) {
      keep(nc_close_memio(file_, &bytes));
      file_ = -1;
    }
    std::string text;
    if (good()) text.assign(static_cast<const char*>(bytes.memory), bytes.size);
    std::free(bytes.memory);
    if (good()) return text;
    return failure(FaultKind::storage, path, std::string("cannot be created: ") + nc_strerror(error_));
  }

 private:
  [[nodiscard]] bool good() const { return error_ == NC_NOERR; }
  void keep(int error) {
    if (good()) error_ = error;
  }
  int file_ = -1;
  int error_ = NC_NOERR;
};

bool is_letter_or_digit(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'); }

/// Returns a name in the form that CF allows: letters, digits and _, with a letter first.
std::string variable_name(std::string_view channel) {
  std::string name;
  for (const char c : channel) name += is_letter_or_digit(c) ? c : '_';
  const bool begins_with_letter = !name.empty() && (std::isalpha(static_cast<unsigned char>(name.front())) != 0);
  return begins_with_letter ? name : "v_" + name;
}

/// Converts a text to one word of flag_meanings, in which blanks separate words. Replaces every character that CF does
/// not allow by `_`. CF allows letters, digits and _ - . + @.
std::string flag_word(std::string_view words) {
  std::string word;
  for (const char c : words) {
    if ((static_cast<unsigned char>(c) & 0xC0) == 0x80) continue;  // continuation byte of UTF-8
    const bool is_allowed = is_letter_or_digit(c) || std::string_view("_-.+@").find(c) != std::string_view::npos;
    word += is_allowed ? c : '_';
  }
  return word.empty() ? "_" : word;
}

/// The rows of the file: the rows of the record, and an empty row for each second (or stretch) of a gap.
struct Rows {
  std::vector<double> time_s{};
  std::vector<std::ptrdiff_t> row{};  ///< in the record; −1: none
};

/// Returns the rows of the file. Rows of a record of gyrotherm are `step` seconds apart unless rows are missing.
Rows make_rows(const Record& record, std::int64_t step) {
  Rows rows;
  for (std::size_t i = 0; i < record.slot.size(); ++i) {
    // Count missing stretches by their numbers, because a stretch that begins in a gap has the slot of a later second.
    const auto before = i > 0 ? record.slot[i - 1] / step : 0;
    const auto since_before = i > 0 && !record.info.imported ? record.slot[i] / step - before : 1;
    for (std::int64_t missing = 1; missing < since_before; ++missing) {
      rows.time_s.push_back(record.time_s[i - 1] + static_cast<double>((before + missing) * step - record.slot[i - 1]));
      rows.row.push_back(-1);
    }
    rows.time_s.push_back(record.time_s[i]);
    rows.row.push_back(static_cast<std::ptrdiff_t>(i));
  }
  return rows;
}

/// Writes one export: defines and writes one variable after the other.
class NetcdfExport {
 public:
  NetcdfExport(const Record& record, const ExportChoice& choice)
      : record_(record),
        info_(record.info),
        rows_(make_rows(record, std::max<std::int64_t>(1, choice.every / kSecond))) {}

  Result<std::string> bytes(const std::string& path) {
    time_ = file_.dimension("time", rows_.time_s.size());
    describe_file();
    put_time();
    put_location();
    put("set_point_c", "degC", "set point of the profile", record_.set_point_c);
    put("chamber_air_c", "degC", "air of the chamber", record_.chamber_air_c);
    put("chamber_set_point_c", "degC", "set point read back from the chamber", record_.chamber_set_point_c);
    if (info_.has_humidity)
      put("chamber_humidity_percent", "percent", "relative humidity of the chamber", record_.chamber_humidity_percent);
    if (info_.has_dew_point)
      put("chamber_dew_point_c", "degC", "dew point of the chamber", record_.chamber_dew_point_c);
    for (std::size_t i = 0; i < info_.thermometers.size(); ++i) put_thermometer(i);
    for (std::size_t i = 0; i < info_.units.size(); ++i) put_unit(i);
    if (!info_.imported) put_progress();
    return file_.close(path);
  }

 private:
  void describe_file() {
    const auto global = [&](const char* name, std::string_view text) { file_.attribute(NC_GLOBAL, name, text); };
    global("Conventions", "CF-1.10");
    global("featureType", "timeSeries");
    global("title", info_.profile_name);
    global("source", is_simulated(info_) ? "SIMULATED: " + describe_simulation(info_) : "measured");
    global("history", "made by gyrotherm " + info_.program_version + ", exported as NetCDF");
    global("run_id", info_.id);
    global("profile", info_.profile_name);
    global("rig", info_.rig_name);
    global("program_version", info_.program_version);
    global("finished", record_.finished ? "yes" : "no");
    if (!info_.order_number.empty()) global("order_number", info_.order_number);
    global("rows",
           info_.imported ? "at a foreign record's own times" : "one for each second or stretch, including gaps");
  }

  void put_time() {
    const int variable = file_.variable("time", NC_DOUBLE, time_);
    file_.attribute(variable, "axis", std::string_view("T"));
    if (info_.started_utc == Duration{}) {
      file_.attribute(variable, "units", std::string_view("s"));
      file_.attribute(variable, "long_name", std::string_view("time since the first row"));
    } else {
      file_.attribute(variable, "standard_name", std::string_view("time"));  // requires units with a reference
      file_.attribute(variable, "units", "seconds since " + start());
      file_.attribute(variable, "calendar", std::string_view("standard"));
      file_.attribute(variable, "long_name", std::string_view("time since the run started"));
    }
    file_.values(variable, rows_.time_s);
  }

  /// Returns the start of the run: "2026-01-01 00:00:00.000000 UTC".
  std::string start() const {
    auto text = civil_time(info_.started_utc);
    text.replace(text.find('T'), 1, " ");
    text.pop_back();
    const auto part = std::chrono::duration_cast<std::chrono::microseconds>(info_.started_utc % kSecond).count();
    return fmt::format("{}.{:06} UTC", text, part);
  }

  /// Writes the run's id and, if the record contains it, the latitude of the rig.
  void put_location() {
    const int length = file_.dimension("run_id_length", std::max<std::size_t>(info_.id.size(), 1));
    const int run = file_.variable("run", NC_CHAR, length);
    file_.attribute(run, "cf_role", std::string_view("timeseries_id"));
    file_.attribute(run, "long_name", std::string_view("id of the run"));
    if (!info_.id.empty()) file_.values(run, info_.id);
    for (const UnitInfo& unit : info_.units)
      for (const AxisInfo& axis : unit.axes) {
        if (!axis.uncertainty.latitude_deg || has_latitude_) continue;
        has_latitude_ = true;
        const int latitude = file_.variable("latitude", NC_DOUBLE, -1);
        file_.attribute(latitude, "standard_name", std::string_view("latitude"));
        file_.attribute(latitude, "units", std::string_view("degrees_north"));
        file_.attribute(latitude, "long_name", std::string_view("latitude of the rig"));
        file_.values(latitude, std::vector<double>{*axis.uncertainty.latitude_deg});
      }
  }

  /// Returns a unique name for a variable.
  std::string unique_name(std::string_view channel) {
    std::string name = variable_name(channel);
    while (!taken_.insert(name).second) name += "_2";
    return name;
  }

  std::vector<double> align_with_rows(const std::vector<double>& column) const {
    std::vector<double> values(rows_.row.size(), kMissing);
    for (std::size_t i = 0; i < values.size(); ++i)
      if (const auto row = rows_.row[i]; row >= 0 && static_cast<std::size_t>(row) < column.size())
        values[i] = column[static_cast<std::size_t>(row)];
    return values;
  }

  int put(std::string_view channel, std::string_view units, std::string_view long_name,
          const std::vector<double>& column) {
    return put_as(unique_name(channel), channel, units, long_name, column);
  }

  int put_as(const std::string& name, std::string_view channel, std::string_view units, std::string_view long_name,
             const std::vector<double>& column) {
    const int variable = file_.variable(name, NC_DOUBLE, time_);
    file_.attribute(variable, "_FillValue", kMissing);
    file_.attribute(variable, "units", units);
    file_.attribute(variable, "long_name", long_name);
    file_.attribute(variable, "coordinates", std::string_view(has_latitude_ ? "run latitude" : "run"));
    if (name != channel) file_.attribute(variable, "channel", channel);
    file_.values(variable, align_with_rows(column));
    return variable;
  }

  /// Writes a variable of numbers, each of which represents a word of flag_meanings. A value of −1 means that there is
  /// no word.
  void put_flags(const std::string& name, std::string_view long_name, const std::vector<std::string>& words,
                 const std::vector<int>& values) {
    const int variable = file_.variable(name, NC_INT, time_);
    std::string meanings;
    for (const auto& word : words) meanings += (meanings.empty() ? "" : " ") + flag_word(word);
    std::vector<int> numbers(words.size());
    std::iota(numbers.begin(), numbers.end(), 0);
    if (std::ranges::find(values, -1) != values.end())
      file_.attribute(variable, "_FillValue", std::vector<int>{-1}, NC_INT);
    file_.attribute(variable, "long_name", long_name);
    if (!words.empty()) file_.attribute(variable, "flag_values", numbers, NC_INT);
    if (!words.empty()) file_.attribute(variable, "flag_meanings", meanings);
    file_.values(variable, values);
  }

  void put_thermometer(std::size_t index) {
    enum Flag { measured, missing, gap };
    const auto& channel = info_.thermometers[index];
    const auto& readings = record_.thermometers_c[index];
    const int variable =
        put(channel.name, "degC", "temperature of " + channel.name, calibrated_temperatures(record_, index));
    file_.attribute(variable, "instrument", channel.instrument);
    file_.attribute(variable, "calibration", record::describe_calibration(channel));
    const auto flag = unique_name(channel.name + "_flag");
    file_.attribute(variable, "ancillary_variables", flag);
    std::vector<int> flags(rows_.row.size(), gap);
    for (std::size_t i = 0; i < flags.size(); ++i)
      if (const auto row = rows_.row[i]; row >= 0)
        flags[i] = std::isnan(readings[static_cast<std::size_t>(row)]) ? missing : measured;
    put_flags(flag, "status of the reading of " + channel.name, {"measured", "missing", "gap"}, flags);
  }

  void put_unit(std::size_t index) {
    const UnitInfo& unit = info_.units[index];
    const auto& columns = record_.units[index];
    std::size_t axis = 0, value = 0;
    for (const auto& column : record::channel_columns(info_)) {
      if (!is_of_unit(column.measures) || column.unit != index) continue;
      switch (column.measures) {
        case record::Measures::rotation: put_axis(column, index, axis++); break;
        case record::Measures::interval:
          put(record::calibrated_name(column), "s", "time over which pulses of " + unit.name + " were counted",
              columns.interval_s);
          break;
        case record::Measures::value:
          put_value(column.name, unit.values[value], columns.values[value]);
          ++value;
          break;
        case record::Measures::true_bias: {
          const auto& truth = columns.true_bias_deg_per_h[column.index];
          if (std::ranges::any_of(truth, [](double number) { return !std::isnan(number); }))
            put(column.name, "degree/hour", "true bias of the virtual laboratory", truth);
          break;
        }
        case record::Measures::humidity:
        case record::Measures::dew_point:
        case record::Measures::temperature: break;
      }
    }
  }

  void put_axis(const record::ChannelColumn& column, std::size_t unit, std::size_t index) {
    const AxisInfo& axis = info_.units[unit].axes[index];
    const auto& columns = record_.units[unit];
    const auto label = record::axis_label(info_.units[unit], index);
    const bool counts = axis.kind == GyroKind::pulse_count;
    const int variable = put(record::calibrated_name(column), "degree/hour",
                             "rate about " + label + ", including the Earth rate", axis_rates(record_, unit, index));
    const auto counts_name = unique_name(column.name);
    file_.attribute(variable, "ancillary_variables", counts_name);
    if (axis.earth_rate) file_.attribute(variable, "earth_rate_deg_per_h", axis.earth_rate->value);
    const auto& serial_number = info_.units[unit].serial_number;
    if (!serial_number.empty()) file_.attribute(variable, "serial_number", serial_number);
    put_names(variable, "gradients", info_.units[unit].gradients);
    put_names(variable, "three_point", info_.units[unit].three_point);
    const int counted =
        put_as(counts_name, column.name, "1", (counts ? "pulses of " : "number of ") + label, columns.rotation[index]);
    file_.attribute(counted, counts ? "arcsec_per_pulse" : "deg_per_h_per_unit", axis.scale);
  }

  void put_names(int variable, const char* attribute, const std::vector<std::string>& names) {
    if (!names.empty()) file_.attribute(variable, attribute, fmt::format("{}", fmt::join(names, ", ")));
  }

  void put_value(const std::string& name, const record::ValueInfo& value, const std::vector<double>& column) {
    const std::string units = value.is_temperature ? "degC" : value.unit.empty() ? "1" : value.unit;
    put(name, units, value.name + " reported by the unit", column);
  }

  void put_progress() {
    std::vector<int> segment(rows_.row.size(), -1), cycle = segment, phase = segment, state = segment;
    for (std::size_t i = 0; i < segment.size(); ++i) {
      const auto row = rows_.row[i];
      if (row < 0) continue;
      const auto at = static_cast<std::size_t>(row);
      const bool has_segment = record::segment_at(record_, at) != nullptr;
      segment[i] = has_segment ? record_.progress[at].segment : -1;
      cycle[i] = record_.progress[at].cycle;
      phase[i] = has_segment ? static_cast<int>(record_.progress[at].phase) : -1;
      state[i] = static_cast<int>(record_.state[at]);
    }
    std::vector<std::string> segments, phases, states;
    for (const auto& one : info_.segments) segments.push_back(one.name);
    for (const Phase one : kPhases) phases.emplace_back(name(one));
    for (const RunState one : kRunStates) states.emplace_back(name(one));
    put_flags(unique_name("segment"), "segment of the profile", segments, segment);
    put_flags(unique_name("cycle"), "cycle of the profile", info_.cycles, cycle);
    put_flags(unique_name("phase"), "phase of the segment", phases, phase);
    put_flags(unique_name("state"), "state of the run", states, state);
    if (record::has_operator_actions(info_)) put_turned();
  }

  /// Writes the `turned` flag, which determines the sign of the Earth rate.
  void put_turned() {
    std::vector<int> turned(rows_.row.size(), -1);
    for (std::size_t i = 0; i < turned.size(); ++i) {
      const auto row = rows_.row[i];
      const double at = row < 0 ? kMissing : record::turned_at(record_, static_cast<std::size_t>(row));
      if (!std::isnan(at)) turned[i] = static_cast<int>(at);
    }
    put_flags(unique_name(record::kTurnedTitle), "how the unit is mounted", {"as_mounted", "turned"}, turned);
  }

  const Record& record_;
  const RunInfo& info_;
  Rows rows_;
  NetcdfFile file_{};
  int time_ = -1;
  bool has_latitude_ = false;
  std::set<std::string> taken_{"time", "run", "latitude", "run_id_length"};
};

}  // namespace

Result<void> export_netcdf(const Record& record, const ExportChoice& choice, const std::string& path) {
  const auto bytes = NetcdfExport(record, choice).bytes(path);
  if (!bytes) return failure(bytes.error());
  return replace_text_file(path, *bytes);
}

}  // namespace gyrotherm::exchange
