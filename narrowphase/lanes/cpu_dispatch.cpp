// The instruction set that kernels use.
#include "lanes/cpu_dispatch.h"

namespace tandem {
namespace {

// Until an instruction set is chosen, the first entry of a kernel's table chooses it: this is the value until Highway
// was queried, also for constructors of other files' variables.
constinit const hwy::ChosenTarget unchosen{};

}  // namespace

constinit const hwy::ChosenTarget* chosen_target = &unchosen;

namespace {
[[maybe_unused]] const bool asked = (chosen_target = &hwy::GetChosenTarget()) != nullptr;
}  // namespace

}  // namespace tandem
