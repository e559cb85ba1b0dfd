#include "drivers/chamber/upload.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "drivers/chamber/item_context.hpp"

namespace gyrotherm {

namespace {

std::string place_of(const MemoryWrite& write) {
  return write.step < 0 ? fmt::format("profile memory, register {}", write.address)
                        : fmt::format("profile memory, register {}, step {}", write.address, write.step + 1);
}

using Named = std::pair<std::string, std::string>;  ///< items that say decimals and unit

class Upload {
 public:
  Upload(const RegisterMap& map, ItemExchange& items, Registers& registers, Pauses& pauses)
      : map_(map), memory_(*map.memory), items_(items), registers_(registers), pauses_(pauses) {}

  [[nodiscard]] Result<void> learn_contexts();
  [[nodiscard]] Result<void> send(ChamberProgram& program);
  [[nodiscard]] Result<void> compare();
  [[nodiscard]] const UploadReport& report() const { return report_; }

 private:
  [[nodiscard]] Result<void> write(const MemoryWrite& write);
  [[nodiscard]] Result<std::vector<std::uint16_t>> read(const MemoryWrite& write);
  [[nodiscard]] Result<void> perform(const char* command, const ChamberProgram& program);

  const RegisterMap& map_;
  const ProfileMemory& memory_;
  ItemExchange& items_;
  Registers& registers_;
  Pauses& pauses_;
  std::map<Named, ItemContext> contexts_;
  std::vector<MemoryWrite> writes_;
  UploadReport report_;
};

Result<void> Upload::learn_contexts() {
  for (const auto& block : memory_.step)
    for (const auto& cell : block.cells) {
      const Named named{cell.form.decimals, cell.form.unit};
      if (contexts_.contains(named)) continue;
      auto context = context_of(map_, cell.form, [this](const RegisterItem& item) { return items_.read(item); });
      if (!context) return failure(std::move(context.error()));
      contexts_[named] = *context;
    }
  return {};
}

Result<void> Upload::perform(const char* command, const ChamberProgram& program) {
  const auto found = map_.sequences.find(command);
  if (found == map_.sequences.end()) return {};
  return items_.perform(found->second, {.program = program.number, .step = memory_.first_step});
}

Result<void> Upload::write(const MemoryWrite& write) {
  pauses_.rest(memory_.pause);
  auto done = registers_.write(write_function(write.function, write.words.size()), write.address, write.words);
  if (!done) done.error().where = place_of(write) + ": " + done.error().where;
  return done;
}

Result<void> Upload::send(ChamberProgram& program) {
  if (auto begun = perform("begin_upload", program); !begun) return begun;
  if (!memory_.number_from.empty()) {
    const auto number = items_.read(items_.item(memory_.number_from));
    if (!number) return failure(number.error());
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

Result<std::vector<std::uint16_t>> Upload::read(const MemoryWrite& write) {
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

Result<void> Upload::compare() {
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
    for (std::size_t i = 0; i < one.words.size(); ++i)
      if ((*found)[i] != one.words[i])
        return failure(FaultKind::mismatch, place_of(one),
                       fmt::format("register {} holds {:04X}h after {:04X}h was written", one.address + i, (*found)[i],
                                   one.words[i]));
    ++report_.compared;
  }
  return {};
}

}  // namespace

Result<UploadReport> upload_program(const RegisterMap& map, ItemExchange& items, Registers& registers, Pauses& pauses,
                                    ChamberProgram program) {
  if (!map.memory) return failure(FaultKind::refused, "chamber upload", "its register map describes no profile memory");
  if (auto fits = steps_in_memory(*map.memory, program); !fits) return failure(fits.error());
  Upload upload(map, items, registers, pauses);
  if (auto known = upload.learn_contexts(); !known) return failure(known.error());
  auto sent = upload.send(program);
  if (!sent && map.memory->recovery > Duration{}) {
    pauses.rest(map.memory->recovery);
    sent = upload.send(program);
  }
  if (!sent) return failure(sent.error());
  if (auto same = upload.compare(); !same) return failure(same.error());
  return upload.report();
}

std::string in_words(const UploadReport& report) {
  return fmt::format(
      "{} steps as program {}, {} writes, {} read back and the same{}", report.steps, report.program, report.written,
      report.compared,
      report.not_readable > 0 ? fmt::format(", {} that this controller does not give back", report.not_readable) : "");
}

}  // namespace gyrotherm
