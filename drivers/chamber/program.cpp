// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/program.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <utility>

#include "drivers/chamber/item_exchange.hpp"

namespace gyrotherm::drivers {
namespace {

using std::chrono::hours;
using std::chrono::minutes;
using std::chrono::seconds;

tl::unexpected<Fault> step_fault(std::size_t step, std::string what) {
  return failure(FaultKind::out_of_range, fmt::format("step {} of the program", step + 1), std::move(what));
}

bool has_guaranteed_soak(const ProfileMemory& memory) {
  return std::ranges::any_of(memory.step, [](const auto& block) {
    return std::ranges::any_of(block.cells,
                               [](const auto& cell) { return cell.source == CellSource::guaranteed_soak; });
  });
}

/// Splits a step into parts that the memory can store. The duration of each part is a multiple of the memory's
/// resolution, and does not exceed its longest step.
void append_parts(const ProfileMemory& memory, const ProgramStep& step, std::vector<ProgramStep>& parts) {
  const auto longest = memory.longest_step / memory.finest * memory.finest;
  const auto count = std::max<std::int64_t>(1, (step.duration + longest - Duration(1)) / longest);
  const auto change = step.target - step.start;
  Duration done{};
  for (std::int64_t i = 1; i <= count; ++i) {
    const auto until = i == count ? step.duration : step.duration * i / count / memory.finest * memory.finest;
    const auto at = [&](Duration time) {
      return step.start + change * (step.duration > Duration{} ? to_seconds(time) / to_seconds(step.duration) : 1);
    };
    auto part = step;
    part.start = done == Duration{} ? step.start : at(done);
    part.target = i == count ? step.target : at(until);
    part.duration = until - done;
    parts.push_back(part);
    done = until;
  }
}

double code(const MemoryCell& cell, const char* meaning) {
  const auto found = cell.form.codes.find(meaning);
  return found == cell.form.codes.end() ? 0 : static_cast<double>(found->second.front());
}

/// Returns the rate of a step in K/min. An end step without a duration has the rate 0.
double rate(const ProgramStep& step) {
  if (step.duration <= Duration{}) return 0;
  return std::abs((step.target - step.start).value) / (to_seconds(step.duration) / 60);
}

const char* keyword(StepKind kind) { return keyword_for(kStepKinds, kind); }

RegisterItem cell_form(const MemoryCell& cell, const ContextOf& read_context) {
  return read_context && !(cell.form.decimals.empty() && cell.form.unit.empty())
             ? apply_context(cell.form, read_context(cell.form))
             : cell.form;
}

/// Computes the contents of the memory for a program.
struct Content {
  const ProfileMemory& memory;
  const ChamberProgram& program;
  const std::vector<ProgramStep>& steps;
  const ContextOf& read_context;

  [[nodiscard]] double value(const MemoryCell& cell, int index) const {
    const ProgramStep none;
    const auto& step = index < 0 ? none : steps[static_cast<std::size_t>(index)];
    switch (cell.source) {
      case CellSource::constant: return cell.constant;
      case CellSource::name: return 0;
      case CellSource::number: return program.number;
      case CellSource::step_count: return static_cast<double>(steps.size());
      case CellSource::step: return index + memory.first_step;
      case CellSource::kind: return code(cell, keyword(step.kind));
      // The header may contain the start of the first step.
      case CellSource::start: return index < 0 ? steps.front().start.value : step.start.value;
      case CellSource::target: return step.target.value;
      case CellSource::rate: return rate(step);
      case CellSource::hours: return static_cast<double>(step.duration / hours(1));
      case CellSource::minutes: return static_cast<double>(step.duration / minutes(1) % 60);
      case CellSource::seconds: return static_cast<double>(step.duration / seconds(1) % 60);
      case CellSource::total_seconds: return static_cast<double>(step.duration / seconds(1));
      case CellSource::guaranteed_soak: return code(cell, step.guaranteed_soak ? "on" : "off");
      case CellSource::soak_band: return program.soak_band.value;
    }
    return 0;
  }

  [[nodiscard]] Result<std::vector<std::uint16_t>> words(const MemoryBlock& block, int index) const {
    std::vector<std::uint16_t> all(block.count);
    for (const auto& cell : block.cells) {
      const auto form = cell_form(cell, read_context);
      std::vector<std::uint16_t> own;
      if (cell.source == CellSource::name) {
        own = encode_text(form.text, program.name);
      } else {
        const double wanted = value(cell, index);
        own = encode(form, wanted);
        if (!(std::abs(decode_as_written(form, own) - wanted) <= form.resolution))
          return step_fault(static_cast<std::size_t>(std::max(index, 0)),
                            fmt::format("register {} cannot hold {:g}", block.address + cell.at, wanted));
      }
      for (std::size_t i = 0; i < own.size(); ++i) all[cell.at + i] |= own[i];
    }
    return all;
  }
};

bool is_written_for(const MemoryBlock& block, StepKind kind) {
  return block.kinds.empty() || std::ranges::find(block.kinds, kind) != block.kinds.end();
}

/// Values found in the cells of one step.
struct StoredStep {
  std::optional<double> start, target, hours, minutes, seconds, total;
  std::string kind;
  bool guaranteed_soak{};

  [[nodiscard]] Duration duration() const {
    if (total) return from_seconds(*total);
    return from_seconds(hours.value_or(0) * 3600 + minutes.value_or(0) * 60 + seconds.value_or(0));
  }
};

void store_cell(const MemoryCell& cell, const RegisterItem& form, double value, StoredStep& step) {
  switch (cell.source) {
    case CellSource::kind: step.kind = meaning(form, value); return;
    case CellSource::start: step.start = value; return;
    case CellSource::target: step.target = value; return;
    case CellSource::hours: step.hours = value; return;
    case CellSource::minutes: step.minutes = value; return;
    case CellSource::seconds: step.seconds = value; return;
    case CellSource::total_seconds: step.total = value; return;
    case CellSource::guaranteed_soak: step.guaranteed_soak = value == code(cell, "on"); return;
    default: return;
  }
}

/// Calls `take_cell` for each cell of a block with its words.
template <class Take>
Result<void> for_each_cell(const MemoryBlock& block, const Result<std::vector<std::uint16_t>>& words,
                           const ContextOf& context, Take take_cell) {
  if (!words) return failure(words.error());
  if (words->size() < block.count) return failure(FaultKind::corrupted, "profile memory", "a block is too short");
  for (const auto& cell : block.cells) {
    const auto form = cell_form(cell, context);
    const auto own = std::span(*words).subspan(cell.at, word_count(form));
    take_cell(cell, form, own);
  }
  return {};
}

/// Returns whether a step of that kind, or of an unknown kind, has this block.
bool applies_to_kind(const MemoryBlock& block, const std::string& kind) {
  return kind.empty() || block.kinds.empty() ||
         std::ranges::any_of(block.kinds, [&](auto one) { return kind == keyword(one); });
}

Result<StoredStep> read_step(const ProfileMemory& memory, int index, const BlockWords& words_of,
                             const ContextOf& context) {
  StoredStep found;
  for (const auto& block : memory.step) {
    if (block.select || !applies_to_kind(block, found.kind)) continue;
    const auto taken =
        for_each_cell(block, words_of(block, index), context, [&](const auto& cell, const auto& form, auto own) {
          if (cell.source != CellSource::name) store_cell(cell, form, decode_as_written(form, own), found);
        });
    if (!taken) return failure(taken.error());
    if (found.kind == keyword(StepKind::end) && !found.start) break;
  }
  return found;
}

/// Converts a number of steps from the memory. A value that is not a number of steps is that of a full memory.
int read_step_count(double stored, const ProfileMemory& memory) {
  const bool is_count = stored >= 0 && stored <= memory.steps_at_most;
  return is_count ? static_cast<int>(stored) : stored < 0 ? 0 : memory.steps_at_most;
}

/// Contents of the header's cells.
struct StoredHeader {
  std::string name;
  Kelvins soak_band{};
  std::optional<double> start{};  ///< temperature at which the first step starts
  int step_count{};               ///< steps_at_most if no cell contains it
};

Result<StoredHeader> read_header(const ProfileMemory& memory, const BlockWords& words_of, const ContextOf& context) {
  StoredHeader found{.name = {}, .step_count = memory.steps_at_most};
  const auto read_block = [&](const MemoryBlock& block, bool is_header) {
    return for_each_cell(block, words_of(block, -1), context, [&](const auto& cell, const auto& form, auto own) {
      if (cell.source == CellSource::start) found.start = decode_as_written(form, own);
      if (!is_header) return;
      if (cell.source == CellSource::name) found.name = decode_text(form.text, own);
      if (cell.source == CellSource::soak_band) found.soak_band = {decode_as_written(form, own)};
      if (cell.source == CellSource::step_count)
        found.step_count = read_step_count(decode_as_written(form, own), memory);
    });
  };
  for (const auto& block : memory.header)
    if (const auto taken = block.select ? Result<void>{} : read_block(block, true); !taken)
      return failure(taken.error());
  const auto has_start = [](const MemoryBlock& block) {
    return std::ranges::any_of(block.cells, [](const auto& cell) { return cell.source == CellSource::start; });
  };
  for (const auto& block : memory.footer)
    if (const auto taken = has_start(block) ? read_block(block, false) : Result<void>{}; !taken)
      return failure(taken.error());
  return found;
}

/// Returns whether the step is an end step, in a memory that stores no start set points.
bool is_end_mark(const StoredStep& found) { return !found.start && found.kind == keyword(StepKind::end); }

/// Makes a step from its cells. `before` is the set point after the previous step. The kind is the content of the kind
/// cell, where an end becomes a soak; without a kind cell it follows from the set points. Fails with corrupted for an
/// unknown kind.
Result<ProgramStep> make_step(const StoredStep& found, Celsius before, int index) {
  ProgramStep step;
  step.start = found.start ? Celsius{*found.start} : before;
  step.target = found.target ? Celsius{*found.target} : step.start;
  step.duration = found.duration();
  step.guaranteed_soak = found.guaranteed_soak;
  step.kind = step.target == step.start ? StepKind::soak : StepKind::ramp;
  if (found.kind.empty()) return step;
  const bool is_ramp = found.kind == keyword(StepKind::ramp);
  if (!is_ramp && found.kind != keyword(StepKind::soak) && found.kind != keyword(StepKind::end))
    return failure(FaultKind::corrupted, fmt::format("step {} of the program", index + 1),
                   "has the unknown kind " + found.kind);
  step.kind = is_ramp ? StepKind::ramp : StepKind::soak;
  return step;
}

/// Sets the target of each ramp to the start of the next step, for a memory that stores only starts.
void set_ramp_targets(std::vector<ProgramStep>& steps) {
  for (std::size_t i = 0; i + 1 < steps.size(); ++i)
    if (steps[i].kind == StepKind::ramp) steps[i].target = steps[i + 1].start;
}

std::string describe_location(const RegisterMap& map, const MemoryWrite& write) {
  if (map.text_link) return write.step < 0 ? "profile memory" : fmt::format("profile memory, step {}", write.step + 1);
  return write.step < 0 ? fmt::format("profile memory, register {}", write.address)
                        : fmt::format("profile memory, register {}, step {}", write.address, write.step + 1);
}

using ContextNames = std::pair<std::string, std::string>;  ///< items with decimals and unit

class Upload {
 public:
  Upload(const RegisterMap& map, ItemExchange& items, Registers& registers, Pauses& pauses)
      : map_(map), memory_(*map.memory), items_(items), registers_(registers), pauses_(pauses) {}

  [[nodiscard]] Result<void> read_contexts() {
    for (const auto* blocks : {&memory_.header, &memory_.step, &memory_.footer})
      for (const auto& block : *blocks)
        for (const auto& cell : block.cells)
          if (auto known = read_context(cell.form); !known) return known;
    return {};
  }

  [[nodiscard]] Result<void> send(ChamberProgram& program) {
    if (auto begun = perform("begin_upload", program); !begun) return begun;
    if (!memory_.number_from.empty()) {
      const auto number = items_.read(items_.item(memory_.number_from));
      if (!number) return failure(number.error());
      constexpr double kMostPrograms = 1e6;
      if (!(*number >= 0 && *number <= kMostPrograms))
        return failure(FaultKind::corrupted, place(items_.item(memory_.number_from)),
                       fmt::format("{:g} is not the number of a program", *number));
      program.number = static_cast<int>(*number);
    }
    auto writes = encode_program(memory_, program, [this](const RegisterItem& form) {
      const auto known = contexts_.find({form.decimals, form.unit});
      return known == contexts_.end() ? ItemContext{} : known->second;
    });
    if (!writes) return failure(writes.error());
    writes_ = std::move(*writes);
    report_ = {.program = program.number, .steps = writes_.empty() ? 0 : writes_.back().step + 1};
    for (const auto& one : writes_) {
      if (auto done = write(one); !done) return done;
      ++report_.written;
      report_.steps = std::max(report_.steps, one.step + 1);
    }
    return perform("end_upload", program);
  }

  [[nodiscard]] Result<void> compare() {
    for (const auto& one : writes_) {
      if (one.select) {
        if (auto selected = registers_.write(write_function(one.function, one.words.size()), one.address, one.words);
            !selected)
          return selected;
        continue;
      }
      if (!one.read_back) {
        ++report_.not_readable;
        continue;
      }
      const auto found = read(one);
      if (!found) return failure(found.error());
      if (const auto* line = map_.text_link ? map_.text_link->find_memory_line(one.address) : nullptr;
          line && *found != one.words)
        return failure(FaultKind::mismatch, describe_location(map_, one),
                       describe_difference(*line, *found, one.words));
      for (std::size_t i = 0; i < one.words.size(); ++i)
        if ((*found)[i] != one.words[i])
          return failure(FaultKind::mismatch, describe_location(map_, one),
                         fmt::format("register {} contains {:04X}h after {:04X}h was written", one.address + i,
                                     (*found)[i], one.words[i]));
      ++report_.compared;
    }
    return {};
  }

  /// Ends an upload that failed. A unit without such a command ends it by itself.
  void cancel(const ChamberProgram& program) { (void)perform("cancel_upload", program); }

  [[nodiscard]] const UploadReport& report() const { return report_; }

 private:
  [[nodiscard]] Result<void> read_context(const RegisterItem& form) {
    const ContextNames named{form.decimals, form.unit};
    if (contexts_.contains(named)) return {};
    auto context = drivers::read_context(map_, form, [this](const RegisterItem& item) { return items_.read(item); });
    if (!context) return failure(std::move(context.error()));
    contexts_[named] = *context;
    return {};
  }

  [[nodiscard]] Result<void> write(const MemoryWrite& write) {
    pauses_.rest(memory_.pause);
    auto done = registers_.write(write_function(write.function, write.words.size()), write.address, write.words);
    if (!done) done.error().where = describe_location(map_, write) + ": " + done.error().where;
    return done;
  }

  [[nodiscard]] Result<std::vector<std::uint16_t>> read(const MemoryWrite& write) {
    std::vector<std::uint16_t> all;
    const std::size_t at_most = map_.link.modbus.read_at_most;
    while (all.size() < write.words.size()) {
      const auto count = std::min(at_most, write.words.size() - all.size());
      const auto words =
          registers_.read(ReadFunction::holding_registers, static_cast<std::uint16_t>(write.address + all.size()),
                          static_cast<std::uint16_t>(count));
      if (!words) return words;
      all.insert(all.end(), words->begin(), words->end());
    }
    return all;
  }

  [[nodiscard]] Result<void> perform(const char* command, const ChamberProgram& program) {
    const auto found = map_.sequences.find(command);
    if (found == map_.sequences.end()) return {};
    return items_.perform(found->second, {.program = program.number, .step = memory_.first_step});
  }

  const RegisterMap& map_;
  const ProfileMemory& memory_;
  ItemExchange& items_;
  Registers& registers_;
  Pauses& pauses_;
  std::map<ContextNames, ItemContext> contexts_;
  std::vector<MemoryWrite> writes_;
  UploadReport report_;
};

}  // namespace

Result<std::vector<ProgramStep>> steps_in_memory(const ProfileMemory& memory, const ChamberProgram& program) {
  std::vector<ProgramStep> parts;
  const bool can_guarantee_soak = has_guaranteed_soak(memory);
  for (std::size_t i = 0; i < program.steps.size(); ++i) {
    const auto& step = program.steps[i];
    if (step.duration <= Duration{} || step.duration % memory.finest != Duration{})
      return step_fault(
          i, fmt::format("{:g} s is not a multiple of {:g} s", to_seconds(step.duration), to_seconds(memory.finest)));
    if (step.guaranteed_soak && !can_guarantee_soak) return step_fault(i, "this controller has no guaranteed soak");
    append_parts(memory, step, parts);
  }
  if (parts.empty()) return step_fault(0, "is missing: the program is empty");
  if (memory.end_step) {
    const auto last = parts.back().target;
    parts.push_back({StepKind::end, last, last, memory.end_time, false});
  }
  if (parts.size() > static_cast<std::size_t>(memory.steps_at_most))
    return step_fault(static_cast<std::size_t>(memory.steps_at_most),
                      fmt::format("does not fit: this controller stores {} steps, and the program needs {}",
                                  memory.steps_at_most, parts.size()));
  return parts;
}

Result<std::vector<MemoryWrite>> encode_program(const ProfileMemory& memory, const ChamberProgram& program,
                                                const ContextOf& read_context) {
  const auto steps = steps_in_memory(memory, program);
  if (!steps) return failure(steps.error());
  const Content content{memory, program, *steps, read_context};
  std::vector<MemoryWrite> writes;
  const auto add = [&](const MemoryBlock& block, int index) -> Result<void> {
    auto words = content.words(block, index);
    if (!words) return failure(words.error());
    const auto address = block.address + std::max(index, 0) * memory.stride;
    writes.push_back(
        {static_cast<std::uint16_t>(address), std::move(*words), block.function, block.select, block.read_back, index});
    return {};
  };
  for (const auto& block : memory.header)
    if (auto added = add(block, -1); !added) return failure(added.error());
  for (std::size_t i = 0; i < steps->size(); ++i)
    for (const auto& block : memory.step)
      if (is_written_for(block, (*steps)[i].kind))
        if (auto added = add(block, static_cast<int>(i)); !added) return failure(added.error());
  for (const auto& block : memory.footer)
    if (auto added = add(block, -1); !added) return failure(added.error());
  return writes;
}

Result<ChamberProgram> decode_program(const ProfileMemory& memory, Celsius from, const BlockWords& words_of,
                                      const ContextOf& read_context) {
  const auto header = read_header(memory, words_of, read_context);
  if (!header) return failure(header.error());
  ChamberProgram program{.name = header->name, .soak_band = header->soak_band, .steps = {}};
  auto& steps = program.steps;
  bool has_starts = false;
  for (int i = 0; i < header->step_count; ++i) {
    const auto found = read_step(memory, i, words_of, read_context);
    if (!found) return failure(found.error());
    // Without an end step or a count, a step without a duration was never written.
    const bool has_end = memory.end_step || header->step_count < memory.steps_at_most;
    const bool is_empty = !has_end && !memory.ramps_by_rate && found->duration() <= Duration{};
    if (is_end_mark(*found) || is_empty) break;
    if (steps.empty() && header->start) from = Celsius{*header->start};
    const auto step = make_step(*found, steps.empty() ? from : steps.back().target, i);
    if (!step) return failure(step.error());
    steps.push_back(*step);
    has_starts = has_starts || found->start.has_value();
  }
  if (!has_starts) return program;
  set_ramp_targets(steps);
  // The last of the counted steps is an end step, which only maintains the final set point.
  const bool is_counted = header->step_count < memory.steps_at_most;
  if (memory.end_step && is_counted && std::ssize(steps) == header->step_count) steps.pop_back();
  return program;
}

Result<UploadReport> upload_program(const RegisterMap& map, ItemExchange& items, Registers& registers, Pauses& pauses,
                                    ChamberProgram program) {
  if (!map.memory) return failure(FaultKind::refused, "chamber upload", "its register map describes no profile memory");
  if (auto fits = steps_in_memory(*map.memory, program); !fits) return failure(fits.error());
  Upload upload(map, items, registers, pauses);
  if (auto known = upload.read_contexts(); !known) return failure(known.error());
  auto sent = upload.send(program);
  if (!sent && map.memory->recovery > Duration{}) {
    pauses.rest(map.memory->recovery);
    sent = upload.send(program);
  }
  if (!sent) upload.cancel(program);
  if (!sent) return failure(sent.error());
  if (auto same = upload.compare(); !same) return failure(same.error());
  return upload.report();
}

std::string describe(const UploadReport& report) {
  return fmt::format("{} steps as program {}, {} writes, {} read back and equal{}", report.steps, report.program,
                     report.written, report.compared,
                     report.not_readable > 0 ? fmt::format(", {} that cannot be read back", report.not_readable) : "");
}

}  // namespace gyrotherm::drivers
