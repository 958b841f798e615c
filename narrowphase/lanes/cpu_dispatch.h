#pragma once
#include <hwy/highway.h>

namespace tandem {

/// Which instruction set kernels are taken for, as Highway knows it: its own macro asks for it by a call into a library
/// each time, which costs as much as a small kernel's arithmetic.
extern const hwy::ChosenTarget* chosen_target;

}  // namespace tandem

/// HWY_DYNAMIC_DISPATCH without that call. Where kernels are built for one instruction set there is no choice.
#if HWY_IDE || ((HWY_TARGETS & (HWY_TARGETS - 1)) == 0)
#define TANDEM_DISPATCH(kernel) HWY_STATIC_DISPATCH(kernel)
#else
#define TANDEM_DISPATCH(kernel) (*(HWY_DISPATCH_TABLE(kernel)[tandem::chosen_target->GetIndex()]))
#endif
