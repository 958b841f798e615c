// What `tandem query --list-solvers` prints: the solvers and the table kinds x request. docs/solvers.md has the same.
#pragma once
#include <string>

namespace tandem {

std::string solver_list();

}  // namespace tandem
