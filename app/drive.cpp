#include "app/drive.hpp"

#include <fmt/format.h>

#include <QCoreApplication>
#include <QSocketNotifier>
#include <QTimer>
#include <chrono>
#include <utility>

#include "app/interrupt.hpp"

namespace gyrotherm {
namespace {

using std::chrono::steady_clock;

constexpr auto kLongestBatch = std::chrono::milliseconds(500);
constexpr auto kLongestFarewell = std::chrono::seconds(3);  ///< to the disk, of a run that was told to stop
constexpr int kTicksPerLook = 64;                           ///< how often the wall clock is looked at

void show(Console& console, const Profile& profile, const Experiment& experiment) {
  const auto left = to_seconds(time_left(profile, experiment.state()));
  const auto done = static_cast<double>(experiment.next_slot());
  console.progress(profile.name, done + left > 0 ? done / (done + left) : 1);
}

Result<void> sync(Console& console, Store& store) {
  const auto last = store.sync();
  if (!last) return failure(last.error());
  if (console.json) console.data(fmt::format("{{\"acknowledged\": {}}}\n", *last));
  return {};
}

Result<Outcome> stopped(Console& console, Store& store, const Instant& now) {
  if (auto noted = store.append_event({now, EventKind::interrupted, "stopped by a signal"}); !noted)
    return failure(noted.error());
  if (!store.settle(kLongestFarewell))
    console.say(fmt::format("warning: {} s are not on the disk: {}", store.health().backlog_s, store.health().trouble));
  if (auto synced = sync(console, store); !synced) return failure(synced.error());
  return failure(FaultKind::interrupted, "", "stopped");
}

/// One real-time tick and what follows from it.
class RealTime {
 public:
  RealTime(Console& console, const Profile& profile, Experiment& experiment, Rig& rig, Store& store)
      : console_(console), profile_(profile), experiment_(experiment), rig_(rig), store_(store) {
    timer_.setTimerType(Qt::PreciseTimer);
    timer_.setSingleShot(true);
    timer_.callOnTimeout([this] { tick(); });
  }

  Result<Outcome> run() {
    QSocketNotifier interrupt(interrupt_descriptor(), QSocketNotifier::Read);
    QObject::connect(&interrupt, &QSocketNotifier::activated, [this] {
      if (!ended_) end(stopped(console_, store_, rig_.clock().now()));
    });
    arm();
    QCoreApplication::exec();
    return result_;
  }

 private:
  /// The timer is armed each time for the next whole second of the rig's clock: slot k is ticked at its end, k + 1 s.
  void arm() {
    const auto now = rig_.clock().now().since_start;
    const auto next_second = std::chrono::floor<std::chrono::seconds>(now) + std::chrono::seconds(1);
    timer_.start(std::chrono::ceil<std::chrono::milliseconds>(next_second - now));
  }

  /// The loop may still deliver what was due with the event that ended it; then nothing more is to be recorded.
  void end(Result<Outcome> result) {
    ended_ = true;
    timer_.stop();
    result_ = std::move(result);
    QCoreApplication::quit();
  }

  void tick() {
    if (ended_) return;
    const auto slot = rig_.clock().now().since_start / std::chrono::seconds(1) - 1;
    if (slot >= experiment_.next_slot()) {
      auto outcome = experiment_.tick(slot);
      if (const auto synced = sync(console_, store_); !synced && outcome) outcome = failure(synced.error());
      show(console_, profile_, experiment_);
      if (!outcome || *outcome != Outcome::going_on) return end(std::move(outcome));
    }
    arm();
  }

  Console& console_;
  const Profile& profile_;
  Experiment& experiment_;
  Rig& rig_;
  Store& store_;
  QTimer timer_;
  bool ended_ = false;
  Result<Outcome> result_ = Outcome::going_on;  ///< once ended
};

}  // namespace

Result<Outcome> drive_virtual(Console& console, const Profile& profile, Experiment& experiment, Rig& rig,
                              Store& store) {
  auto last_sync = steady_clock::now();
  for (;;) {
    rig.let_pass(1);
    const auto outcome = experiment.tick(experiment.next_slot());
    if (!outcome) return outcome;
    const bool ended = *outcome != Outcome::going_on;
    if (!ended && experiment.next_slot() % kTicksPerLook != 0) continue;
    if (interrupted() && !ended) return stopped(console, store, rig.clock().now());
    if (!ended && steady_clock::now() - last_sync < kLongestBatch) continue;
    if (auto synced = sync(console, store); !synced) return failure(synced.error());
    last_sync = steady_clock::now();
    show(console, profile, experiment);
    if (ended) return outcome;
  }
}

Result<Outcome> drive_real(Console& console, const Profile& profile, Experiment& experiment, Rig& rig, Store& store) {
  int argc = 0;
  QCoreApplication application(argc, nullptr);
  return RealTime(console, profile, experiment, rig, store).run();
}

}  // namespace gyrotherm
