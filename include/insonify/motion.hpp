#ifndef INSONIFY_MOTION_HPP
#define INSONIFY_MOTION_HPP

/// Tissue that moves: ready-made maps for `scene::deform`, and the probe that presses into it.
#include <insonify/motion/body_motion.hpp>
#include <insonify/motion/press.hpp>

#endif
