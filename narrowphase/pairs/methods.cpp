// The names of the methods, and which are in this build.
#include "pairs/methods.h"

namespace tandem {

bool is_built(Method method) {
#ifdef TANDEM_PEER_SOLVERS
  constexpr bool with_peers = true;
#else
  constexpr bool with_peers = false;
#endif
  return with_peers || !method_rows[static_cast<std::size_t>(method)].by_peers;
}

std::optional<Method> find_method(std::string_view solver) {
  for (const MethodRow& row : method_rows)
    if (row.info.name == solver && is_built(row.method)) return row.method;
  return std::nullopt;
}

}  // namespace tandem
