// The list of solvers of `tandem query --list-solvers`: the solvers and the table kinds x request. docs/solvers.md
// shows the same.
#pragma once
#include <string>

namespace tandem {

std::string solver_list();

}  // namespace tandem
