// Drives a headless Chromium.
#include "browser.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <stdexcept>
#include <thread>

namespace tandem::bench {

using nlohmann::json;

Browser::Browser(const std::string& program, const std::filesystem::path& folder) {
  int to[2], from[2];
  if (pipe(to) != 0 || pipe(from) != 0) throw std::runtime_error("no pipe");
  const std::string profile = "--user-data-dir=" + folder.string();
  const char* const arguments[] = {program.c_str(),
                                   "--headless",
                                   "--no-sandbox",
                                   "--disable-dev-shm-usage",
                                   "--no-first-run",
                                   "--use-angle=swiftshader",
                                   "--enable-unsafe-swiftshader",
                                   "--remote-debugging-pipe",
                                   profile.c_str(),
                                   "about:blank",
                                   nullptr};
  process_ = fork();
  if (process_ < 0) throw std::runtime_error("no process");
  if (process_ == 0) {
    setpgid(0, 0);
    // The browser reads commands from descriptor 3 and answers on 4; the pipes' ends are moved out of the way first.
    const int in = fcntl(to[0], F_DUPFD, 10), out = fcntl(from[1], F_DUPFD, 10), null = ::open("/dev/null", O_RDWR);
    dup2(in, 3), dup2(out, 4), dup2(null, 1), dup2(null, 2);
    for (int fd = 5; fd < 64; ++fd) close(fd);
    execv(program.c_str(), const_cast<char* const*>(arguments));
    _exit(127);
  }
  close(to[0]), close(from[1]);
  in_ = to[1], out_ = from[0];
  const json target = call("Target.createTarget", {{"url", "about:blank"}});
  session_ = call("Target.attachToTarget", {{"targetId", target.at("targetId")}, {"flatten", true}}).at("sessionId");
  for (const char* domain : {"Runtime.enable", "Log.enable", "Page.enable", "Network.enable"}) call(domain);
}

Browser::~Browser() {
  kill(-process_, SIGKILL);
  waitpid(process_, nullptr, 0);
  close(in_), close(out_);
}

json Browser::receive() {
  for (std::size_t end; (end = waiting_.find('\0')) == std::string::npos;) {
    pollfd ready{out_, POLLIN, 0};
    if (poll(&ready, 1, 60'000) <= 0) throw std::runtime_error("the browser does not answer");
    char bytes[65536];
    const ssize_t count = read(out_, bytes, sizeof bytes);
    if (count <= 0) throw std::runtime_error("the browser went away");
    waiting_.append(bytes, static_cast<std::size_t>(count));
  }
  const std::size_t end = waiting_.find('\0');
  json message = json::parse(waiting_.substr(0, end));
  waiting_.erase(0, end + 1);
  return message;
}

void Browser::take(const json& event) {
  const std::string method = event.value("method", "");
  const json parameters = event.value("params", json::object());
  if (method == "Runtime.exceptionThrown") complaints_.push_back(parameters.dump());
  if (method == "Log.entryAdded" && parameters.at("entry").at("level") != "verbose" &&
      parameters.at("entry").at("level") != "info")
    complaints_.push_back(parameters.at("entry").dump());
  if (method == "Runtime.consoleAPICalled" &&
      (parameters.at("type") == "error" || parameters.at("type") == "warning" || parameters.at("type") == "assert"))
    complaints_.push_back(parameters.at("args").dump());
  if (method == "Network.requestWillBeSent") requests_.push_back(parameters.at("request").at("url"));
}

json Browser::call(const std::string& method, json parameters) {
  json message{{"id", ++last_}, {"method", method}, {"params", std::move(parameters)}};
  if (!session_.empty()) message["sessionId"] = session_;
  const std::string text = message.dump() + '\0';
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t count = write(in_, text.data() + at, text.size() - at);
    if (count <= 0) throw std::runtime_error("the browser went away");
    at += static_cast<std::size_t>(count);
  }
  for (;;) {
    const json answer = receive();
    if (!answer.contains("id")) {
      take(answer);
    } else if (answer.at("id") == last_) {
      if (answer.contains("error")) throw std::runtime_error(method + ": " + answer.at("error").dump());
      return answer.at("result");
    }
  }
}

void Browser::open(const std::string& url) { call("Page.navigate", {{"url", url}}); }

json Browser::evaluate(const std::string& expression) {
  const json answer =
      call("Runtime.evaluate", {{"expression", expression}, {"awaitPromise", true}, {"returnByValue", true}});
  if (answer.contains("exceptionDetails")) throw std::runtime_error(answer.at("exceptionDetails").dump());
  return answer.at("result").value("value", json());
}

bool Browser::wait_for(const std::string& expression, double seconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end) {
    if (evaluate(expression) == true) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return false;
}

}  // namespace tandem::bench
