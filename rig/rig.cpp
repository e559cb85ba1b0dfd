#include "rig/rig.hpp"

#include <fmt/format.h>

#include <utility>

#include "drivers/chamber/modbus_chamber.hpp"
#include "drivers/gyro/framed_gyro.hpp"
#include "drivers/line/modbus_tcp.hpp"
#include "drivers/line/tcp_stream.hpp"
#include "drivers/thermometer/lakeshore_218.hpp"
#include "simulator/world.hpp"

namespace gyrotherm {
namespace {

constexpr Duration kSecond = std::chrono::seconds(1);
constexpr Duration kConnectWithin = std::chrono::seconds(2);
/// Less than the sampler's patience: a frame that comes later stays on the line and is there when the next second is
/// read. A read that outlasts the sampler takes its frame away, and of a frame a second every one would be lost.
constexpr Duration kGyroWithin = std::chrono::milliseconds(800);
constexpr Duration kGyroAskedWithin = std::chrono::milliseconds(1500);
constexpr std::uint16_t kSerialServerPort = 4001;  // a serial device server's first line

/// Where each instrument of a rig is, the virtual ones included.
struct Lines {
  LineAddress chamber;
  std::vector<LineAddress> thermometers;
  LineAddress gyro;
};

Lines lines_of(const VirtualInstruments& instruments, std::size_t thermometers) {
  const auto local = [](std::uint16_t port) { return LineAddress{"127.0.0.1", port}; };
  Lines lines{.chamber = local(instruments.chamber_port()), .thermometers = {}, .gyro = local(instruments.gyro_port())};
  for (std::size_t i = 0; i < thermometers; ++i) lines.thermometers.push_back(local(instruments.thermometer_port(i)));
  return lines;
}

/// The file's lines were checked when it was read.
LineAddress checked(const std::string& line, std::uint16_t default_port) {
  return parse_line_address(line, default_port).value();
}

Lines lines_of(const RigFile& file) {
  Lines lines{.chamber = checked(file.chamber_line, file.chamber_map.port),
              .thermometers = {},
              .gyro = checked(file.gyro_line, kSerialServerPort)};
  for (const auto& entry : file.thermometers) lines.thermometers.push_back(checked(entry.line, kSerialServerPort));
  return lines;
}

/// Instruments on their lines, and the sampler that reads them.
class AssembledRig : public Rig {
 public:
  AssembledRig(RigFile file, const Lines& lines) : file_(std::move(file)), gyro_line_(lines.gyro) {
    const auto& map = file_.chamber_map;
    chamber_ = make_modbus_chamber(map, make_modbus_tcp(lines.chamber, map.unit, map.timeout));
    for (std::size_t i = 0; i < lines.thermometers.size(); ++i)
      thermometers_.push_back(thermometer(i, lines.thermometers[i]));
    gyro_ = gyro(kGyroWithin);
  }

  std::vector<Result<std::string>> ask() override {
    std::vector<Result<std::string>> lines{ask_chamber()};
    for (std::size_t i = 0; i < thermometers_.size(); ++i) lines.push_back(ask_thermometer(i));
    lines.push_back(ask_gyro());
    return lines;
  }

  Result<std::vector<std::string>> prepare(Celsius first, const Permit& permit) override {
    auto names = ask_names();
    if (!names) return names;
    const auto state = chamber_->read();
    if (!state) return failure(state.error());
    if (permit)
      if (auto permitted = permit(*state); !permitted) return failure(permitted.error());
    // The gyro's line first, for nothing shall move if it is dead; never start() at a set point that was not taken.
    const auto moved =
        gyro_->open().and_then([&] { return chamber_->head_for(first); }).and_then([&] { return chamber_->start(); });
    if (!moved) return failure(moved.error());
    let_pass(1);
    if (const auto origin = take_origin(); !origin) return failure(origin.error());
    sampler_ = make_sampler();
    return names;
  }

  Sampler& sampler() override { return *sampler_; }
  const RigFile& file() const override { return file_; }

 protected:
  [[nodiscard]] Instruments instruments() {
    Instruments all{.chamber = *chamber_, .thermometers = {}, .gyro = *gyro_};
    for (std::size_t i = 0; i < thermometers_.size(); ++i)
      all.thermometers.push_back({*thermometers_[i], file_.thermometers[i].channels});
    return all;
  }
  void end_sampling() { sampler_.reset(); }

 private:
  /// The sampler that suits the rig's time; its clock starts.
  [[nodiscard]] virtual std::unique_ptr<Sampler> make_sampler() = 0;

  Result<std::string> ask_chamber() {
    const auto name = chamber_->identify();
    if (!name) return failure(name.error());
    const auto state = chamber_->read();
    if (!state) return failure(state.error());
    return fmt::format("chamber: {}, air {:.2f} °C, set point {:.2f} °C", *name, state->air.value,
                       state->set_point.value);
  }

  Result<std::string> ask_thermometer(std::size_t index) {
    const auto name = thermometers_[index]->identify();
    if (!name) return failure(name.error());
    auto line = fmt::format("thermometer {}: {}", index + 1, *name);
    const auto readings = thermometers_[index]->read();
    const auto& channels = file_.thermometers[index].channels;
    for (std::size_t i = 0; i < channels.size(); ++i)
      line += readings[i] ? fmt::format(", {} {:.3f} °C", channels[i], readings[i]->value)
                          : fmt::format(", {} {}", channels[i], readings[i].error().what);
    return line;
  }

  Result<std::string> ask_gyro() {
    const auto asked = gyro(kGyroAskedWithin);
    if (auto opened = asked->open(); !opened) return failure(opened.error());
    let_pass(1);
    if (const auto origin = asked->read(kSecond); !origin) return failure(origin.error());
    let_pass(1);
    const auto count = asked->read(kSecond);
    if (!count) return failure(count.error());
    return fmt::format("gyro: {} frames, {} pulses in {:.6f} s", file_.gyro_frame.name, count->pulses,
                       to_seconds(count->interval));
  }

  Result<std::vector<std::string>> ask_names() {
    std::vector<Result<std::string>> answers{chamber_->identify()};
    for (const auto& thermometer : thermometers_) answers.push_back(thermometer->identify());
    std::vector<std::string> names;
    for (auto& answer : answers) {
      if (!answer) return failure(answer.error());
      names.push_back(std::move(*answer));
    }
    return names;
  }

  /// The first frame may be its whole period away, which is longer than one read waits.
  Result<PulseCount> take_origin() {
    auto origin = gyro_->read(kSecond);
    return origin || origin.error().kind != FaultKind::timeout ? origin : gyro_->read(kSecond);
  }

  std::unique_ptr<Gyro> gyro(Duration within) const {
    return make_framed_gyro(file_.gyro_frame, make_tcp_stream(gyro_line_, kConnectWithin), within);
  }

  std::unique_ptr<Thermometer> thermometer(std::size_t index, const LineAddress& line) const {
    Lakeshore218Timing timing;
    if (file_.simulated) timing.pause = {};
    const auto place = fmt::format("thermometer {}", index + 1);
    return make_lakeshore_218(make_tcp_stream(line, kConnectWithin), place, timing);
  }

  RigFile file_;
  LineAddress gyro_line_;
  std::unique_ptr<Chamber> chamber_;
  std::vector<std::unique_ptr<Thermometer>> thermometers_;
  std::unique_ptr<Gyro> gyro_;
  std::unique_ptr<Sampler> sampler_;  // last: it stops before its instruments go
};

class RealRig final : public AssembledRig {
 public:
  RealRig(RigFile file, Duration already) : AssembledRig(file, lines_of(file)), already_(already), clock_(already) {}
  ~RealRig() override { end_sampling(); }  // its workers read the clock, which goes before the base does
  void let_pass(std::int64_t) override {}
  const Clock& clock() const override { return clock_; }

 private:
  std::unique_ptr<Sampler> make_sampler() override {
    if (already_ == Duration{}) clock_ = SteadyClock();
    return Sampler::workers(instruments());
  }
  Duration already_;
  SteadyClock clock_;
};

class VirtualRig final : public AssembledRig {
 public:
  VirtualRig(RigFile file, Duration already, std::unique_ptr<VirtualInstruments> world)
      : AssembledRig(file, lines_of(*world, file.thermometers.size())),
        world_(std::move(world)),
        clock_(already - kSecond) {}

  void let_pass(std::int64_t seconds) override {
    world_->advance(static_cast<int>(seconds));
    clock_.advance(std::chrono::seconds(seconds));
  }
  const Clock& clock() const override { return clock_; }

 private:
  std::unique_ptr<Sampler> make_sampler() override { return Sampler::inline_calls(instruments()); }
  std::unique_ptr<VirtualInstruments> world_;
  VirtualClock clock_;
};

}  // namespace

Result<std::unique_ptr<VirtualInstruments>> serve_virtual(const RigFile& file, WorldSeed seed,
                                                          std::uint16_t first_port) {
  if (!file.simulated)
    return failure(FaultKind::usage, file.file, "this rig is real; only a virtual one can be simulated");
  const auto parameters = parse_world(file.text, file.file, file.gyro_model.text);
  if (!parameters) return failure(parameters.error());
  VirtualInstrumentsOptions options{
      .chamber = file.chamber_map, .thermometers = {}, .gyro = file.gyro_frame, .first_port = first_port};
  for (const auto& entry : file.thermometers) options.thermometers.push_back({entry.channels});
  return VirtualInstruments::start(World(*parameters, seed), std::move(options));
}

Result<std::unique_ptr<Rig>> Rig::assemble(const RigFile& file, const RigStart& start) {
  if (!file.simulated) return std::make_unique<RealRig>(file, start.already);
  auto world = serve_virtual(file, start.seed);
  if (!world) return failure(world.error());
  (*world)->replay(start.replay);
  return std::make_unique<VirtualRig>(file, start.already, std::move(*world));
}

}  // namespace gyrotherm
