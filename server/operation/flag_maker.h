#pragma once
/// FlagMaker: makes the flags of sightline serve, so that each kind is checked and shown in one
/// way.

#include <CLI/CLI.hpp>

#include <string>

#include "core/base/live.h"
#include "server/operation/flag_checks.h"

namespace sightline {

/// The heading in the help for flags that SIGHUP can change by the file of --config.
inline constexpr const char* kLiveFlags = "Changed by SIGHUP, from --config";

/// Adds flags to a command. Each function returns the flag, which belongs to the command. Parsing
/// writes to the given `value`, which must outlive the command.
class FlagMaker {
 public:
  /// `app` must outlive the object.
  explicit FlagMaker(CLI::App& app) : app_(app) {}

  /// Adds an integer of at least 1.
  template <class T>
  CLI::Option* add_count(const char* name, T& value, const char* help) {
    return app_.add_option(name, value, help)->check(positive())->capture_default_str();
  }
  template <class T>
  CLI::Option* add_count(const char* name, Live<T>& value, const char* help) {
    return add_live(name, value, help)->check(positive());
  }
  /// Adds an integer that SIGHUP can change. The caller checks its limits.
  template <class T>
  CLI::Option* add_live(const char* name, Live<T>& value, const char* help) {
    return app_
        .add_option_function<T>(
            name, [&value](const T& given) { value = given; }, help)
        ->default_str(std::to_string(value.get()))
        ->group(kLiveFlags);
  }
  /// Adds a number of seconds, at least `least`.
  CLI::Option* add_seconds(const char* name, double& value, double least, const char* help) {
    const CLI::Validator span([least](std::string& text) { return check_seconds(text, least); },
                              "SECONDS");
    return app_.add_option(name, value, help)->check(span)->capture_default_str();
  }
  /// Adds a number of seconds that SIGHUP can change, at least `least`.
  CLI::Option* add_live_seconds(const char* name, double& value, double least, const char* help) {
    return add_seconds(name, value, least, help)->group(kLiveFlags);
  }

 private:
  static CLI::Validator positive() {
    return {[](std::string& text) { return check_positive_count(text); }, "POSITIVE"};
  }

  CLI::App& app_;
};

/// The least value, in seconds, of flags that limit the time of a request or connection. Limits are
/// in whole milliseconds, so less would be no time at all.
inline constexpr double kLeastSeconds = 0.001;

}  // namespace sightline

// Tests: tests/unit/server/cli_test.cpp
