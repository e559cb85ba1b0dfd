// SPDX-License-Identifier: Apache-2.0
#include "sequencer/rig/gyro_settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "core/serial_number.hpp"
#include "drivers/gyro/frame_sum.hpp"
#include "drivers/virtual_identity.hpp"
#include "sequencer/rig/fixture.hpp"
#include "sequencer/rig/line_settings.hpp"
#include "simulator/servers/gyro_server.hpp"

namespace gyrotherm::rig {
namespace {

/// A table of a gyro, or of one of its axes, with the keys that describe the axis.
struct AxisTable {
  TomlTable table;
  std::string name;
  std::string field;  ///< stream's field; empty: its default
};

struct GyroTable {
  TomlTable table;
  std::vector<AxisTable> axes;
};

/// Reads an uncertainty from the axis' table; otherwise from the unit's, which applies to all its axes.
std::optional<double> read_axis_uncertainty(const TomlTable& axis, const TomlTable& unit, const char* key) {
  if (auto own = read_uncertainty(axis, key)) return own;
  return read_uncertainty(unit, key);
}

GyroTable read_axis_names(const TomlTable& table) {
  GyroTable gyro{.table = table, .axes = {}};
  if (!table.is_list("axis")) {
    gyro.axes.push_back({.table = table, .name = {}, .field = table.text("axis", "")});
    return gyro;
  }
  const auto axes = table.tables("axis");
  for (const auto& axis : axes) {
    const auto name = axes.size() == 1 ? axis.text("name", "") : axis.text("name");
    const bool taken = std::ranges::any_of(gyro.axes, [&](const auto& other) { return other.name == name; });
    if (taken) axis.note_error("name", fmt::format("\"{}\" is the name of another axis of this unit", name));
    gyro.axes.push_back({.table = axis, .name = name, .field = axis.text("field", name)});
  }
  return gyro;
}

std::vector<double> read_direction(const TomlTable& table) {
  auto direction = table.numbers("direction");
  double square = 0;
  for (const double part : direction) square += part * part;
  if (direction.size() != 3 || !(square > 0) || !std::isfinite(square)) {
    table.note_error("direction", "expected three numbers, along x, y and z of the fixture, that are not all zero");
    return {1, 0, 0};
  }
  for (double& part : direction) part /= std::sqrt(square);
  return direction;
}

/// Reads the direction of a unit's only axis if the rig has no fixture.
void read_single_direction(const TomlTable& table, record::AxisInfo& axis) {
  const bool located = table.has("latitude");
  const double latitude = located ? read_latitude(table) : 0, azimuth = read_angle(table, "azimuth", 0, kFullTurn),
               elevation = read_angle(table, "elevation", 90, kQuarterTurn);
  axis.uncertainty.latitude_uncertainty_deg = read_angle_uncertainty(table, "latitude_uncertainty");
  axis.uncertainty.azimuth_uncertainty_deg = read_angle_uncertainty(table, "azimuth_uncertainty");
  axis.uncertainty.tilt_uncertainty_deg = read_angle_uncertainty(table, "tilt_uncertainty");
  if (!located) return;
  axis.earth_rate = earth_rate(latitude, azimuth, elevation);
  axis.uncertainty.latitude_deg = latitude;
  axis.uncertainty.azimuth_deg = azimuth;
  axis.uncertainty.elevation_deg = elevation;
}

/// Returns the angle of one count: the frames' own scale, or the pulse weight from the rig file.
double arcsec_per_count(const AxisTable& axis, const TomlTable& unit, const drivers::FrameFormat& frame,
                        std::size_t index) {
  const auto own = index < frame.gyros().size() ? drivers::arcsec_per_count(frame, index) : std::nullopt;
  const auto& table = axis.table.has("arcsec_per_pulse") ? axis.table : unit;
  if (own) {
    if (table.has("arcsec_per_pulse"))
      table.note_error("arcsec_per_pulse", "the frames contain their scale; this key is for frames that count pulses");
    return *own;
  }
  const double weight = table.number("arcsec_per_pulse");
  if (weight == 0 && table.has("arcsec_per_pulse")) table.note_error("arcsec_per_pulse", "must not be zero");
  return weight;
}

record::AxisInfo read_axis(const AxisTable& axis, const TomlTable& unit, const std::optional<Fixture>& fixture) {
  record::AxisInfo info{.name = axis.name, .kind = record::GyroKind::pulse_count};
  if (fixture) {
    const auto direction = read_direction(axis.table);
    orient_axis(*fixture, {direction[0], direction[1], direction[2]},
                read_axis_uncertainty(axis.table, unit, "direction_uncertainty"), info);
  } else {
    read_single_direction(axis.table, info);
  }
  info.uncertainty.scale_factor_uncertainty_ppm =
      read_axis_uncertainty(axis.table, unit, "scale_factor_uncertainty_ppm");
  info.uncertainty.turn_on_repeatability_deg_per_h =
      read_axis_uncertainty(axis.table, unit, "turn_on_repeatability_deg_per_h");
  return info;
}

/// Returns the serial number without surrounding blanks; empty if the file leaves it to the start of the run.
std::string check_serial_number(const TomlTable& table, const std::string& text) {
  if (text.empty()) return {};
  auto number = parse_serial_number(text);
  if (!number) table.note_error("serial_number", number.error().what);
  return number.value_or("");
}

UnitSettings read_unit(const GyroTable& gyro, bool one_of_several, const std::optional<Fixture>& fixture,
                       const std::vector<std::string>& channels) {
  const auto& table = gyro.table;
  UnitSettings unit;
  if (one_of_several) unit.info.name = table.text("name");
  unit.info.serial_number = check_serial_number(table, table.text("serial_number", ""));
  unit.info.model = table.text("model", "");
  unit.can_be_turned = table.boolean("can_be_turned", false);
  if (table.has("largest_bias_deg_per_h")) {
    unit.largest_bias_deg_per_h = table.number("largest_bias_deg_per_h");
    if (!(*unit.largest_bias_deg_per_h >= 0)) table.note_error("largest_bias_deg_per_h", "expected zero or more");
  }
  unit.continue_when_silent =
      table.choice("when_silent", {"suspend", "go_on"}, one_of_several ? "go_on" : "suspend") == "go_on";
  unit.has_own_thermometers = table.has("thermometers");
  unit.has_own_three_point = table.has("three_point");
  unit.info.gradients = read_channel_names(table, "thermometers", channels);
  unit.info.three_point = read_channel_names(table, "three_point", channels);
  if (unit.has_own_thermometers && unit.info.gradients.size() < 2)
    table.note_error("thermometers", "expected at least two thermometers");
  if (!unit.info.three_point.empty() && unit.info.three_point.size() != 3)
    table.note_error("three_point", "expected three thermometers: cathode, anode, shell");
  for (const auto& axis : gyro.axes) unit.info.axes.push_back(read_axis(axis, table, fixture));
  return unit;
}

/// Returns the reason why a stream has no field for an axis of the rig file; empty if it has one.
std::string missing_axis_reason(const drivers::GyroStream& stream, const std::string& axis) {
  const auto& all = stream.frame.all_axes;
  if (std::ranges::count(all, axis) > 0 || (all.empty() && axis.empty())) return {};
  if (all.empty())
    return fmt::format(
        "the stream {} has a single axis without a name, not \"{}\": leave out \"axis\" or [[gyro.axis]], and write "
        "the "
        "keys of [[gyro.axis]] into the table of the gyro",
        stream.name, axis);
  return fmt::format("the stream {} has no axis \"{}\", expected {}", stream.name, axis, fmt::join(all, ", "));
}

/// Reads the frames of a line. `axes` are the required axes, in order. If the stream lacks one, calls `refuse` with its
/// index and the reason, and leaves the stream's default axes.
Result<void> read_frames(const TomlTable& table, const std::string& rig_file, const std::vector<std::string>& axes,
                         const std::optional<std::string>& known,
                         const std::function<void(std::size_t, const std::string&)>& refuse, GyroLine& line) {
  std::optional<double> rate_hz;
  if (table.has("rate_hz")) rate_hz = table.number("rate_hz");
  if (rate_hz && !(*rate_hz > 0)) table.note_error("rate_hz", "expected a positive number of frames a second");
  line.listen_only = table.boolean("listen_only", false);
  if (!table.has("stream")) {
    if (!table.has("frame")) {
      table.note_error("", "missing key \"stream\", expected the name or file of a gyro stream, or [gyro.frame]");
      return {};
    }
    line.frame = drivers::read_frame_format(table.table("frame"), axes, rate_hz);
    return {};
  }
  if (table.has("frame")) table.note_error("frame", "the stream defines the frames; expected one of the two");
  const auto parse = [&](const NamedText& named) -> Result<drivers::GyroStream> {
    auto any = drivers::parse_gyro_stream(named.text, named.path, {}, rate_hz);
    bool is_complete = any.has_value();
    for (std::size_t i = 0; any && i < axes.size(); ++i)
      if (const auto why = missing_axis_reason(*any, axes[i]); !why.empty()) {
        refuse(i, why);
        is_complete = false;
      }
    return is_complete && !axes.empty() ? drivers::parse_gyro_stream(named.text, named.path, axes, rate_hz) : any;
  };
  auto stream = read_named(table, "stream", rig_file, kShippedGyroStream, known).and_then(parse);
  if (!stream) return failure(std::move(stream.error()));
  line.frame = stream->frame;
  line.stream = std::move(*stream);
  return {};
}

/// Reads all gyros of a rig file.
class Reader {
 public:
  Reader(const TomlTable& root, const std::string& rig_file, const std::vector<std::string>& channels,
         const std::map<std::string, std::string>& known)
      : root_(root), file_(rig_file), channels_(channels), known_(known) {}

  Result<GyroSettings> read() {
    const bool several = root_.is_list("gyro");
    const auto tables = several ? root_.tables("gyro") : std::vector{root_.table("gyro")};
    if (tables.empty()) root_.note_error("gyro", "missing [[gyro]], expected at least one");
    std::optional<Fixture> fixture;
    if (root_.has("fixture")) fixture = read_fixture(root_.table("fixture"));
    for (const auto& table : tables) {
      gyros_.push_back(read_axis_names(table));
      settings_.units.push_back(read_unit(gyros_.back(), several, fixture, channels_));
      if (!fixture && gyros_.back().axes.size() > 1 && table.has("latitude"))
        table.note_error("latitude", "for several axes, expected [fixture] and a direction for each axis");
    }
    check_names();
    for (std::size_t i = 0; i < gyros_.size(); ++i)
      if (!gyros_[i].table.has("shares_line_with")) settings_.lines.push_back(begin_line(i));
    for (std::size_t i = 0; i < gyros_.size(); ++i)
      if (gyros_[i].table.has("shares_line_with")) share_line(i);
    Result<void> done;
    for (auto& line : settings_.lines)
      if (auto read = fill(line); !read && done) done = std::move(read);
    if (!done) return failure(done.error());
    return std::move(settings_);
  }

 private:
  void check_names() const {
    for (std::size_t i = 0; i < gyros_.size(); ++i)
      for (std::size_t k = 0; k < i; ++k)
        if (settings_.units[i].info.name == settings_.units[k].info.name)
          gyros_[i].table.note_error("name",
                                     fmt::format("\"{}\" is the name of another gyro", settings_.units[i].info.name));
  }

  [[nodiscard]] GyroLine begin_line(std::size_t unit) const {
    GyroLine line;
    line.line = gyros_[unit].table.text("line");
    check_line(gyros_[unit].table, line.line);
    line.shares.push_back({.unit = unit});
    return line;
  }

  void share_line(std::size_t unit) {
    const auto& table = gyros_[unit].table;
    const auto owner = table.text("shares_line_with");
    for (const char* key : {"line", "stream", "frame", "rate_hz", "listen_only"})
      if (table.has(key))
        table.note_error(key, fmt::format("the line and its frames are already defined by \"{}\"", owner));
    for (auto& line : settings_.lines)
      if (settings_.units[line.shares.front().unit].info.name == owner) {
        line.shares.push_back({.unit = unit});
        return;
      }
    table.note_error("shares_line_with", fmt::format("\"{}\" is not a gyro with a line of its own", owner));
  }

  [[nodiscard]] Result<void> fill(GyroLine& line) {
    std::vector<std::string> fields;
    std::vector<const AxisTable*> axes;
    for (auto& share : line.shares)
      for (const auto& axis : gyros_[share.unit].axes) {
        share.axes.push_back(fields.size());
        fields.push_back(axis.field);
        axes.push_back(&axis);
      }
    if (fields.size() == 1 && fields.front().empty()) fields.clear();
    const auto owner = line.shares.front().unit;
    const auto text = known_.find(settings_.units[owner].info.name);
    bool is_refused = false;
    const auto refuse = [&](std::size_t index, const std::string& why) {
      is_refused = true;
      const auto& axis = *axes[index];
      axis.table.note_error(axis.table.has("axis") ? "axis" : axis.table.has("field") ? "field" : "name", why);
    };
    const auto read = read_frames(gyros_[owner].table, file_, fields,
                                  text == known_.end() ? std::nullopt : std::optional(text->second), refuse, line);
    if (!read || is_refused) {
      for (const auto& share : line.shares) ignore_scales(gyros_[share.unit]);
      return read;
    }
    for (const auto& share : line.shares) read_scales(line, share);
    share_values(line);
    for (const auto& share : line.shares) {
      auto& unit = settings_.units[share.unit];
      unit.info.instrument = fmt::format("{} at {}", line.stream ? line.stream->name : "gyro", line.line);
      if (!line.stream) continue;
      unit.info.stream_text = line.stream->text;
      if (!unit.largest_bias_deg_per_h) unit.largest_bias_deg_per_h = line.stream->largest_bias_deg_per_h;
    }
    return {};
  }

  static void ignore_scales(const GyroTable& gyro) {
    for (const char* key : {"arcsec_per_pulse", "scale_correction_ppm", "values"}) {
      gyro.table.ignore(key);
      for (const auto& axis : gyro.axes) axis.table.ignore(key);
    }
  }

  void read_scales(const GyroLine& line, const GyroLine::Share& share) {
    const auto& gyro = gyros_[share.unit];
    for (std::size_t i = 0; i < gyro.axes.size(); ++i) {
      const auto& table = gyro.axes[i].table;
      const double correction_ppm = table.number("scale_correction_ppm", 0);
      settings_.units[share.unit].info.axes[i].scale =
          arcsec_per_count(gyro.axes[i], gyro.table, line.frame, share.axes[i]) * (1 + correction_ppm * 1e-6);
    }
  }

  /// Assigns the line's values to its units. Unclaimed values belong to the line's owner.
  void share_values(GyroLine& line) {
    const auto all = drivers::list_housekeeping(line.frame);
    std::vector<bool> claimed(all.size());
    const auto assign = [&](GyroLine::Share& share, std::size_t value) {
      claimed[value] = true;
      share.values.push_back(value);
      settings_.units[share.unit].info.values.push_back(
          {.name = all[value].name, .unit = all[value].unit, .is_temperature = all[value].is_temperature});
    };
    for (auto& share : line.shares) {
      const auto& table = gyros_[share.unit].table;
      for (const auto& name : table.texts("values")) {
        const auto found = std::ranges::find_if(all, [&](const auto& value) { return value.name == name; });
        const auto index = static_cast<std::size_t>(found - all.begin());
        if (found == all.end())
          table.note_error("values", fmt::format("\"{}\" is not one of the stream's values", name));
        else if (claimed[index])
          table.note_error("values", fmt::format("\"{}\" belongs to another unit", name));
        else
          assign(share, index);
      }
    }
    auto& owner = line.shares.front();
    if (gyros_[owner.unit].table.has("values")) return;
    for (std::size_t i = 0; i < all.size(); ++i)
      if (!claimed[i]) assign(owner, i);
  }

  const TomlTable& root_;
  const std::string& file_;
  const std::vector<std::string>& channels_;
  const std::map<std::string, std::string>& known_;
  std::vector<GyroTable> gyros_;
  GyroSettings settings_;
};

}  // namespace

std::vector<std::string> read_channel_names(const TomlTable& table, const char* key,
                                            const std::vector<std::string>& channels) {
  auto names = table.texts(key);
  if (channels.empty()) return names;
  for (auto name = names.begin(); name != names.end(); ++name)
    if (std::ranges::count(channels, *name) == 0)
      table.note_error(key, fmt::format("\"{}\" is not a channel of this rig's thermometers", *name));
    else if (std::find(names.begin(), name, *name) != name)
      table.note_error(key, fmt::format("\"{}\" is listed twice", *name));
  return names;
}

std::string line_title(const GyroLine& line, const std::vector<UnitSettings>& units) {
  std::string names;
  for (const auto& share : line.shares) names += (names.empty() ? "" : "+") + units[share.unit].info.name;
  return names == record::kOnlyUnit ? names : "gyro " + names;
}

Result<void> compare_serial_number(const GyroLine& line, const std::vector<UnitSettings>& units,
                                   const std::string& identity) {
  const auto& expected = units[line.shares.front().unit].info.serial_number;
  if (line.shares.size() > 1 || expected.empty() || contains_serial_number(identity, expected)) return {};
  if (drivers::is_virtual_identity(identity)) return {};
  return failure(FaultKind::mismatch, line_title(line, units),
                 fmt::format("\"{}\" answers, expected the serial number {}", identity, expected));
}

Result<GyroSettings> read_gyros(const TomlTable& root, const std::string& rig_file,
                                const std::vector<std::string>& channels,
                                const std::map<std::string, std::string>& known) {
  return Reader(root, rig_file, channels, known).read();
}

std::unique_ptr<drivers::Gyro> make_gyro(const GyroLine& settings, const drivers::Line& line, Duration within) {
  const auto serial = settings.stream ? settings.stream->port : drivers::SerialFormat{.baud = 115200};
  auto stream = make_stream(line, {.serial = serial}, kConnectWithin);
  drivers::GyroCommands commands;
  if (settings.stream && !settings.listen_only)
    commands = {.start = settings.stream->start, .stop = settings.stream->stop, .identity = settings.stream->identity};
  return make_framed_gyro(settings.frame, make_buffered_stream(std::move(stream)), within, std::move(commands));
}

std::unique_ptr<drivers::Gyro> make_simulated_gyro(const GyroLine& settings,
                                                   std::unique_ptr<drivers::ByteStream> stream, Duration within,
                                                   const Clock* clock) {
  return make_framed_gyro(simulator::slow_to_one_frame_per_second(settings.frame), std::move(stream), within, {},
                          clock);
}

}  // namespace gyrotherm::rig
