// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <numeric>
#include <tuple>

#include "drivers/gyro/frame_format.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr const char* kFrames = "frames";
constexpr const char* kFlagged = "flagged";
constexpr const char* kCelsius = "°C";

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<std::string> list_axes(const FrameFormat& format) {
  std::vector<std::string> axes;
  for (const auto& field : format.fields)
    if (is_gyro(field.role) && !field.axis.empty() && !contains(axes, field.axis)) axes.push_back(field.axis);
  return axes;
}

bool has_axis(const FrameFormat& format, const std::string& axis) {
  return std::any_of(format.fields.begin(), format.fields.end(),
                     [&](const auto& field) { return is_gyro(field.role) && field.axis == axis; });
}

/// Returns the axis to use if none is requested: the file's `axis`, otherwise the first one. The axis of a gyro without
/// axis names has an empty name.
std::vector<std::string> default_axes(const TomlTable& table, const FrameFormat& format) {
  if (table.has("axis")) return {table.text("axis")};
  if (!format.all_axes.empty()) return {format.all_axes.front()};
  return has_axis(format, "") ? std::vector<std::string>{""} : std::vector<std::string>{};
}

void choose_axes(const TomlTable& table, const std::vector<std::string>& wanted, FrameFormat& format) {
  format.all_axes = list_axes(format);
  if (!wanted.empty()) table.ignore("axis");
  for (const auto& axis : wanted.empty() ? default_axes(table, format) : wanted) {
    if (!has_axis(format, axis))
      table.note_error("axis", fmt::format("no gyro field has the axis \"{}\"", axis));
    else if (contains(format.axes, axis))
      table.note_error("axis", fmt::format("the axis \"{}\" is requested twice", axis));
    else
      format.axes.push_back(axis);
  }
  for (auto& field : format.fields) {
    if (!is_gyro(field.role)) continue;
    const auto position = std::find(format.axes.begin(), format.axes.end(), field.axis);
    if (position == format.axes.end()) field.role = FieldRole::other_axis;
    field.slot = static_cast<std::size_t>(position - format.axes.begin());
  }
}

void number_housekeeping(FrameFormat& format) {
  std::vector<std::string> names;
  for (auto& field : format.fields) {
    if (!is_housekeeping(field)) continue;
    const auto position = std::find(names.begin(), names.end(), field.name);
    field.slot = static_cast<std::size_t>(position - names.begin());
    if (position == names.end()) names.push_back(field.name);
  }
}

/// Returns whether the same message can contain both fields, according to their ids.
bool can_share_message(const FrameField& one, const FrameField& other) {
  if (one.ids.empty() || other.ids.empty()) return true;
  return std::any_of(one.ids.begin(), one.ids.end(), [&](auto id) { return is_in_message(other, id); });
}

/// Returns whether a sequence number exists for which both fields are present.
bool can_share_turn(const FrameField& one, const FrameField& other) {
  const auto common = std::gcd(one.every, other.every);
  return one.turn % common == other.turn % common;
}

/// Returns whether both fields can be present at the same time, according to their `when` conditions. Conditions on
/// different integers of a frame are independent.
bool can_share_integer(const FrameField& one, const FrameField& other) {
  const auto where = [](const FrameField& field) {
    return std::tuple(field.offset, field.bytes, field.big_endian, field.bits_per_byte);
  };
  return where(one) != where(other) || ((one.when_value ^ other.when_value) & one.when_mask & other.when_mask) == 0;
}

/// Returns whether the same frame can contain both fields.
bool can_share_frame(const FrameField& one, const FrameField& other) {
  return can_share_message(one, other) && can_share_turn(one, other) && can_share_integer(one, other);
}

/// Returns whether both fields are stored in the same member of a GyroFrame.
bool has_same_slot(const FrameField& one, const FrameField& other) {
  if (is_gyro(one.role)) return is_gyro(other.role) && one.slot == other.slot;
  if (is_housekeeping(one)) return is_housekeeping(other) && one.slot == other.slot;
  return one.role == other.role && (one.role == FieldRole::sequence || one.role == FieldRole::timestamp);
}

/// Returns whether the values of both fields are comparable, because their units, scales, zeros and ranges are equal.
bool has_same_meaning(const FrameField& one, const FrameField& other) {
  const auto meaning = [](const FrameField& field) {
    return std::tuple(field.unit, is_counted(field), field.scale.of(1), field.zero, field.wraps_at,
                      field.role == FieldRole::pulse_count ? field.range : 0);
  };
  return meaning(one) == meaning(other);
}

std::string describe_field(const FrameField& field) {
  return is_housekeeping(field) ? fmt::format("the name \"{}\"", field.name)
                                : fmt::format("the role \"{}\"", keyword_for(kFieldRoles, field.role));
}

/// Compares a field with the fields before it. Notes errors in `table`, the table of the field.
void check_pairs(const TomlTable& table, const FrameFormat& format, const FrameField& field) {
  std::size_t sharing = 1;
  for (const auto* other = format.fields.data(); other != &field; ++other) {
    if (!has_same_slot(*other, field)) continue;
    sharing += can_share_frame(*other, field) ? 1 : 0;
    if (is_housekeeping(field) && (other->unit != field.unit || other->role != field.role))
      table.note_error("", fmt::format("the fields with {} differ in role or unit", describe_field(field)));
    if (is_gyro(field.role) && other->role == field.role && !has_same_meaning(*other, field))
      table.note_error("", fmt::format("the fields of axis \"{}\" differ in type, scale or unit", field.axis));
  }
  if (sharing > 1) table.note_error("", fmt::format("{} fields have {}, expected one", sharing, describe_field(field)));
}

/// Notes an error if there is no axis or if the fields of an axis differ in role.
void check_axes(const TomlTable& table, const FrameFormat& format) {
  const auto gyros = format.gyros();
  const bool has_two_roles = std::any_of(format.fields.begin(), format.fields.end(), [&](const auto& field) {
    return is_gyro(field.role) && gyros[field.slot]->role != field.role;
  });
  if (gyros.empty() || has_two_roles)
    table.note_error(
        "",
        "the frame needs either a field with the role \"pulse_count\" or one with \"increment\", \"rate\" or "
        "\"integrated_angle\"");
  if (format.clocked_by_sequence && (!format.find(FieldRole::sequence) || format.rate_hz <= 0))
    table.note_error("clock", "\"clock\" is \"sequence\", expected a field with that role and \"rate_hz\"");
}

bool is_valid_name(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](unsigned char letter) {
    return letter == '_' || (letter < 0x80 && std::isalnum(letter) != 0);
  });
}

void check_name(const TomlTable& table, const FrameField& field) {
  if (!is_housekeeping(field)) return;
  if (!is_valid_name(field.name))
    table.note_error("name", fmt::format("\"{}\" is not a name, expected letters, digits and \"_\"", field.name));
  if (field.name == kFrames || field.name == kFlagged)
    table.note_error("name", fmt::format("the name \"{}\" is reserved, expected another name", field.name));
  const bool is_celsius = field.unit.empty() || field.unit == "degC" || field.unit == kCelsius;
  if (field.role == FieldRole::temperature && !is_celsius)
    table.note_error("unit", "a scaled temperature must be in °C, expected \"degC\"");
}

/// Returns the first field of each slot, among the fields for which `belongs` returns true.
template <class Belongs>
std::vector<const FrameField*> find_first_per_slot(const std::vector<FrameField>& fields, Belongs belongs) {
  std::vector<const FrameField*> found;
  for (const auto& field : fields) {
    if (!belongs(field)) continue;
    if (field.slot >= found.size()) found.resize(field.slot + 1);
    if (!found[field.slot]) found[field.slot] = &field;
  }
  return found;
}

}  // namespace

const FrameField* FrameFormat::find(FieldRole role) const {
  const auto found = std::find_if(fields.begin(), fields.end(), [&](const auto& field) { return field.role == role; });
  return found == fields.end() ? nullptr : &*found;
}

std::vector<const FrameField*> FrameFormat::gyros() const {
  return find_first_per_slot(fields, [](const FrameField& field) { return is_gyro(field.role); });
}

const FrameField* FrameFormat::gyro() const {
  const auto found = std::find_if(fields.begin(), fields.end(),
                                  [](const auto& field) { return is_gyro(field.role) && field.slot == 0; });
  return found == fields.end() ? nullptr : &*found;
}

std::vector<const FrameField*> FrameFormat::values() const { return find_first_per_slot(fields, is_housekeeping); }

std::vector<HousekeepingValue> list_housekeeping(const FrameFormat& format) {
  std::vector<HousekeepingValue> all;
  for (const auto* field : format.values()) {
    const bool is_temperature = field->role == FieldRole::temperature;
    all.push_back({field->name, is_temperature ? kCelsius : field->unit, is_temperature});
  }
  if (all.empty()) return all;
  all.push_back({kFrames, "1", false});
  all.push_back({kFlagged, "1", false});
  return all;
}

void assign_slots(const TomlTable& table, const std::vector<TomlTable>& fields, const std::vector<std::string>& wanted,
                  FrameFormat& format) {
  choose_axes(table, wanted, format);
  number_housekeeping(format);
  for (std::size_t i = 0; i < format.fields.size(); ++i) {
    check_pairs(fields[i], format, format.fields[i]);
    check_name(fields[i], format.fields[i]);
  }
  check_axes(table, format);
}

}  // namespace gyrotherm::drivers
