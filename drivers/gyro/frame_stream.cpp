#include "drivers/gyro/frame_stream.hpp"

#include <utility>

#include "core/toml_reader.hpp"

namespace gyrotherm {

namespace {

constexpr Vocabulary<char, 3> kParityWords{{{"none", 'N'}, {"even", 'E'}, {"odd", 'O'}}};

GyroPort read_port(const TomlTable& table) {
  GyroPort port;
  port.baud = bounded<std::uint32_t>(table, "baud", table.integer("baud"), 50, 20'000'000);
  port.data_bits = bounded<int>(table, "data_bits", table.integer("data_bits", 8), 5, 8);
  port.parity = one_of(kParityWords, table, "parity", "none");
  port.stop_bits = bounded<int>(table, "stop_bits", table.integer("stop_bits", 1), 1, 2);
  return port;
}

std::vector<GyroCommand> read_commands(const TomlTable& root, const char* key) {
  std::vector<GyroCommand> commands;
  for (const auto& table : root.tables(key)) {
    GyroCommand command{.send = table.text("send"), .wait = table.duration("wait", Duration::zero()), .reply = {}};
    command.reply = table.text("reply", "");
    if (command.send.empty()) table.mistake("send", "nothing to send");
    if (!command.reply.empty() && command.wait <= Duration::zero())
      table.mistake("wait", "a reply is expected within no time, expected a positive duration");
    commands.push_back(std::move(command));
  }
  return commands;
}

}  // namespace

Result<GyroStream> parse_gyro_stream(std::string_view text, const std::string& file, const std::string& axis) {
  const auto parsed = TomlTable::parse(text, file);
  if (!parsed) return failure(parsed.error());
  GyroStream stream;
  stream.text = text;
  (void)parsed->choice("schema", {"gyrotherm-gyro-stream/1"});
  stream.name = parsed->text("name");
  stream.vendor = parsed->text("vendor");
  stream.source = parsed->text("source");
  stream.confidence = parsed->choice("confidence", {"verified", "manual", "secondary"});
  stream.port = read_port(parsed->table("port"));
  stream.start = read_commands(*parsed, "start");
  stream.stop = read_commands(*parsed, "stop");
  stream.frame = read_frame_format(parsed->table("frame"), axis);
  if (auto verdict = parsed->verdict(); !verdict) return failure(std::move(verdict.error()));
  return stream;
}

}  // namespace gyrotherm
