// The choice of a kernel's build by instruction set.
#pragma once
#include <hwy/highway.h>

namespace tandem {

/// The instruction set chosen for kernels, as Highway knows it: Highway's own macro calls a library function each time,
/// which costs as much as the arithmetic of a small kernel.
extern const hwy::ChosenTarget* chosen_target;

}  // namespace tandem

/// HWY_DYNAMIC_DISPATCH without that call. Kernels that are built for one instruction set have no choice.
#if HWY_IDE || ((HWY_TARGETS & (HWY_TARGETS - 1)) == 0)
#define TANDEM_DISPATCH(kernel) HWY_STATIC_DISPATCH(kernel)
#else
#define TANDEM_DISPATCH(kernel) (*(HWY_DISPATCH_TABLE(kernel)[tandem::chosen_target->GetIndex()]))
#endif
