/// What a frame is drawn with: fast, where the rest is small.
#include "../session.hpp"

template const insonify::image& live::session::frame(const insonify::exec::parallel_unsequenced_policy&);
