// What a session draws with, compiled once for all programs of this folder.
#define INSONIFY_IMPLEMENTATION
#include "session.hpp"

template const insonify::image& live::session::frame(const insonify::exec::parallel_unsequenced_policy&);
