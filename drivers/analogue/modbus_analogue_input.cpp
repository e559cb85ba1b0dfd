// SPDX-License-Identifier: Apache-2.0
#include "drivers/analogue/modbus_analogue_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <string_view>
#include <utility>

#include "core/toml_reader.hpp"
#include "drivers/chamber/item_exchange.hpp"
#include "drivers/chamber/status_turns.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr std::size_t kMaxInputs = 256;

/// Returns the item `name`, or the items "name_1", "name_2", … made by `count`. If there is none, notes an error.
std::vector<const RegisterItem*> find_items(const RegisterMap& map, const TomlTable& table, const char* key,
                                            const std::string& name) {
  if (const auto* one = map.find(name)) return {one};
  std::vector<const RegisterItem*> all;
  while (const auto* next = map.find(fmt::format("{}_{}", name, all.size() + 1))) all.push_back(next);
  if (all.empty()) (void)find_named_item(map, table, key, name);
  return all;
}

void check_number(const TomlTable& table, const char* key, const RegisterItem& item) {
  if (!item.readable) table.note_error(key, fmt::format("register \"{}\" cannot be read", item.name));
  if (item.type == RegisterType::text || item.type == RegisterType::date_time)
    table.note_error(key, fmt::format("register \"{}\" is not a number", item.name));
}

/// Reads one name or a list of names; an empty list if the key is missing.
std::vector<std::string> read_names(const TomlTable& table, const char* key) {
  if (!table.has(key)) return {};
  if (table.is_list(key)) return table.texts(key);
  return {table.text(key)};
}

/// Assigns the status registers `status` to the inputs from index `first`, one to each.
void add_status(const TomlTable& table, const std::string& status, std::size_t first, AnalogueMap& map) {
  const auto states = find_items(map.registers, table, "status", status);
  const auto inputs = map.inputs.size() - first;
  if (!states.empty() && states.size() != inputs)
    table.note_error("status", fmt::format("{} status registers for {} inputs", states.size(), inputs));
  for (std::size_t i = 0; i < std::min(states.size(), inputs); ++i) {
    const auto& state = *states[i];
    check_number(table, "status", state);
    if (!state.codes.contains(kNormalStatus))
      table.note_error("status", fmt::format("register \"{}\" has no code named \"{}\"", state.name, kNormalStatus));
    map.inputs[first + i].statuses.push_back(state.name);
  }
}

void add_inputs(const TomlTable& table, AnalogueMap& map) {
  const auto values = find_items(map.registers, table, "register", table.text("register"));
  const auto unit = table.text("unit");
  if (unit.empty()) table.note_error("unit", "expected the unit of measure, such as \"mA\"");
  const auto first = map.inputs.size();
  for (const auto* value : values) {
    check_number(table, "register", *value);
    map.inputs.push_back({.item = value->name, .unit = unit, .statuses = {}});
  }
  for (const auto& status : read_names(table, "status")) add_status(table, status, first, map);
}

}  // namespace

Result<AnalogueMap> parse_analogue_map(std::string_view text, const std::string& file,
                                       std::optional<WordOrder> word_order) {
  const auto parsed = TomlTable::parse(text, file);
  if (!parsed) return failure(parsed.error());
  AnalogueMap map;
  map.registers.text = text;
  (void)parsed->choice("schema", {"gyrotherm-analogue-inputs/1"});
  read_unit(*parsed, word_order, map.registers);
  for (const auto& table : parsed->tables("input")) add_inputs(table, map);
  if (map.inputs.empty()) parsed->note_error("", "missing [[input]], expected at least one");
  if (map.inputs.size() > kMaxInputs)
    parsed->note_error("input", fmt::format("{} inputs, expected at most {}", map.inputs.size(), kMaxInputs));
  if (auto verdict = parsed->verdict(); !verdict) return failure(std::move(verdict.error()));
  const auto usual = map.registers.links.front().kind;
  auto linked = select_link(std::move(map.registers), usual);
  if (!linked) return failure(std::move(linked.error()));
  map.registers = std::move(*linked);
  return map;
}

std::string describe_confidence(const AnalogueMap& map) {
  auto least_confidence = Confidence::verified;
  std::vector<std::string> notes;
  const auto add_item = [&](const std::string& name) {
    const auto* item = map.registers.find(name);
    if (!item) return;
    least_confidence = std::max(least_confidence, item->confidence);
    if (!item->note.empty() && std::ranges::count(notes, item->note) == 0) notes.push_back(item->note);
  };
  for (const auto& input : map.inputs) {
    add_item(input.item);
    for (const auto& status : input.statuses) add_item(status);
  }
  return fmt::format("{} inputs: {}{}{}", map.inputs.size(), name(least_confidence), notes.empty() ? "" : "; ",
                     fmt::join(notes, "; "));
}

namespace {

/// Maximum duration of a reading. The caller does not wait longer.
constexpr Duration kReadingTimeLimit = std::chrono::milliseconds(900);

/// Joins adjacent spans up to a length of `at_most`.
std::vector<ReadSpan> join_spans(const std::vector<ReadSpan>& spans, std::uint16_t at_most) {
  std::vector<ReadSpan> all;
  for (const auto& span : spans) {
    const bool follows =
        !all.empty() && all.back().function == span.function && all.back().first + all.back().count == span.first;
    if (follows && all.back().count + span.count <= at_most)
      all.back().count = static_cast<std::uint16_t>(all.back().count + span.count);
    else
      all.push_back(span);
  }
  return all;
}

bool covers(const ReadSpan& span, const RegisterItem& item) {
  return span.function == read_function(item) && item.address >= span.first &&
         item.address + word_count(item) <= span.first + span.count;
}

class ModbusAnalogueInputs final : public AnalogueInputs {
 public:
  ModbusAnalogueInputs(AnalogueMap map, std::vector<std::size_t> wanted, std::string place,
                       std::unique_ptr<Registers> registers, std::unique_ptr<Pauses> pauses)
      : map_(std::move(map)),
        wanted_(std::move(wanted)),
        place_(std::move(place)),
        registers_(std::move(registers)),
        pauses_(std::move(pauses)),
        items_(map_.registers, *registers_, *pauses_) {
    assert(!wanted_.empty());
    plan_ = plan_spans();
  }

  std::uint64_t breaks() const override { return registers_->breaks(); }

  Result<std::string> identify() override {
    auto found = items_.identify(items_.item(input(wanted_.front()).item));
    if (!found) return failure(locate_fault(std::move(found.error())));
    return std::move(found->who);
  }

  std::vector<Result<double>> read() override {
    const auto began = pauses_->now();
    Snapshot found;
    std::vector<std::pair<ReadSpan, Fault>> failed;
    bool silent = false;
    for (const auto& span : plan_) {
      if (silent) {
        failed.emplace_back(span, failed.back().second);
        continue;
      }
      if (pauses_->now() - began >= kReadingTimeLimit) {
        failed.emplace_back(span, Fault{FaultKind::timeout, place_, "the line is too slow for one reading per second"});
        silent = true;
        continue;
      }
      auto words = registers_->read(span.function, span.first, span.count);
      if (words) {
        found.add(span, std::move(*words));
        continue;
      }
      const auto kind = words.error().kind;
      silent = kind != FaultKind::refused && kind != FaultKind::out_of_range;
      failed.emplace_back(span, std::move(words.error()));
    }
    std::vector<Result<double>> values;
    for (const auto wanted : wanted_) values.push_back(read_value(input(wanted), found, failed));
    return values;
  }

 private:
  [[nodiscard]] const AnalogueInput& input(std::size_t index) const { return map_.inputs.at(index); }

  /// Returns the registers of an input, and the registers for their decimals and units.
  [[nodiscard]] std::vector<const RegisterItem*> find_input_items(const AnalogueInput& input) const {
    std::vector<const RegisterItem*> items{&items_.item(input.item)};
    for (const auto& status : input.statuses) items.push_back(&items_.item(status));
    const auto context = items_.find_context_items(items);
    items.insert(items.end(), context.begin(), context.end());
    return items;
  }

  [[nodiscard]] std::vector<ReadSpan> plan_spans() const {
    std::vector<const RegisterItem*> all, wanted;
    const auto add = [&](std::vector<const RegisterItem*>& to, const AnalogueInput& input) {
      const auto items = find_input_items(input);
      to.insert(to.end(), items.begin(), items.end());
    };
    for (const auto& input : map_.inputs) add(all, input);
    for (const auto index : wanted_) add(wanted, input(index));
    const auto at_most = map_.registers.link.modbus.read_at_most;
    auto spans = join_spans(plan_reads(all, map_.registers.holes, at_most), at_most);
    std::erase_if(spans, [&](const auto& span) {
      return std::ranges::none_of(wanted, [&](const auto* item) { return covers(span, *item); });
    });
    return spans;
  }

  [[nodiscard]] Result<double> read_value(const AnalogueInput& input, const Snapshot& found,
                                          const std::vector<std::pair<ReadSpan, Fault>>& failed) const {
    for (const auto* item : find_input_items(input))
      for (const auto& [span, fault] : failed)
        if (covers(span, *item)) return failure(fault);
    for (const auto& name : input.statuses) {
      const auto& status = items_.item(name);
      const auto code = items_.value_in(found, status);
      if (!code) return failure(locate_fault(code.error()));
      if (const auto word = meaning(status, *code); word != kNormalStatus)
        return failure(locate_fault({FaultKind::out_of_range, gyrotherm::drivers::place(status), word}));
    }
    auto value = items_.value_in(found, items_.item(input.item));
    return value ? value : failure(locate_fault(std::move(value.error())));
  }

  /// Replaces "chamber" in the location of an item's fault by this unit's name.
  [[nodiscard]] Fault locate_fault(Fault fault) const {
    constexpr std::string_view kChamber = "chamber ";
    if (fault.where.starts_with(kChamber)) fault.where = place_ + " " + fault.where.substr(kChamber.size());
    return fault;
  }

  AnalogueMap map_;
  std::vector<std::size_t> wanted_;
  std::string place_;
  std::unique_ptr<Registers> registers_;
  std::unique_ptr<Pauses> pauses_;
  ItemExchange items_;
  std::vector<ReadSpan> plan_;
};

}  // namespace

std::unique_ptr<AnalogueInputs> make_modbus_analogue_inputs(AnalogueMap map, std::vector<std::size_t> wanted,
                                                            std::string place, std::unique_ptr<Registers> registers,
                                                            std::unique_ptr<Pauses> pauses) {
  return std::make_unique<ModbusAnalogueInputs>(std::move(map), std::move(wanted), std::move(place),
                                                std::move(registers), std::move(pauses));
}

}  // namespace gyrotherm::drivers
