/// What make-safe leaves beside the record, by processes of its own: the disk may hang, and nothing waits for it.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "app/guard/armed_file.hpp"
#include "app/guard/child_work.hpp"
#include "app/guard/made_safe_file.hpp"
#include "app/guard/rescue.hpp"
#include "drivers/line/deadline.hpp"

namespace gyrotherm {

class Trail {
 public:
  /// `armed` outlives it.
  Trail(const Armed& armed, std::string because);

  /// Makes it the trace that `status` shows. False if it says nothing new, or has but another reason why nothing was
  /// confirmed, less than a minute after the last. Never waits.
  bool leave(const Rescued& rescued);
  /// The armed file shall go. Never waits.
  void disarm();
  /// Whether all of it has been done within that time.
  [[nodiscard]] bool settle(Duration within);

  /// Whether the run is still the one that was watched, and its armed file there. A disk that does not say so within
  /// two seconds counts as if it were.
  [[nodiscard]] bool is_still_armed();

  /// The trace in words.
  [[nodiscard]] std::string words() const { return in_words(trace_); }

 private:
  void go_on();

  const Armed& armed_;
  MadeSafe trace_;
  std::optional<Deadline> same_until_;
  bool trace_to_write_ = false, to_disarm_ = false;
  std::unique_ptr<ChildWork> writing_;  ///< one at a time, so that the newest trace is the last
  std::unique_ptr<ChildWork> looking_;  ///< likewise, and while the disk hangs none is added
};

}  // namespace gyrotherm
