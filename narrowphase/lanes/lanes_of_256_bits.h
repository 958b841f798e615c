// Included before Highway's foreach_target.h by kernels that run no faster with vectors of 512 bits, once a target: no
// guard. What comes after such vectors runs slower for a while (docs/notes/narrowphase.md has figures), so only those
// use them that gain more than that.
#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS ((HWY_AVX2 - 1) | TANDEM_DISABLED_TARGETS)  // all that are wider, as their bits are lower
