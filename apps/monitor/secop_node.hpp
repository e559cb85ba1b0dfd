// SPDX-License-Identifier: Apache-2.0
/// A SEC node of SECoP 1.0 (Sample Environment Communication Protocol, 2019-09-16) that can be read and not changed:
/// its modules as plain data, and what it answers to a line. Nothing of a socket or of a run is in here.
#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace gyrotherm::monitor {

inline constexpr std::size_t kLongestSecopLine = 1024;  ///< bytes without the line's end; a longer one is refused
inline constexpr const char* kSecopIdentity = "ISSE&SINE2020,SECoP,V2019-09-16,v1.0";

/// A parameter and what is known of it now: a value, or why there is none.
struct SecopParameter {
  std::string name;         ///< letters, digits and underscores, at most 63
  std::string description;  ///< one sentence
  std::string datainfo;     ///< its type as JSON: {"type": "double", "unit": "K"}
  std::string value;        ///< as JSON; of one that failed the class of the error, as "HardwareError"
  std::string trouble;      ///< why it has no value; empty: it has one
  double t{};               ///< when that was measured or came to be, in s since 1970
  bool measured{};          ///< an equal value of another time is news
};
struct SecopModule {
  std::string name;         ///< as of a parameter; no two are equal in small letters
  std::string description;  ///< one sentence
  std::string group;        ///< of modules; empty: none
  std::vector<SecopParameter> parameters;
};
struct SecopNode {
  std::string equipment_id;
  std::string description;
  std::string firmware;
  std::vector<SecopModule> modules;

  [[nodiscard]] const SecopModule* find(std::string_view module) const;
};

/// `name` with an underscore for each character that an identifier may not have, another name than those in `taken`,
/// which gets it in small letters.
[[nodiscard]] std::string secop_name(std::string_view name, std::set<std::string>& taken);

/// The structure report, one line of JSON in ASCII: all that does not change while a node is what it is.
[[nodiscard]] std::string structure_of(const SecopNode& node);

/// What a client has asked to be told of.
struct SecopSession {
  bool everything{};
  std::set<std::string> modules{};  ///< where it is not everything
  [[nodiscard]] bool hears(const std::string& module) const { return everything || modules.contains(module); }
  [[nodiscard]] bool is_active() const { return everything || !modules.empty(); }
};

/// A node as it is now, with its structure report, which is made once.
struct SecopState {
  SecopNode node;
  std::string structure;
};

/// The lines that answer a client's line, which comes without its end; at least one. `utc_s` is the time of now.
[[nodiscard]] std::string answer_secop(const SecopState& state, SecopSession& session, std::string_view line,
                                       double utc_s);
/// The answer to a line that is too long.
[[nodiscard]] std::string refuse_long_secop_line();

/// The lines that tell of what is new in `now`; both nodes have the same structure.
[[nodiscard]] std::string secop_news(const SecopNode& before, const SecopNode& now, const SecopSession& session);

}  // namespace gyrotherm::monitor
