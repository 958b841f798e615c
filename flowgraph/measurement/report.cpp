// The names of the balancer's actions and of a step's issues.
#include "tandem/flowgraph/report.h"

#include <array>

namespace tandem {

std::string_view name(ExecutorKind kind) {
  constexpr std::array<std::string_view, 5> names{"sequential", "barrier", "fused", "threads", "flowgraph"};
  return names[static_cast<std::size_t>(kind)];
}

std::string_view name(BalanceRule rule) { return rule == BalanceRule::paper ? "paper" : "busy"; }

std::string_view name(StepForm form) {
  constexpr std::array<std::string_view, 4> names{"automatic", "caller", "overlapped", "ordered"};
  return names[static_cast<std::size_t>(form)];
}

std::string_view name(BalanceAction action) {
  constexpr std::array<std::string_view, 5> names{"none", "keep", "change", "confirm", "revert"};
  return names[static_cast<std::size_t>(action)];
}

}  // namespace tandem
