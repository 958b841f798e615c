#include "lanes/cpu_dispatch.h"

namespace tandem {
namespace {

// As long as nothing is chosen, the first entry of a kernel's table chooses: what stands here until Highway was asked,
// and whom constructors of other files' variables find.
constinit const hwy::ChosenTarget unchosen{};

}  // namespace

constinit const hwy::ChosenTarget* chosen_target = &unchosen;

namespace {
[[maybe_unused]] const bool asked = (chosen_target = &hwy::GetChosenTarget()) != nullptr;
}  // namespace

}  // namespace tandem
