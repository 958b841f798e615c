// The commands of the program `tandem`.
#pragma once
#include <CLI/CLI.hpp>

#include "formats/output_file.h"

namespace tandem {

/// Each function adds one command to the program. When it runs, the command sets `status` (0 done, 1 the work failed),
/// and throws std::invalid_argument for a wrong request, other exceptions for work that failed. Results go to `out`.
void add_clash_command(CLI::App& program, DescriptorBuffer& out, int& status);
void add_inspect_command(CLI::App& program, DescriptorBuffer& out, int& status);
void add_run_command(CLI::App& program, DescriptorBuffer& out, int& status);
void add_query_command(CLI::App& program, DescriptorBuffer& out, int& status);
void add_scenes_command(CLI::App& program, DescriptorBuffer& out, int& status);

}  // namespace tandem
