// The program `tandem`: its commands, errors and exit status.
#include <fcntl.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <sstream>

#include "commands.h"
#include "formats/input_error.h"
#include "formats/input_limits.h"
#include "option_text.h"

namespace tandem {
namespace {

enum Status { done = 0, work_failed = 1, request_wrong = 2 };

// A closed standard descriptor would be given to the first file opened, which would then receive what is meant for
// stdout.
void occupy_standard_descriptors() {
  for (int descriptor = 0; descriptor <= 2; ++descriptor)
    if (::fcntl(descriptor, F_GETFD) == -1 && ::open("/dev/null", O_RDONLY) != descriptor) return;
}

int complain(std::string_view what, Status status) {
  std::cerr << "tandem: " << shortened(on_one_line(what), limits::message_bytes) << '\n';
  return status;
}

/// Throws with the unexpected arguments and those that the command takes.
[[noreturn]] void refuse_extras(const CLI::App& program) {
  const auto used = program.get_subcommands();
  const CLI::App& command = used.empty() ? program : *used.front();
  const std::vector<std::string> extras = command.remaining();
  std::string names;
  for (const CLI::Option* option : command.get_options())
    names += (names.empty() ? "" : ", ") + option->get_name(false, false);
  refuse_option("argument of " + command.get_name(), extras.empty() ? "" : extras.front(), names);
}

int run_program(int count, char** arguments) {
  CLI::App program("Collision detection: broad and narrow phase at once.", "tandem");
  program.set_version_flag("--version", "tandem " TANDEM_VERSION);
  DescriptorBuffer out(1, "stdout");
  int status = done;
  add_clash_command(program, out, status);
  add_inspect_command(program, out, status);
  add_run_command(program, out, status);
  add_query_command(program, out, status);
  add_scenes_command(program, out, status);
  program.footer("COMMAND --help lists its options.");
  try {
    const std::string first = count > 1 ? arguments[1] : "";
    if (first.empty() || first[0] != '-') {
      const auto commands = program.get_subcommands([](const CLI::App*) { return true; });
      if (std::none_of(commands.begin(), commands.end(), [&](const auto* c) { return c->get_name() == first; }))
        refuse_option("COMMAND", first, "run, query, clash, inspect, scenes, --help");
    }
    program.parse(count, arguments);
  } catch (const CLI::Success& asked) {
    std::ostringstream help, unused;
    program.exit(asked, help, unused);
    out.append(help.str());
  } catch (const CLI::ExtrasError&) {
    refuse_extras(program);
  } catch (const CLI::ParseError& error) {
    throw RequestError(error.what() + std::string(", allowed: what --help lists"));
  }
  out.flush();
  return status;
}

}  // namespace
}  // namespace tandem

int main(int count, char** arguments) {
  using namespace tandem;
  occupy_standard_descriptors();
  std::signal(SIGXFSZ, SIG_IGN);  // a file that exceeds the limit then fails as on a full disk
  std::signal(SIGPIPE, SIG_IGN);  // a write then fails, and temporary files are removed
  try {
    return run_program(count, arguments);
  } catch (const ReaderGone&) {
    return work_failed;
  } catch (const std::invalid_argument& error) {
    return complain(error.what(), request_wrong);
  } catch (const std::bad_alloc&) {
    return complain("out of memory", work_failed);
  } catch (const std::exception& error) {
    return complain(error.what(), work_failed);
  }
}
