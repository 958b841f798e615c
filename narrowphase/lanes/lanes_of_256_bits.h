// Limits kernels to vectors of 256 bits where 512 bits gain nothing. Included once per target before Highway's
// foreach_target.h: no guard. Code after vectors of 512 bits runs slower for a while (figures in
// docs/notes/narrowphase.md), so only kernels that gain more than that use them.
#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS ((HWY_AVX2 - 1) | TANDEM_DISABLED_TARGETS)  // all wider targets, whose bits are lower
