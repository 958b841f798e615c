// Drives a headless Chromium.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tandem::bench {

/// A headless Chromium, driven over its debugging pipe (Chrome DevTools Protocol). Ends with the object. Every call
/// throws std::runtime_error if the browser does not answer within a minute.
class Browser {
 public:
  /// `folder`: for its profile.
  Browser(const std::string& program, const std::filesystem::path& folder);
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  void open(const std::string& url);
  /// Sends a command of the DevTools protocol to the page; returns its result. Throws std::runtime_error for an error.
  nlohmann::json call(const std::string& method, nlohmann::json parameters = nlohmann::json::object());
  /// The value of a JavaScript expression; for a promise its result. Throws std::runtime_error for an exception.
  nlohmann::json evaluate(const std::string& expression);
  /// Waits until the expression is true; false after `seconds`.
  bool wait_for(const std::string& expression, double seconds);
  /// Errors and warnings on the console, uncaught exceptions, refused requests; and every URL that was requested.
  const std::vector<std::string>& complaints() const { return complaints_; }
  const std::vector<std::string>& requests() const { return requests_; }

 private:
  nlohmann::json receive();
  void take(const nlohmann::json& event);

  int process_ = -1, in_ = -1, out_ = -1;
  int last_ = 0;
  std::string session_, waiting_;
  std::vector<std::string> complaints_, requests_;
};

}  // namespace tandem::bench
