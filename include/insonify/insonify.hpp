#ifndef INSONIFY_INSONIFY_HPP
#define INSONIFY_INSONIFY_HPP

/// All of insonify. In exactly one file of a program define INSONIFY_IMPLEMENTATION before including this: the OBJ
/// reader and the PNG writer are compiled there. What is not named here, these include.
#include <insonify/b_mode.hpp>
#include <insonify/diagnose.hpp>
#include <insonify/doppler.hpp>
#include <insonify/examinations.hpp>
#include <insonify/fwd.hpp>
#include <insonify/geometry/needle.hpp>
#include <insonify/image/m_mode.hpp>
#include <insonify/image/scan_convert.hpp>
#include <insonify/io.hpp>
#include <insonify/motion.hpp>
#include <insonify/paper.hpp>
#include <insonify/scanner.hpp>
#include <insonify/scene/displayed_depth.hpp>
#include <insonify/tracing/paths.hpp>
#include <insonify/tracing/read/ground_truth.hpp>

#endif
// Outside the guard, so that it is reached also after an earlier include or a precompiled header.
#include <insonify/io/implementation.hpp>
