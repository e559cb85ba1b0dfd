// SPDX-License-Identifier: Apache-2.0
#include "simulator/chamber_registers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "core/clock.hpp"
#include "core/toml_reader.hpp"
#include "drivers/chamber/expression_example.hpp"
#include "simulator/chamber_limiter.hpp"
#include "simulator/identity_marks.hpp"

namespace gyrotherm::simulator {
namespace {

bool matches_any(const std::vector<drivers::Condition>& conditions, const drivers::RegisterItem& item, double value) {
  return std::ranges::any_of(conditions, [&](const auto& c) { return c.item == item.name && holds(c, value); });
}

/// Reads a value in [simulated] initial.
void read_initial_value(const TomlTable& table, const drivers::RegisterMap& map, SimulatedUnit& unit) {
  const auto name = table.text(drivers::item_key(table));
  const auto* item = drivers::find_named_item(map, table, drivers::item_key(table), name);
  const bool is_text = item != nullptr && item->type == drivers::RegisterType::text;
  if (table.has("text")) {
    if (item != nullptr && !is_text) table.note_error("text", fmt::format("\"{}\" is not a text", name));
    unit.initial_texts.emplace_back(name, table.text("text"));
  } else if (is_text) {
    table.note_error("", fmt::format("\"{}\" is a text, expected \"text\"", name));
    for (const auto* key : {"code", "value"}) table.ignore(key);
  } else if (table.has("code")) {
    const auto code = item ? drivers::find_code(*item, table.text("code")) : std::optional(0.0);
    if (!code) table.note_error("code", drivers::describe_unknown_code(map, *item, table.text("code")));
    unit.initial.emplace_back(name, code.value_or(0));
  } else {
    unit.initial.emplace_back(name, table.number("value"));
  }
}

/// Reads the values that an item shows in the states of the chamber.
void read_shown_register(const TomlTable& table, const drivers::RegisterMap& map, SimulatedUnit& unit) {
  SimulatedUnit::ShownRegister shows{.item = table.text(drivers::item_key(table)), .values = {}};
  const auto* item = drivers::find_named_item(map, table, drivers::item_key(table), shows.item);
  for (const auto* state : {"off", "on", "manual", "running", "ramping", "soaking", "held", "done"}) {
    if (!table.has(state)) continue;
    const bool is_name = item && !item->codes.empty() && table.is_text(state);
    const auto code = is_name ? drivers::find_code(*item, table.text(state)) : table.number(state);
    if (!code) table.note_error(state, drivers::describe_unknown_code(map, *item, table.text(state)));
    shows.values[state] = code.value_or(0);
  }
  unit.shows.push_back(std::move(shows));
}

/// Checks the keys that the text server reads.
void check_text_behaviour(const TomlTable& table, const drivers::RegisterMap& map) {
  const auto check_line = [&](const TomlTable& place, const char* key) {
    const auto line = drivers::to_encoding(place.text(key, ""), map.text_link->encoding);
    if (!line) place.note_error(key, line.error().what);
  };
  check_line(table, "unknown");
  (void)table.duration("lag", Duration{});
  for (const auto& one : table.tables("refuses")) {
    (void)drivers::find_named_item(map, one, "item", one.text("item"));
    (void)one.text("with");
    check_line(one, "with");
  }
  table.ignore("noise");  // has no effect
}

SimulatedUnit parse_unit(const TomlTable& table, const drivers::RegisterMap& map) {
  SimulatedUnit unit;
  const auto conditions = [&](const char* key, std::vector<drivers::Condition>& all) {
    for (const auto& one : table.tables(key)) all.push_back(drivers::read_condition(one, map));
  };
  conditions("turns_on", unit.turns_on);
  conditions("turns_off", unit.turns_off);
  conditions("holds_output", unit.holds_output);
  conditions("starts_program", unit.starts_program);
  conditions("holds_program", unit.holds_program);
  conditions("resumes_program", unit.resumes_program);
  conditions("ends_program", unit.ends_program);
  conditions("creates_program", unit.creates_program);
  conditions("stores_program", unit.stores_program);
  conditions("loads_program", unit.loads_program);
  const auto named_item = [&](const char* key, std::string& name) {
    name = table.text(key, "");
    if (!name.empty()) (void)drivers::find_named_item(map, table, key, name);
  };
  named_item("program_number", unit.program_number);
  named_item("program_step", unit.program_step);
  for (const auto& one : table.tables("shows")) read_shown_register(one, map, unit);
  for (const auto& one : table.tables("initial")) read_initial_value(one, map, unit);
  named_item("limiter_setting", unit.limiter_setting);
  named_item("limiter_reset", unit.limiter_reset);
  named_item("limiter_fault", unit.limiter_fault);
  named_item("limiter_alarm", unit.limiter_alarm);
  unit.when_off = table.texts("sentinel_when_off");
  for (const auto& name : unit.when_off) (void)drivers::find_named_item(map, table, "sentinel_when_off", name);
  if (map.text_link) check_text_behaviour(table, map);
  unit.silent_exceptions = table.boolean("silent_exceptions", false);
  unit.ignores_blocks_elsewhere = table.boolean("ignores_blocks_elsewhere", false);
  return unit;
}

}  // namespace

Result<SimulatedUnit> read_simulated_unit(const drivers::RegisterMap& map, const std::string& file) {
  const auto parsed = TomlTable::parse(map.text, file);
  if (!parsed) return failure(parsed.error());
  for (const auto& key : parsed->keys())
    if (key != "simulated") parsed->ignore(key);
  auto unit = parse_unit(parsed->table("simulated"), map);
  if (auto verdict = parsed->verdict(); !verdict) return failure(std::move(verdict.error()));
  return unit;
}

Result<void> check_simulated_identity(const drivers::RegisterMap& map, const SimulatedUnit& unit,
                                      const std::string& file) {
  if (!map.identity || map.identity->pattern.empty()) return {};
  const auto& print = *map.identity;
  const auto stated =
      std::ranges::find(unit.initial_texts, print.item, &decltype(unit.initial_texts)::value_type::first);
  const bool is_stated = stated != unit.initial_texts.end();
  if (is_stated ? drivers::fits(print, stated->second) : drivers::make_example(print).has_value()) return {};
  return failure(FaultKind::bad_file, file,
                 is_stated
                     ? fmt::format("[simulated] initial: the text \"{}\" of \"{}\" does not fit the pattern \"{}\"",
                                   stated->second, print.item, print.pattern)
                     : fmt::format("[simulated] initial needs a text of \"{}\" that fits the pattern \"{}\"",
                                   print.item, print.pattern));
}

RegisterImage::RegisterImage(const drivers::RegisterMap& map, const SimulatedUnit& unit) : map_(map) {
  if (map.identity && map.identity->pattern.empty()) set_value(*map.find(map.identity->item), map.identity->value);
  for (const auto& [name, value] : unit.initial) set_value(*map.find(name), value);
  const auto set_text = [this](const drivers::RegisterItem& item, std::string_view text) {
    const auto words = encode_text(item.text, text);
    for (std::size_t i = 0; i < words.size(); ++i) words_[image_address(item) + static_cast<int>(i)] = words[i];
  };
  for (const auto& [name, text] : unit.initial_texts) set_text(*map.find(name), text);
  const auto is_set = [&](const std::string& name) {
    return std::ranges::any_of(unit.initial_texts, [&](const auto& one) { return one.first == name; });
  };
  const auto set_example = [&](const std::string& name, const std::string& pattern) {
    if (!pattern.empty() && !is_set(name)) set_text(*map.find(name), drivers::make_example(pattern));
  };
  if (map.identity && !map.identity->pattern.empty() && !is_set(map.identity->item))
    set_text(*map.find(map.identity->item), drivers::make_example(*map.identity).value_or(""));
  for (const auto& setting : map.verification.settings) set_example(setting.item, setting.pattern);
}

MemoryImage::MemoryImage(const drivers::RegisterMap& map, RegisterImage& registers) : map_(map), registers_(registers) {
  if (!map.memory) return;
  const auto& memory = *map.memory;
  const auto add = [&](const drivers::MemoryBlock& block, int steps, bool windowed) {
    ranges_.push_back({block.address, block.address + (steps - 1) * memory.stride + block.count - 1, windowed});
  };
  for (const auto& block : memory.header) add(block, 1, false);
  for (const auto& block : memory.footer) add(block, 1, false);
  const bool window = memory.stride == 0;
  for (const auto& block : memory.step) {
    const bool edits =
        std::ranges::any_of(block.cells, [](const auto& c) { return c.source == drivers::CellSource::step; });
    add(block, memory.steps_at_most, window && !edits);
    if (window && block.select) step_selector_ = block.address;
    for (const auto& cell : block.cells)
      if (window && cell.source == drivers::CellSource::kind)
        if (const auto end = cell.form.codes.find("end"); end != cell.form.codes.end())
          fresh_[block.address + cell.at] = static_cast<std::uint16_t>(end->second.front());
  }
}

ChamberRegisters::ChamberRegisters(drivers::RegisterMap map, VirtualLaboratory& laboratory, bool is_marked)
    : map_(std::move(map)),
      unit_(read_simulated_unit(map_, map_.name).value()),
      laboratory_(laboratory),
      image_(map_, is_marked ? mark_identity(unit_, map_) : unit_),
      memory_(map_, image_) {
  find_live_items();
  find_addresses();
  if (const auto* setting = map_.find(unit_.limiter_setting)) laboratory_.limiter().set(image_.value(*setting));
  if (unit_.turns_on.empty() && !map_.control) laboratory_.switch_on(true);
}

void ChamberRegisters::find_live_items() {
  const auto& unit = unit_;
  for (const auto& item : map_.items) {
    const auto add = [&](Role role, const SimulatedUnit::ShownRegister* shows = nullptr) {
      live_.push_back({&item, role, shows});
    };
    const auto shows = std::ranges::find_if(unit.shows, [&](const auto& one) { return one.item == item.name; });
    const bool is_mode = map_.control && (item.name == map_.control->commanded || item.name == map_.control->active);
    if (item.name == "air_temperature") add(Role::air);
    if (item.name == "humidity") add(Role::humidity);
    if (item.name == "dew_point") add(Role::dew_point);
    if (item.name == "set_point" || item.name == "active_set_point" || item.name == "working_set_point")
      add(Role::set_point);
    if (item.name == "output") add(Role::output);
    if (item.name == unit.limiter_alarm) add(Role::limiter_alarm);
    if (item.type == drivers::RegisterType::date_time && item.readable) add(Role::clock);
    if (shows != unit.shows.end())
      add(Role::shows, &*shows);
    else if (is_mode)
      add(Role::mode);
    if (std::ranges::find(unit.when_off, item.name) != unit.when_off.end() && !item.sentinels.empty())
      add(Role::sentinel);
  }
}

void ChamberRegisters::find_addresses() {
  hole_begin_ = kCoils;
  for (const auto& item : map_.items) {
    const int first = image_address(item), count = word_count(item);
    for (int i = 0; i < std::max<int>(count, item.read_count); ++i) served_[first + i] = true;
    const bool in_block = item.name == "air_temperature" || item.name == "set_point" ||
                          (map_.identity && item.name == map_.identity->item);
    const bool counts = first < kCoils && (map_.holes || (map_.one_block && in_block));
    if (!counts) continue;
    hole_begin_ = std::min(hole_begin_, first);
    hole_end_ = std::max(hole_end_, first + count);
  }
  // If a map permits reading holes, the driver reads whole chunks from the first register on.
  if (map_.holes) hole_begin_ = 0;
}

bool ChamberRegisters::serves(int address) const {
  return (address >= hole_begin_ && address < hole_end_) || served_.contains(address) || memory_.contains(address);
}

double ChamberRegisters::shown_value(const SimulatedUnit::ShownRegister& shows) const {
  const auto state = [&]() -> std::string {
    switch (run_.stage()) {
      case ProgramRun::Stage::ramping: return "ramping";
      case ProgramRun::Stage::soaking: return "soaking";
      case ProgramRun::Stage::held: return "held";
      case ProgramRun::Stage::done: return "done";
      case ProgramRun::Stage::none: break;
    }
    return !laboratory_.is_on() ? "off" : laboratory_.holds_output() ? "manual" : "on";
  }();
  auto found = shows.values.find(laboratory_.holds_output() && laboratory_.is_on() ? "manual" : state);
  if (found == shows.values.end()) found = shows.values.find(state);
  if (found == shows.values.end() && run_.is_running()) found = shows.values.find("running");
  if (found == shows.values.end()) found = shows.values.find(laboratory_.is_on() ? "on" : "off");
  return found == shows.values.end() ? 0 : found->second;
}

std::vector<std::uint16_t> ChamberRegisters::live_words(const LiveItem& live) const {
  const auto& item = *live.item;
  switch (live.role) {
    case Role::air: return image_.words_at(item, laboratory_.air_as_measured().value);
    case Role::humidity: return image_.words_at(item, laboratory_.humidity_percent());
    case Role::dew_point: return image_.words_at(item, laboratory_.dew_point().value);
    case Role::set_point: return image_.words_at(item, laboratory_.set_point().value);
    case Role::output: return image_.words_at(item, laboratory_.output_percent());
    case Role::mode: {
      if (laboratory_.is_on() && laboratory_.holds_output())
        return image_.words(image_address(item), word_count(item));  // the written value
      const auto code = laboratory_.is_on() ? map_.control->on : map_.control->off;
      return image_.words_at(item, static_cast<double>(code));
    }
    case Role::clock:
      return encode_date(item.date, drivers::to_civil_time(kVirtualEpoch + std::chrono::seconds(seconds_)));
    case Role::shows: return image_.words_at(item, shown_value(*live.shows));
    case Role::limiter_alarm: return image_.words_at(item, laboratory_.limiter().shows_alarm() ? 1 : 0);
    case Role::sentinel: break;
  }
  auto raw = item;
  raw.scale = 1;
  raw.offset = 0;
  return encode_as_read(raw, item.sentinels.begin()->second);
}

tl::expected<void, ModbusException> ChamberRegisters::read(drivers::ReadFunction function, std::uint16_t address,
                                                           std::uint16_t count,
                                                           std::vector<std::uint16_t>& words) const {
  if (count == 0 || count > map_.link.modbus.read_at_most) return tl::unexpected(ModbusException::illegal_value);
  const bool coils = function == drivers::ReadFunction::coils || function == drivers::ReadFunction::discrete_inputs;
  const int first = address + (coils ? kCoils : 0), end = first + count;
  const auto base = words.size();
  for (int at = first; at < end; ++at) {
    if (!serves(at)) return tl::unexpected(ModbusException::illegal_address);
    words.push_back(memory_.contains(at) ? memory_.word(at) : image_.word(at));
  }
  for (const auto& live : live_) {
    const int from = image_address(*live.item), to = from + word_count(*live.item);
    if (to <= first || from >= end || !live.item->readable) continue;
    if (live.role == Role::sentinel && laboratory_.is_on()) continue;
    const auto own = live_words(live);
    for (int at = std::max(from, first); at < std::min(to, end); ++at)
      words[base + static_cast<std::size_t>(at - first)] = own[static_cast<std::size_t>(at - from)];
  }
  return {};
}

bool ChamberRegisters::accepts(const drivers::RegisterItem& item, double value) const {
  if (!std::isfinite(value)) return false;
  if (item.name == "set_point") return laboratory_.accepts({value});
  if (item.codes.empty() || !item.otherwise.empty() || item.type == drivers::RegisterType::bits) return true;
  return std::ranges::any_of(item.codes, [&](const auto& entry) {
    return std::ranges::any_of(entry.second, [&](auto code) { return static_cast<double>(code) == value; });
  });
}

/// Returns the target of the words from `address` on: an item, or one word of the profile memory.
tl::expected<ChamberRegisters::Assignment, ModbusException> ChamberRegisters::assignment(
    int address, std::span<const std::uint16_t> words, bool coil) const {
  for (const auto& item : map_.items) {
    const std::size_t count = word_count(item);
    const int from = image_address(item);
    if (!item.writable || from != address || coil != (from >= kCoils)) continue;
    if (words.size() < count) return tl::unexpected(ModbusException::illegal_address);
    Assignment made{.item = &item, .address = from, .words = {words.begin(), words.begin() + count}};
    if (item.type == drivers::RegisterType::text || item.type == drivers::RegisterType::date_time) return made;
    made.value = decode_as_written(image_.item_in_context(item), made.words);
    if (!accepts(item, made.value)) return tl::unexpected(ModbusException::illegal_value);
    return made;
  }
  if (!memory_.contains(address)) return tl::unexpected(ModbusException::illegal_address);
  return Assignment{.item = nullptr, .address = address, .words = {words.front()}};
}

tl::expected<void, ModbusException> ChamberRegisters::write(drivers::WriteFunction function, std::uint16_t address,
                                                            std::span<const std::uint16_t> words) {
  const bool coil = function == drivers::WriteFunction::coil;
  if (unit_.ignores_blocks_elsewhere && function == drivers::WriteFunction::registers && !memory_.contains(address))
    return {};
  if (words.size() > map_.link.modbus.write_at_most) return tl::unexpected(ModbusException::illegal_value);
  std::vector<Assignment> assignments;
  for (std::size_t done = 0; done < words.size();) {
    const int at = address + static_cast<int>(done) + (coil ? kCoils : 0);
    auto made = assignment(at, words.subspan(done), coil);
    if (!made) return tl::unexpected(made.error());
    done += made->words.size();
    assignments.push_back(std::move(*made));
  }
  for (const auto& assignment : assignments) apply(assignment);
  return {};
}

void ChamberRegisters::apply(const Assignment& assignment) {
  for (std::size_t i = 0; i < assignment.words.size(); ++i) {
    const int at = assignment.address + static_cast<int>(i);
    if (memory_.contains(at)) memory_.set_word(at, assignment.words[i]);
    if (assignment.item && !assignment.item->self_clearing) image_.set_word(at, assignment.words[i]);
  }
  if (assignment.item) apply_effects(*assignment.item, assignment.value);
}

void ChamberRegisters::apply_effects(const drivers::RegisterItem& item, double value) {
  const auto& unit = unit_;
  if (item.name == "set_point") laboratory_.change_set_point({value});
  apply_to_limiter(item, value);
  if (item.self_clearing && (item.name == unit.program_number || item.name == unit.program_step))
    image_.set_value(item, value);
  const bool manual = matches_any(unit.holds_output, item, value);
  if (unit.turns_on.empty() && map_.control && item.name == map_.control->commanded)
    laboratory_.switch_on(manual || value == static_cast<double>(map_.control->on));
  if (manual || matches_any(unit.turns_on, item, value) || matches_any(unit.turns_off, item, value) ||
      (map_.control && item.name == map_.control->commanded))
    laboratory_.hold_output(manual ? std::optional(1.0) : std::nullopt);
  if (matches_any(unit.turns_on, item, value)) laboratory_.switch_on(true);
  if (matches_any(unit.turns_off, item, value)) {
    laboratory_.switch_on(false);
    run_.end();
  }
  if (matches_any(unit.creates_program, item, value)) memory_.clear();
  if (matches_any(unit.stores_program, item, value)) memory_.store();
  if (matches_any(unit.loads_program, item, value)) memory_.load();
  if (matches_any(unit.holds_program, item, value)) run_.hold();
  if (matches_any(unit.ends_program, item, value)) run_.end();
  const bool resumes = matches_any(unit.resumes_program, item, value);
  const bool starts = matches_any(unit.starts_program, item, value);
  if (resumes || (starts && run_.stage() == ProgramRun::Stage::held))
    run_.resume();
  else if (starts)
    start_program();
}

void ChamberRegisters::apply_to_limiter(const drivers::RegisterItem& item, double value) {
  auto& limiter = laboratory_.limiter();
  if (item.name == unit_.limiter_setting) limiter.set(value);
  if (item.name == unit_.limiter_reset) limiter.reset();
  if (item.name == unit_.limiter_fault) limiter.inject(static_cast<LimiterFault>(static_cast<int>(value)));
}

void ChamberRegisters::start_program() {
  auto program = memory_.program(laboratory_.set_point());
  if (!program) return;
  const auto* step = map_.find(unit_.program_step);
  const int first = step ? static_cast<int>(image_.value(*step)) - map_.memory->first_step : 0;
  laboratory_.switch_on(true);
  run_.start(std::move(*program), first);
}

void ChamberRegisters::advance_second() {
  ++seconds_;
  if (!run_.is_running()) return;
  const auto set_point = run_.next_set_point(laboratory_.air_as_measured());
  if (laboratory_.accepts(set_point)) laboratory_.change_set_point(set_point);
}

}  // namespace gyrotherm::simulator
