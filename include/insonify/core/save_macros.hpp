// No guard: the first include of every header, which ends with <insonify/core/restore_macros.hpp>.
//
// Other libraries have macros of names that this one uses: near, far, small, min and max (windows.h), check (Unreal),
// emit and slots (Qt). They are put aside for the length of a header, so that it may be included after them.
#pragma push_macro("check")
#pragma push_macro("emit")
#pragma push_macro("far")
#pragma push_macro("max")
#pragma push_macro("min")
#pragma push_macro("near")
#pragma push_macro("slots")
#pragma push_macro("small")
#undef check
#undef emit
#undef far
#undef max
#undef min
#undef near
#undef slots
#undef small
