// No guard: the last include of every header. Restores what <insonify/core/save_macros.hpp> has put aside.
#pragma pop_macro("check")
#pragma pop_macro("emit")
#pragma pop_macro("far")
#pragma pop_macro("max")
#pragma pop_macro("min")
#pragma pop_macro("near")
#pragma pop_macro("slots")
#pragma pop_macro("small")
